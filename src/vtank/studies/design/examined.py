"""A plan of experiments looked at from all sides, and what was found as files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from ...errors import InputError
from ...estimate.paper import Model
from ...experiment import Scenario, load_scenario
from ...plant import Truth, load_truth
from ...present.document import csv_text
from ...record import Kind, results_folder
from ..processes import processes as pool_of
from ..stage import Stage, silent
from .advice import options, remedies
from .bias import bias_map
from .design import confirmed, pool, scenario_texts
from .document import document
from .findings import Findings
from .flown import Array
from .profile import profiles
from .study import PAPER, natural_model, study
from .trials import Trials, trials

RESULTS = Kind("results of vtank identifiability", "identifiability.json", "vtank-identifiability-1")
PLAN = Kind("a plan of vtank identifiability", "plan.json", "vtank.plan/1")


def examine(
    scenarios: Sequence[str | Path] = PAPER,
    truth: str | Path | None = None,
    model: Model | None = None,
    settings: Sequence[str] = (),
    *,
    seeds: int = 0,
    seed: int = 1,
    processes: int = 1,
    design: bool = False,
    stage: Stage = silent,
) -> Findings:
    """What a plan of scenarios, by name or path, can tell: bounds and separable effects, always, and what is asked for.

    truth: preset that all share (default: the scenarios' own). model: to identify (default: the smallest that holds
    the truth). seeds: of a Monte Carlo of the estimators, 0 for none. design: look for a better plan in the same time.
    InputError where the scenarios have different truths, or the model cannot hold the truth.
    """
    loaded = [load_scenario(name, settings) for name in scenarios]
    common = _common_truth(loaded, truth)
    looked = study(loaded, common, model or natural_model(common), seed)
    found = Findings(looked, tuple(remedies(looked, options(looked, stage))), tuple(profiles(looked)))

    def tried(label: str, some: Sequence[Scenario], bound: Array) -> Trials:
        with stage(label, seeds) as advance:
            return trials(some, common, looked.model, bound, seeds, seed, over, advance)

    with pool_of(processes if seeds else 1) as over:
        if seeds:
            found = replace(found, trials=tried("Monte Carlo", loaded, looked.bound))
            found = replace(found, bias=bias_map(loaded[0], common, looked.model, seeds, seed, over, stage))
        if design:
            plan = confirmed(looked, pool(looked, stage), processes)
            found = replace(found, design=plan)
        if design and seeds:
            bound = plan.relative(plan.items) * looked.information.sizes(looked.free)
            some = [item.flown.scenario for item in plan.items]
            found = replace(found, checked=tried("Monte Carlo of the design", some, bound))
    return found


def _common_truth(scenarios: Sequence[Scenario], truth: str | Path | None) -> Truth:
    truths = sorted({scenario.truth for scenario in scenarios})
    if truth is None and len(truths) > 1:
        raise InputError(f"the scenarios have different truths ({', '.join(truths)}): choose one with --truth")
    return load_truth(truth or truths[0])


def write_findings(folder: Path | str, found: Findings) -> list[str]:
    """Tables (CSV), the page (HTML, PNG) and JSON as a folder; returns the names of the files."""
    from .figures import page  # matplotlib takes a while to load

    png = page(found.study, found.trials, found.bias, list(found.profiles))
    files = {f"{sheet.name}.csv": csv_text(sheet.header, sheet.rows).encode() for sheet in found.sheets()}
    files |= {"identifiability.png": png, "identifiability.html": found.page(png).encode()}
    return [*_written(folder, RESULTS, files, document(found)), RESULTS.marker]


def write_plan(folder: Path | str, found: Findings) -> list[str]:
    """The designed runs as scenario files in a folder; returns their names."""
    assert found.design is not None
    return _written(folder, PLAN, {name: text.encode() for name, text in scenario_texts(found.design).items()})


def _written(folder: Path | str, kind: Kind, files: dict[str, bytes], about: dict[str, Any] | None = None) -> list[str]:
    with results_folder(folder, kind, about) as new:
        for name, data in files.items():
            (new / name).write_bytes(data)
    return list(files)
