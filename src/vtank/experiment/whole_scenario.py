"""Open-loop scenarios of whole vehicles: which axes or inputs are excited, and how, in a TOML file.

vehicle = "bluerov2"
duration_s = 60.0
[[excite]]
kind = "multisine"                       # or step_coast, chirp, square (of a rudder: a zig-zag)
axis = "heave"                           # or input = "rudder_rad"
amplitudes_N = [10.0, 10.0]              # N_m about roll, pitch, yaw; plain "amplitudes" of an input, in its unit
frequencies_rad_s = [0.5, 1.3]
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..plant.actuators import Thruster
from ..plant.vehicle import AXES, Vehicle, load_vehicle
from ..record import TIME, Manifest, Run, find_file, open_table, read_text, stem, write_dataset
from ..record.table import Table
from ..resources import models_dir, scenarios_dir
from .excitation import Excitation, read_signal
from .whole import fly_vehicle

Array = NDArray[np.float64]
UNIT = {axis: "_N" if axis in AXES[:3] else "_N_m" for axis in AXES}
SHORT = 0.01  # share of its largest force by which a thruster may miss what is wanted; a choice
REACH = 1e-6  # share of a wanted force that may come out as another axis' force or moment, by rounding; a choice


@dataclass(frozen=True)
class Part:
    """One excitation: along an axis of AXES, or of one input by its column; `key` of the file for messages."""

    target: str
    signal: Excitation
    table: Table


@dataclass(frozen=True)
class WholeScenario:
    """A flight to be: of which vehicle, for how long [s], under which excitations, each period_s a new command [s]."""

    name: str
    path: Path
    vehicle: Vehicle
    duration_s: float
    period_s: float
    seed: int
    walls: Path | None
    current_m_s: tuple[float, float, float]
    parts: tuple[Part, ...]

    def commands(self) -> dict[str, Array]:
        """The table of commands for `fly_vehicle`; InputError where the thrusters cannot do what is asked."""
        count = int(np.floor(self.duration_s / self.period_s + 1e-9)) + 1
        time_s = self.period_s * np.arange(count, dtype=np.float64)
        wanted, table = np.zeros((time_s.size, 6)), {TIME: time_s}
        for part in self.parts:
            value = part.signal.command(time_s, self.duration_s)[0]
            if part.target in AXES:
                wanted[:, AXES.index(part.target)] += value
            else:
                table[part.target] = table.get(part.target, np.zeros_like(value)) + value
        axes = [part for part in self.parts if part.target in AXES]
        return table | (self._allocated(wanted, axes) if axes else {})

    def _allocated(self, wanted: Array, axes: Sequence[Part]) -> dict[str, Array]:
        """Inputs of the thrusters whose forces make a wrench, (T, 6) [N, N m]: the least ones that do."""
        from ..tank.whole import load_whole  # MuJoCo takes a while to load

        thrusters = self.vehicle.thrusters
        wrenches = load_whole(self.vehicle).model.actuator_gear[: len(thrusters)]
        inverse = np.linalg.pinv(wrenches)  # (6, K)
        for part in axes:
            one = np.eye(6)[AXES.index(part.target)]
            if np.abs(one @ inverse @ wrenches - one).max() > REACH:
                message = f"the thrusters of {self.vehicle.name} cannot push along {part.target} alone"
                raise part.table.error("axis", message)
        forces = wanted @ inverse
        return {t.column: self._input(t, force) for t, force in zip(thrusters, forces.T, strict=True) if force.any()}

    def _input(self, thruster: Thruster, force: Array) -> Array:
        """Inputs for forces (T,) [N]; InputError where one is more than the thruster can make."""
        asked = thruster.input_for(force)
        made = thruster.force_N(asked)
        if (short := np.abs(made - force)).max() > SHORT * thruster.limit_N:
            worst, name = int(short.argmax()), thruster.name or thruster.site
            message = f"asks {force[worst]:.3g} N of thruster {name}, which makes {made[worst]:.3g} N at most"
            raise InputError(f"{self.path}: excite: {message}")
        return asked


def is_whole(name_or_path: str | Path) -> bool:
    """Whether a scenario is one of whole vehicles: it has [[excite]]."""
    return "excite" in open_table(find_file(name_or_path, scenarios_dir(), "scenario")).entries


def load_whole_scenario(
    name_or_path: str | Path, settings: Sequence[str] = (), seed: int | None = None
) -> WholeScenario:
    """The scenario of that name in scenarios/, or of that TOML file; InputError names file, line and key.

    settings: KEY=VALUE laid over it. seed: instead of the file's.
    """
    path = find_file(name_or_path, scenarios_dir(), "scenario")
    table = open_table(path, tuple(settings))
    table.text("description", "")
    vehicle = load_vehicle(table.file("vehicle", presets=(models_dir(), "vehicle")))
    parts = tuple(_part(part, vehicle) for part in table.tables("excite"))
    if not parts:
        raise table.error("excite", "expected one excitation or more, [[excite]]")
    own_seed = table.integer("seed", 0)
    walls = table.file("walls", "", ".xml")
    scenario = WholeScenario(
        name=stem(path),
        path=path,
        vehicle=vehicle,
        duration_s=table.positive("duration_s", 120.0, 86400.0),
        period_s=table.positive("period_s", 0.1, 10.0),
        seed=own_seed if seed is None else seed,
        walls=(models_dir() / f"{walls}.xml" if not walls.endswith(".xml") else Path(walls)) if walls else None,
        current_m_s=table.vector("current_m_s") if table.has("current_m_s") else (0.0, 0.0, 0.0),
        parts=parts,
    )
    table.close()
    return scenario


def _part(table: Table, vehicle: Vehicle) -> Part:
    if table.either("axis", "input") == "axis":
        target = table.choice("axis", AXES)
        signal = read_signal(table, UNIT[target])
    else:
        fins = [fin.column for fin in vehicle.fins if fin.limit_rad]
        target = table.choice("input", tuple([*(t.column for t in vehicle.thrusters), *fins]))
        signal = read_signal(table, "")
    table.close()
    return Part(target, signal, table)


def fly_whole(scenario: WholeScenario) -> Run:
    """Fly a scenario; errors as of `fly_vehicle`."""
    return fly_vehicle(
        scenario.vehicle,
        scenario.commands(),
        scenario.duration_s,
        scenario.seed,
        scenario.walls,
        scenario.current_m_s,
        name=scenario.name,
    )


def summary(scenario: WholeScenario, run: Run) -> str:
    """One line about a flight: how fast each excited axis went, as it was recorded; all of them, under an input."""
    targets = {part.target for part in scenario.parts}
    axes = [axis for axis in AXES if axis in targets or not targets <= set(AXES)]
    told = []
    for axis in axes:
        channel = f"{axis}_m_s" if axis in AXES[:3] else f"{axis}_rate_rad_s"
        column = next((name for name in run.columns if name.rpartition(".")[2] == channel), "")
        if column:
            told.append(f"{column} {np.nanmin(run.columns[column]):+.3g} to {np.nanmax(run.columns[column]):+.3g}")
        elif axis in targets:
            told.append(f"{channel} is not measured")
    return f"{run.name}: {scenario.vehicle.name}, {run.duration_s:g} s, {', '.join(told)}"


def write_flights(out: Path, scenarios: Sequence[WholeScenario], runs: Sequence[Run], settings: Sequence[str]) -> None:
    """Write the recordings as a data set, with scenarios and seeds in its truth; InputError for an unfit folder."""
    flown: list[Mapping[str, Any]] = [{"name": s.name, "text": read_text(s.path), "seed": s.seed} for s in scenarios]
    write_dataset(out, runs, Manifest(), {"model": "whole", "settings": list(settings), "scenarios": flown})
