"""The two parts of the study, each as the tables that are printed and the files that are written."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ...experiment import Scenario, plan_run
from ...present import Table
from ...record import Kind, results_folder
from ..stage import Shares, silent
from .balance import balance
from .loop import Loop
from .report import page, response_csv, response_table, station_csv, station_tables
from .response import AMPLITUDES_M, sine_plan, sweep
from .station import keep_station

RESULTS = Kind("results of vtank bandwidth", "bandwidth.json", "vtank.bandwidth/1")


@dataclass(frozen=True)
class Part:
    """The tables that are printed, and the files, name -> content."""

    tables: list[Table]
    files: dict[str, bytes]


def frequency_response(
    scenario: Scenario,
    amplitudes_m: Sequence[float] = AMPLITUDES_M,
    truth: str | None = None,
    threads: int = 1,
    pictures: bool = True,
    stage: Shares = silent,
) -> Part:
    """Closed-loop response of surge position in the tank, beside the linear loop and the harmonic balance."""
    amplitudes = sorted(set(amplitudes_m))
    with stage("frequency response") as report:
        measured = sweep(scenario, amplitudes, truth=truth, nthread=threads, progress=report)
    plan = sine_plan(scenario, amplitudes[0], float(measured.rad_s[0]), truth)
    loop = Loop(plan)
    linear = loop.response(measured.rad_s) if loop.stable() else np.full(measured.rad_s.size, complex(np.nan, np.nan))
    balanced = np.array([balance(plan, amplitude, measured.rad_s)[0] for amplitude in amplitudes])
    files = {"response.csv": response_csv(measured, linear, balanced).encode()}
    if pictures:
        from .figures import response_figure  # matplotlib takes a while to load

        files["response.png"] = response_figure(measured, linear, balanced, _subject(scenario, truth))
    return Part([response_table(measured)], files)


def station_keeping(
    scenario: Scenario,
    truth: str | None = None,
    model: Literal["tank", "surge"] = "tank",
    threads: int = 1,
    pictures: bool = True,
    stage: Shares = silent,
) -> Part:
    """How far waves, regular and irregular, move the vehicle that holds its place before a wall."""
    seas = []
    for kind in ("regular", "irregular"):
        with stage(f"station keeping, {kind} waves") as report:
            seas.append(keep_station(scenario, kind, truth=truth, model=model, nthread=threads, progress=report))
    files = {"seas.csv": station_csv(seas).encode()}
    if pictures:
        from .figures import station_figure

        files["seas.png"] = station_figure(seas, plan_run(scenario, truth=truth), _subject(scenario, truth))
    return Part([table for sea in seas for table in station_tables(sea)], files)


def write_parts(folder: Path | str, scenario: Scenario, truth: str | None, parts: Sequence[Part]) -> list[str]:
    """The files of all parts, and a page that shows them, as a folder; returns the names of the files."""
    files = {name: content for part in parts for name, content in part.files.items()}
    tables = [table for part in parts for table in part.tables]
    files["bandwidth.html"] = page(_subject(scenario, truth), tables, files).encode()
    with results_folder(folder, RESULTS, {"scenario": scenario.name}) as new:
        for name, content in files.items():
            (new / name).write_bytes(content)
    return list(files)


def _subject(scenario: Scenario, truth: str | None) -> str:
    """What the figures are about."""
    return f"{Path(scenario.vehicle).stem}, truth {Path(truth or scenario.truth).stem}, controller of {scenario.name}"
