"""What a plan of experiments with a whole vehicle can tell: own parameters by axis, and effects at places.

The nominal flies the plan; bounds are Cramer-Rao's, of all own parameters together and beside their priors, without
which thrust, mass and drag of one axis go together; effects are set apart as the diagnosis does it, own parameters and
the rival's numbers adapted within their priors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add
from pathlib import Path
from typing import Any

import numpy as np

from ...diagnose.whole import Foreseen, Hypothesis, foreseen, own_numbers, possible
from ...errors import InputError
from ...experiment.whole_scenario import WholeScenario, fly_whole, load_whole_scenario
from ...plant import load_vehicle
from ...present import Heading, Paragraph, Table, number
from ...present.document import csv_text, html
from ...record import Run, results_folder
from .examined import RESULTS
from .verdicts import CLEAR, SEEN

USUAL = 1.0  # deviation of its prior, at which an effect is looked at
TOLD = 0.1  # relative bound up to which a parameter is called told; a choice


@dataclass(frozen=True)
class Seen:
    """An effect at a place: whether it is seen at its usual size, and told from every other.

    Attributes:
        raw, left: deviations that it brings before and after own parameters are refitted. rival: the nearest.
        apart: deviations that the rival leaves, refitted as well.
    """

    name: str
    raw: float
    left: float
    rival: str
    apart: float

    @property
    def standing(self) -> str:
        """too small, absorbed by own parameters, tied to another, or separable."""
        if self.raw < SEEN:
            return "too small"
        return "absorbed" if self.left < SEEN else "tied" if self.apart < SEEN else "separable"


@dataclass(frozen=True)
class WholeFindings:
    """What was looked at: the runs, own parameters with the file's value, its prior's deviation and bound, and effects.

    own: name, value, prior, bound, SI.
    """

    vehicle: str
    runs: tuple[Run, ...]
    own: tuple[tuple[str, float, float, float], ...]
    effects: tuple[Seen, ...]

    @property
    def minutes(self) -> float:
        """Of all runs [min]."""
        return sum(run.duration_s for run in self.runs) / 60.0

    def sentences(self) -> list[str]:
        """Verdicts in plain words."""
        told = [f"{name} to {100.0 * sd / value:.2g} %" for name, value, _, sd in self.own if sd < TOLD * value]
        badly = [name for name, value, _, sd in self.own if sd >= TOLD * value]
        by = {kind: [e.name for e in self.effects if e.standing == kind] for kind in ("too small", "absorbed")}
        tied = [f"{e.name} and {e.rival} ({e.apart:.1f})" for e in self.effects if e.standing == "tied"]
        some = [
            f"{self._runs} can tell {_list(told)} (one deviation).",
            f"Not to {100.0 * TOLD:g} %: {_list(badly)}." if badly else "",
            f"Not seen at their usual size: {_list(by['too small'])}." if by["too small"] else "",
            f"Taken up by own parameters: {_list(by['absorbed'])}." if by["absorbed"] else "",
            f"Not told apart (deviations): {_list(tied)}." if tied else "",
            f"Clearly seen and apart from every other: {len(self._clear)} of {len(self.effects)} effects at places.",
        ]
        return [sentence for sentence in some if sentence]

    @property
    def _runs(self) -> str:
        some = f"These {len(self.runs)} runs of {self.minutes:.2g} min in all"
        return some if len(self.runs) > 1 else f"This run of {self.minutes:.2g} min"

    @property
    def _clear(self) -> list[Seen]:
        return [e for e in self.effects if min(e.left, e.apart) >= CLEAR]

    def sheets(self, every: bool = False) -> list[Table]:
        """Bounds, and effects at places: all of them, or those that are not clearly seen and apart."""
        clear = [] if every else self._clear
        rows = tuple(
            (
                name,
                number(value, 4),
                number(sd, 2),
                *(f"{100.0 * s / value:.3g}" if value else "-" for s in (prior, sd)),
            )
            for name, value, prior, sd in self.own
        )
        bounds = Table(
            ("parameter", "file", "bound", "prior %", "bound %"),
            rows,
            name="bounds",
            title="Cramer-Rao bounds beside the priors [SI]",
        )
        lines = tuple(
            (
                e.name,
                e.standing,
                e.rival,
                f"{e.apart:.3g}" if np.isfinite(e.apart) else "-",
                f"{e.raw:.3g}",
                f"{e.left:.3g}",
            )
            for e in self.effects
            if e not in clear
        )
        notes = (
            "raw, left: deviations of the noise that the usual size brings before and after own parameters are "
            f"refitted; apart: that the nearest rival leaves, refitted as well. Below {SEEN:g}: too small, absorbed, "
            "or tied.",
        )
        header = ("effect", "standing", "nearest rival", "apart", "raw", "left")
        title = "Effects at places" + ("" if every else " that are not clearly seen and apart")
        return [bounds, Table(header, lines, notes, left=3, name="effects", title=title)]

    def document(self) -> dict[str, Any]:
        """As plain data."""
        own = [{"name": name, "value": value, "prior": prior, "bound": sd} for name, value, prior, sd in self.own]
        known = [vars(e) | {"apart": e.apart if np.isfinite(e.apart) else None} for e in self.effects]
        effects = [said | {"standing": e.standing} for said, e in zip(known, self.effects, strict=True)]
        return {"vehicle": self.vehicle, "runs": [run.name for run in self.runs], "minutes": self.minutes,
                "parameters": own, "effects": effects}  # fmt: skip


def _list(names: Sequence[str]) -> str:
    return ", ".join(names) or "nothing"


def examine_whole(
    scenarios: Sequence[str | Path], nominal: str | Path | None = None, settings: Sequence[str] = ()
) -> WholeFindings:
    """What scenarios of a whole vehicle, by name or path, can tell.

    nominal: vehicle file that flies all of them (default: the scenarios' own). InputError where vehicles differ, or
    where one cannot fly its scenario.
    """
    more = [*settings, *([f"vehicle={load_vehicle(nominal).path}"] if nominal is not None else [])]
    loaded = [load_whole_scenario(name, more) for name in scenarios]
    vehicle = loaded[0].vehicle
    if len({scenario.vehicle.path for scenario in loaded}) > 1:
        raise InputError("the scenarios have different vehicles: choose one with --nominal")
    runs = tuple(_flown(scenario) for scenario in loaded)
    hypotheses = possible(vehicle, runs, share=USUAL)
    both = reduce(add, foreseen(vehicle, runs, hypotheses))
    numbers = own_numbers(vehicle, runs)
    bounds = both.bounds(np.diag([prior**-2.0 for _, prior in numbers.values()]))
    own = tuple((name, *known, float(sd)) for (name, known), sd in zip(numbers.items(), bounds, strict=True))
    return WholeFindings(vehicle.name, runs, own, tuple(_seen(both, hypotheses)))


def _flown(scenario: WholeScenario) -> Run:
    flown = fly_whole(replace(scenario, effects=()))
    if flown.ended:
        raise InputError(f"{scenario.name}: {flown.ended}")
    return flown.run


def _seen(both: Foreseen, hypotheses: Sequence[Hypothesis]) -> list[Seen]:
    apart = both.apart(hypotheses)
    raw = np.sqrt(np.diag(both.gram)[list(both.at)])
    names = [h.name for h in hypotheses]
    able = (raw >= SEEN) & (np.arange(raw.size) > 0)  # to be a rival
    found = []
    for i in range(1, len(names)):
        same = np.array([name.partition(":")[0] == names[i].partition(":")[0] for name in names])  # in other forms
        others = np.where(able & ~same, apart[i], np.inf)
        j = int(np.argmin(others))
        asked = apart[i, 0] >= SEEN and np.isfinite(others[j])  # else there is nothing that a rival could explain
        found.append(Seen(names[i], float(raw[i]), float(apart[i, 0]), names[j] if asked else "-",
                          float(others[j]) if asked else np.inf))  # fmt: skip
    return sorted(found, key=lambda e: min(e.left, e.apart))


def write_whole(folder: Path | str, found: WholeFindings) -> list[str]:
    """Tables (CSV), the page (HTML) and JSON as a folder; returns the names of the files."""
    title, sheets = f"Identifiability of {found.vehicle}", found.sheets(every=True)
    page = html(title, [Heading(title, 1), *map(Paragraph, found.sentences()), *sheets])
    files = {f"{sheet.name}.csv": csv_text(sheet.header, sheet.rows) for sheet in sheets}
    files["identifiability.html"] = page
    with results_folder(folder, RESULTS, found.document()) as new:
        for name, text in files.items():
            (new / name).write_bytes(text.encode())
    return [*files, RESULTS.marker]
