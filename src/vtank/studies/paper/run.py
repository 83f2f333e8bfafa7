"""The reproduction from end to end: flown campaigns in; tables, figures, study and findings out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from ...experiment import Result, plan_all, provenance
from ...experiment import fly as simulated
from ...present import Block, Heading, Links, Paragraph, Picture
from ...present.document import csv_text, html, markdown
from ...record import Kind, write_dataset
from ...resources import TRUTHS
from ..stage import Stage, silent
from . import findings
from .campaign import PIECES, SCENARIOS, Campaign, identify_campaign
from .evidence import Results, filled
from .joint import MULTIPLES, READINGS, STEPS_S, Joint, judge
from .joint_figures import JOINT_PICTURES
from .overview import overview
from .paper_figures import plan
from .practice import practise
from .published import published
from .study import experiments, levels, study, study_csv
from .study_figures import STUDY_PICTURES as OF_STUDY
from .tables import paper_form, tables_csv

STUDY_PICTURES = JOINT_PICTURES | OF_STUDY
Drawings = Mapping[str, tuple[str, Callable[..., bytes]]]  # file name without suffix -> caption, drawing


@dataclass(frozen=True)
class Effort:
    """How many seeds the study and the paper's comparisons get at each T, and how many worlds the joint judgement."""

    study: int
    worlds: int
    practice: int


REPRODUCTION = Kind("results of vtank reproduce", "reproduction.json", "vtank.reproduction/1")
FULL = Effort(12, 96, 4)
QUICK = Effort(3, 18, 1)  # about 25 s on one core


def fly(truths: Sequence[str], seed: int, progress: Callable[[float], None] | None = None) -> dict[str, list[Result]]:
    """The four experiments in the tank with each truth: truth -> results."""
    plans = [plan for truth in truths for plan in plan_all(SCENARIOS, seed=seed, truth=truth)]
    results = simulated(plans, "tank", 2, progress)
    return {truth: results[i * len(SCENARIOS) : (i + 1) * len(SCENARIOS)] for i, truth in enumerate(truths)}


def reproduce(
    folder: Path, flights: Mapping[str, Sequence[Result]], seed: int, effort: Effort = FULL, stage: Stage = silent
) -> Results:
    """Identify, study and write everything into an existing empty folder; returns what the pages are made of.

    flights: truth -> results of the four experiments. The study compares all truths whichever were flown.
    """
    with stage("identifying", len(flights) * PIECES) as advance:
        campaigns = {truth: identify_campaign(results, advance) for truth, results in flights.items()}
    results = investigate(campaigns, seed, effort, stage)
    write_results(folder, results, stage)
    return results


def investigate(campaigns: dict[str, Campaign], seed: int, effort: Effort, stage: Stage = silent) -> Results:
    """The study, the joint judgement and the paper's comparisons on many seeds."""
    chosen = levels()
    work = len(TRUTHS) * len(experiments(chosen)) + effort.worlds + len(TRUTHS)
    with stage("studying the estimator", work) as advance:
        return Results(
            study(seed, effort.study, advance, chosen=chosen),
            judge(seed, effort.worlds, advance),
            practise(seed, effort.practice, advance),
            campaigns,
        )


def write_flights(folder: Path, flights: Mapping[str, Sequence[Result]]) -> None:
    """One data set for each truth, `folder`/<truth>, as `vtank run` writes them."""
    for truth, results in flights.items():
        write_dataset(folder / truth, [result.run for result in results], *provenance(results, "tank"))


def write_results(folder: Path, results: Results, stage: Stage = silent) -> None:
    """Pages, tables and figures."""
    drawings = {truth: plan(campaign) for truth, campaign in results.campaigns.items()}
    with stage("drawing", sum(map(len, drawings.values())) + len(STUDY_PICTURES)) as advance:
        for truth, campaign in results.campaigns.items():
            write_campaign(folder / truth, campaign, advance)
        study_pictures = write_pictures(folder, STUDY_PICTURES, advance, results)
    page = findings.page(results)
    links = [(f"{truth}/index.html", f"Tables 1 to 4 and Figures 1 to 12, truth {truth}") for truth in drawings]
    links += [("study.csv", "medians and 10-90 % bands of every level"),
              ("joint.csv", "likelihood of the four published sets by true drag and T")]  # fmt: skip
    contents: list[Block] = [
        *(Heading("Identified and true (feet, as in the paper)"), overview(results.campaigns)),
        *(Heading("The paper reproduced"), Links(tuple(links)), Heading("The study in pictures")),
    ]
    write_texts(folder, {
        "findings.md": markdown(page),
        "study.csv": study_csv(results.study),
        "joint.csv": joint_csv(results.joint),
        "index.html": html("The paper reproduced", [*page, *contents, *study_pictures]),
    })  # fmt: skip


def write_campaign(folder: Path, campaign: Campaign, advance: Callable[[str], None] = lambda note: None) -> None:
    """Tables and figures of one truth."""
    folder.mkdir(parents=True)
    name = campaign.truth.name
    pictures = write_pictures(folder, plan(campaign), lambda figure: advance(f"{name}, {figure}"))
    tables = [paper_form(campaign, number) for number in published()]
    page: list[Block] = [Heading(f"Tables 1 to 4, truth {name}", 1), Paragraph(filled("tables")), *tables]
    write_texts(folder, {
        "tables.md": markdown(page),
        "tables.csv": tables_csv(campaign),
        "index.html": html(f"The paper reproduced, truth {name}", [*page, Heading("Figures 1 to 12"), *pictures]),
    })  # fmt: skip


def write_pictures(folder: Path, drawings: Drawings, advance: Callable[[str], None], *of: Results) -> list[Picture]:
    """Draw every picture into a file of its name."""
    pictures = []
    for name, (caption, draw) in drawings.items():
        (folder / f"{name}.png").write_bytes(draw(*of))
        pictures.append(Picture(f"{name}.png", caption))
        advance(name)
    return pictures


def write_texts(folder: Path, files: Mapping[str, str]) -> None:
    """Files by name."""
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")


def joint_csv(joint: Joint) -> str:
    """Posterior over true drag and T for each reading of Q, one cell a line."""
    maps = {reading: joint.map(reading) for reading in READINGS}
    header = ("reading", "true_drag_over_brutzman", "T_s", "share")
    cells = product(READINGS, enumerate(MULTIPLES), enumerate(STEPS_S))
    rows = [
        (reading, f"{drag:g}", f"{step:g}", f"{maps[reading][i, k]:.5g}") for reading, (i, drag), (k, step) in cells
    ]
    return csv_text(header, rows)
