"""What the documents name is there: files of the repository, and modules of vtank by their place in it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DOCUMENTS = [
    path
    for folder in (".", "models", "scenarios", "scenarios/campaigns", "benchmarks")
    for path in (ROOT / folder).glob("*.md")
]
PLACE = re.compile(r"`((?:\w+/)*\w+\.(?:py|md|xml|toml)|src/[\w/]*|\w+(?:/\w+)*/|(?:diagnose|estimate|models)/\w+)`")
LINK = re.compile(r"\]\(([^):#]+)\)")
OWN = {
    "name.toml",
    "mine.xml",
    "mine.toml",
    "mine-truth.toml",
    "mine-sway.toml",
    "thrusters.toml",
    "dive.toml",
    "src/vtank/effects/wave_making.py",
    "journal/",
}  # made by whoever follows the document


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_every_file_that_a_document_names_is_there(document: Path) -> None:
    text = document.read_text(encoding="utf-8")
    found = {name for name in PLACE.findall(text) + LINK.findall(text)} - OWN
    folders = (document.parent, ROOT, ROOT / "src" / "vtank", ROOT / "models")
    gone = sorted(name for name in found if not any((folder / name).exists() for folder in folders))
    assert not gone, f"{document.name} names {', '.join(gone)}"
    assert len(found) > 15 or document != ROOT / "README.md"
