"""The blocks of code in the documents, and what runs them: nothing is passed over unless it is run elsewhere."""

from __future__ import annotations

import re
import shlex
import subprocess
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from vtank.cli import main

ROOT = Path(__file__).parents[1]
MADE = {"out", "reproduction", "build", "dist"}  # folders of make, beside those that begin with a dot
DOCUMENTS = sorted(
    path for path in ROOT.rglob("*.md")
    if not any(part in MADE or part.startswith(".") for part in path.relative_to(ROOT).parts)
)  # fmt: skip
LANGUAGES = ("sh", "python", "toml", "xml", "text")
FENCE = re.compile(r"^```(\w*)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """A block: its language, the file that it is ("" where it is none), its text, its chapter and where it stands."""

    language: str
    file: str
    text: str
    chapter: str
    place: str


def blocks(document: Path) -> list[Block]:
    """The fenced blocks of a document, in their order."""
    text, found = document.read_text(encoding="utf-8"), []
    for m in FENCE.finditer(text):
        above = text[: m.start()]
        chapter = above.rpartition("\n## ")[2].partition("\n")[0]
        found.append(Block(m[1], m[2] or "", m[3], chapter, f"{document.relative_to(ROOT)}:{above.count(chr(10)) + 1}"))
    return found


def commands(block: Block) -> Iterator[str]:
    """The commands of a block, without their comments."""
    for line in block.text.splitlines():
        if words := shlex.split(line, comments=True):
            yield shlex.join(words)


def follow(found: list[Block], elsewhere: dict[str, str]) -> None:
    """Write each file and run each command of some blocks, in the current folder.

    elsewhere: command -> the test that runs it, `file.py: words that stand in it`.
    """
    for block in found:
        if block.file:
            Path(block.file).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            exec(compile(block.text, block.place, "exec"), {"__name__": "__main__"})
        elif block.language == "sh":
            for command in commands(block):
                obey(command, block.place, elsewhere)


def obey(command: str, place: str, elsewhere: dict[str, str]) -> None:
    """Run a command of vtank; of others see that there is what they ask for."""
    program, *words = shlex.split(command)
    if command in elsewhere:
        name, _, said = elsewhere[command].partition(": ")
        assert said in (ROOT / "tests" / name).read_text(encoding="utf-8"), f"{place}: {command}: not in {name}"
    elif program == "vtank":
        assert main(words) == 0, f"{place}: {command}"
    elif program == "make":
        assert subprocess.run(["make", "-n", "-C", ROOT, *words], capture_output=True, check=False).returncode == 0, (
            place
        )
    elif (program, words[0]) == ("pip", "install"):
        extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
        assert all(re.fullmatch(r"vtank\[(\w+)\]", word)[1] in extras for word in words[1:]), f"{place}: {command}"  # type: ignore[index]
    elif program == "python":
        assert (ROOT / words[0]).is_file(), f"{place}: {command}"
    else:
        raise AssertionError(f"{place}: nothing here runs {command}")
