"""The report as one HTML file: nothing is loaded from anywhere, and a policy in the file forbids it."""

from __future__ import annotations

import json
from html import escape
from importlib import resources
from pathlib import Path

from .. import __version__
from ..diagnose.diagnosis import Diagnosis
from ..diagnose.localise.where import locate
from ..record.atomic import write_text
from . import sections
from .words import Document

MOST_NAMES = 6  # runs named in the title
POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"

PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="{policy}">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<link rel="icon" href="data:,">
<title>{title}</title>
<style>
{style}</style>
</head>
<body>
<main>
<header><span class="what">{title}</span>
<button id="theme" type="button" hidden>Dark</button></header>
{body}
<footer>Made by vtank {version}, seed {seed}. The file is complete in itself and loads nothing.</footer>
</main>
<script>
{script}</script>
</body>
</html>
"""


def write_report(path: Path | str, diagnosis: Diagnosis, document: Document) -> None:
    """Write the report of a diagnosis and its complete document; InputError where it cannot be written."""
    write_text(path, report_html(diagnosis, document))


def report_html(diagnosis: Diagnosis, document: Document) -> str:
    """The report as HTML; parts that the document lacks (shrink, next_experiment) are said to be missing."""
    data = locate(diagnosis.selection, diagnosis.verdict, diagnosis.probabilities)
    body = (
        sections.opening(document, data),
        sections.how_far(document, data),
        sections.where(document, data),
        sections.which(document),
        sections.estimates(diagnosis, document),
        sections.what_next(document),
        all_numbers(document),
    )
    return PAGE.format(
        title=escape(title(diagnosis)),
        policy=POLICY,
        style=asset("style.css"),
        script=asset("theme.js"),
        body="\n".join(body),
        version=escape(__version__),
        seed=diagnosis.seed,
    )


def title(diagnosis: Diagnosis) -> str:
    """What was diagnosed."""
    names = [run.name for run in diagnosis.selection.setting.runs]
    shown = ", ".join(names[:MOST_NAMES]) + (", \N{HORIZONTAL ELLIPSIS}" if len(names) > MOST_NAMES else "")
    return f"Gap diagnosis of {len(names)} run{'s' * (len(names) > 1)}: {shown}"


def all_numbers(document: Document) -> str:
    """The whole document, to be copied."""
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
    return f"<details><summary>All numbers (JSON)</summary><pre>{escape(text)}</pre></details>"


def asset(name: str) -> str:
    """The text of a file beside this module."""
    return resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
