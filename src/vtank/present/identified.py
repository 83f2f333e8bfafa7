"""An identification as it is printed and as it is kept: a page of tables, and a folder with everything."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..estimate.comparison import Comparison
from ..plant.parameters import slot
from ..plant.truth import load_truth
from ..record import read_truth, results_folder, utf8
from .blocks import Block, Heading, Picture, Table
from .document import csv_text, markdown
from .fit_picture import fit_picture
from .identification import NAMES, sheets
from .identification_json import IDENTIFICATION, identification

__all__ = ["IDENTIFICATION", "identification", "known_truth", "page", "tables", "write_folder"]


def known_truth(truth: str | Path) -> dict[str, float]:
    """Parameters by name, SI, of a preset or of the first run in a truth.json; InputError where there are none."""
    path = Path(truth)
    if path.suffix == ".json" or path.is_dir():
        try:
            parameters = (read_truth(path) or {})["runs"][0]["parameters"]
            return {name: float(parameters.get(name, 0.0)) for name in NAMES}
        except (AttributeError, IndexError, KeyError, TypeError, ValueError):
            raise InputError(f"{truth}: no runs with parameters in it, expected the truth.json of a data set") from None
    p = load_truth(truth).vector()
    return {name: float(p[slot(name)]) for name in NAMES}


def tables(found: Sequence[Comparison], truth: Mapping[str, float] | None, method: str = "all") -> list[Table]:
    """The tables of all models; method: "paper" for those of the paper's methods alone."""
    by_name = {sheet.name: sheet for c in found for sheet in sheets(c, truth)}
    linear = by_name.pop("linear_model", None)  # the same for all models
    everything = [*by_name.values(), *([linear] if linear else [])]
    return [t for t in everything if method != "paper" or t.name.endswith(("_methods", "linear_model"))]


def page(everything: Sequence[Table]) -> list[Table]:
    """The tables that answer the question: the parameters of every model, or where they are left out, all."""
    return [table for table in everything if table.name.endswith("_parameters")] or list(everything)


def write_folder(
    path: Path | str, everything: Sequence[Table], found: Sequence[Comparison], content: dict[str, Any]
) -> None:
    """Markdown, one CSV per table, one picture per run, and the JSON; the folder appears whole or not at all."""
    blocks: list[Block] = [Heading(f"Identification of {content['dataset']}", 1), *everything]
    blocks.append(Heading("Measured and simulated"))
    files = {f"{table.name}.csv": csv_text(table.header, table.rows).encode() for table in everything}
    for i, seen in enumerate(found[0].runs):
        files[f"{seen.name}.png"] = fit_picture(found, i)
        blocks.append(Picture(f"{seen.name}.png", f"{seen.name}: free run of every model"))
    files["identification.md"] = utf8(markdown(blocks))
    with results_folder(path, IDENTIFICATION, content) as folder:
        for name, data in files.items():
            (folder / name).write_bytes(data)
