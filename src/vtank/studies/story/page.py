"""The start page of the story, from its steps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...present import Block, Heading, Links, Paragraph, Terms, document
from ...record import write_text
from .step import Step

TITLE = "What a simulator lacked, found from a recording"
ABOUT = (
    "A vehicle was flown in a virtual tank with something at work that its simulator does not know. What it was lay "
    "sealed while vtank compared recording and simulator, and was opened at the end."
)
FILES = (
    ("gap.html", "the whole diagnosis of the Phoenix: where, which, how far"),
    ("bluerov2/gap.html", "the whole diagnosis of the BlueROV2"),
    ("recording/manifest.json", "the recording as a data set, one CSV file for each experiment; second/ likewise"),
    ("gap.toml", "the corrected simulator: fly it with vtank run --truth, predict a recording with vtank predict"),
    ("withheld/phoenix.toml", "what the diagnosis was not told"),
)
COMMANDS = (
    ("vtank demo --seed 7 --out other", "another cause, drawn from another seed"),
    ("vtank diagnose dive.csv --nominal none --report gap.html", "a recording of your own"),
    ("vtank view paper-ds1 --film ds1.mp4", "any experiment as a film; without --film in a window"),
    ("vtank reproduce", "the paper's tables and figures, and a study of its estimator"),
)


def write_page(folder: Path, steps: Sequence[Step], complete: bool) -> None:
    """Write index.html; links go to what is there."""
    cards = [(what, (Paragraph(detail, answer),)) for what, answer, detail in (s.card for s in steps if s.card)]
    page: list[Block] = [Heading(TITLE, 1), Paragraph(ABOUT), Terms(tuple(cards))]
    for number, step in enumerate(steps, 1):
        page += [Heading(f"{number}. {step.title}"), Paragraph(step.text), *step.blocks]
    if not complete:
        page.append(Paragraph("A whole vehicle, the BlueROV2, is being flown: load this page again in a while."))
    page += [
        Heading("Look closer"),
        Links(tuple((path, text) for path, text in FILES if (folder / path).exists())),
        Heading("Go on"),
        *(Paragraph(text, command) for command, text in COMMANDS),
    ]
    write_text(folder / "index.html", document.html("vtank demo", page))
