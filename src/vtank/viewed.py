"""Flights to look at: a scenario as it is simulated, or a recording beside the simulation of its own commands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .errors import InputError
from .plant.sensor import Sensor
from .plant.vehicle import Vehicle, load_vehicle
from .record import TIME, Run, read_run
from .record.columns import ATTITUDE, channel_of
from .resources import NOMINAL, scenarios_dir
from .tank.poses import Poses

PLACE = ("north_m", "east_m", "depth_m")
EYE = Sensor("eye", (*PLACE, *ATTITUDE), rate_hz=25.0)


@dataclass(frozen=True, eq=False)
class View:
    """A flight in a model of the vehicle and its surroundings.

    Attributes:
        model: of MuJoCo.
        flown: what is shown as the vehicle: the simulation.
        ghost: the recording; None where there is none.
    """

    model: Any
    flown: Poses
    ghost: Poses | None = None

    def film(self, path: Path | str, size: tuple[int, int] = (960, 640), longest_s: float = 12.0) -> str:
        """Write an MP4 of that size [px, multiples of 16], at most so long [s], and return a line that says how.

        InputError without imageio-ffmpeg (extra `film`), and where no OpenGL library works.
        """
        from .tank.film import film

        return film(path, self.model, self.flown, self.ghost, size, longest_s)

    def show(self) -> None:
        """Play it in MuJoCo's viewer until that is closed; InputError where there is no window."""
        from .tank.film import show

        show(self.model, self.flown, self.ghost)


def view(
    flight: Path | str,
    ghost: Path | str | Run | None = None,
    vehicle: str | None = None,
    settings: Sequence[str] = (),
    truth: Path | str | None = None,
) -> View:
    """A scenario, by name or path, or a run, as a CSV file, to look at.

    ghost: a recording beside a scenario. A run is the ghost itself, beside the simulation of its own commands: by the
    vehicle's file, or along one axis with revolutions by the Phoenix. settings: KEY=VALUE laid over a scenario.
    truth: preset, or path of one or of a diagnosed model, along one axis (default: the scenario's; of a run paper-ii).
    InputError for bad input, and where a recording tells nothing of a place.
    """
    refuse_strange(flight)
    recording = read_run(ghost) if isinstance(ghost, str | Path) else ghost
    if str(flight).endswith(".csv"):
        return _of_run(read_run(flight), vehicle, truth)
    seen = of_run(recording) if recording else None
    return replace(_of_scenario(flight, settings, truth), ghost=seen)


def refuse_strange(flight: Path | str) -> None:
    """InputError for what is neither a run nor a scenario, before anything is simulated."""
    from .experiment.scenario import scenario_file

    if str(flight).endswith(".csv"):
        read_run(flight)
    elif Path(flight).is_dir() and not (scenarios_dir() / f"{flight}.toml").is_file():
        runs = ", ".join(sorted(path.name for path in Path(flight).glob("*.csv"))[:3]) or "a CSV file"
        raise InputError(f"{flight}: is a folder; expected one run of it, such as {runs}")
    else:
        scenario_file(flight)


def _of_scenario(flight: Path | str, settings: Sequence[str], truth: Path | str | None) -> View:
    from .experiment.clearance import vehicle_at, vehicle_path, walls_path
    from .experiment.fly import fly, plan_all
    from .experiment.whole_scenario import fly_whole, is_whole, load_whole_scenario
    from .tank.whole import load_whole
    from .tank.world import load_world

    if is_whole(flight):
        _along_one_axis(truth)
        whole = load_whole_scenario(flight, settings)
        watched = replace(whole, vehicle=_watched(whole.vehicle))
        flown: Any = fly_whole(watched)
        return View(load_whole(whole.vehicle, whole.walls).model, of_run(getattr(flown, "run", flown)))
    (plan,) = plan_all([flight], settings, None, None if truth is None else str(truth))
    scenario, (result,) = plan.scenario, fly([plan], "tank")
    true = result.true
    model = load_world(vehicle_at(vehicle_path(scenario.vehicle)), walls_path(scenario), scenario.period_s)
    place = np.column_stack([true["position_m"], true["sway_m"], true["depth_m"] - true["depth_m"][0]])
    return View(model, Poses(scenario.time_s, place, np.column_stack([true[name] for name in ATTITUDE])))


def _of_run(run: Run, vehicle: str | None, truth: Path | str | None) -> View:
    """A recording beside the simulation of its own commands."""
    from .experiment.whole import fly_vehicle
    from .logs.decidable import asked
    from .tank.whole import load_whole
    from .tank.world import load_model

    if "n_rev_s" in run.columns and run.outputs and vehicle is None:
        return View(load_model(), _simulated(run, truth or NOMINAL), of_run(run))
    if vehicle is None:
        raise InputError(f"run {run.name}: of which vehicle? expected --vehicle, a name or a vehicle file")
    _along_one_axis(truth)
    known = load_vehicle(vehicle)
    inputs = asked(run)
    if not inputs:
        raise InputError(f"run {run.name}: no input of a thruster or a fin, nothing can be simulated beside it")
    start = float(run.time_s[0])
    times = np.unique(np.concatenate([time_s for time_s, _ in inputs.values()]))
    table = {TIME: times - start}
    for name, (time_s, values) in inputs.items():
        row = np.searchsorted(time_s, times, side="right") - 1
        table[name] = np.where(row < 0, 0.0, values[np.maximum(row, 0)])
    flown = of_run(fly_vehicle(_watched(known), table, run.duration_s))
    ghost = of_run(run)
    return View(load_whole(known).model, replace(flown, time_s=flown.time_s + start), ghost)


def _along_one_axis(truth: Path | str | None) -> None:
    if truth is not None:
        raise InputError(f"truth {truth}: goes with experiments of one axis; expected none for a whole vehicle")


def _watched(vehicle: Vehicle) -> Vehicle:
    """The vehicle with an instrument that sees its pose without error."""
    return replace(vehicle, sensors=(*vehicle.sensors, EYE))


def _simulated(run: Run, truth: Path | str) -> Poses:
    """What the Phoenix of that truth makes of the revolutions of a run along one axis."""
    from .diagnose.experiments import recorded
    from .estimate.observed import POSITION, observe
    from .plant.truth import load_truth

    seen = observe(run)
    kinds = replace(seen, kind=np.full(seen.kind.shape, POSITION), value=np.zeros(seen.value.shape))
    ahead = recorded(kinds, load_truth(truth).vector()).value
    return _straight(seen.time_s + run.time_s[0], ahead)


def of_run(run: Run) -> Poses:
    """Where a recording says that the vehicle was; InputError where it tells nothing of a place.

    Of a run along one axis: straight ahead. Channels that are not there are zero; speeds are added up.
    """
    columns = {channel: _column(run, channel) for channel in (*PLACE, *ATTITUDE, "surge_m_s", "position_m", "range_m")}
    if columns["north_m"] and columns["east_m"]:
        time_s = run.samples(columns["north_m"])[0]
        place = np.column_stack([_on(run, columns[name], time_s) for name in PLACE])
        attitude = np.column_stack([_on(run, columns[name], time_s) for name in ATTITUDE])
        return Poses(time_s, place - place[0], attitude)
    if columns["position_m"]:
        time_s, ahead = run.samples(columns["position_m"])
    elif columns["range_m"]:
        time_s, distance = run.samples(columns["range_m"])
        ahead = distance[0] - distance
    elif columns["surge_m_s"]:
        time_s, speed = run.samples(columns["surge_m_s"])
        ahead = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time_s) * (speed[1:] + speed[:-1]))])
    else:
        raise InputError(f"run {run.name}: tells nothing of a place; expected north_m and east_m, position_m, range_m "
                         "or surge_m_s")  # fmt: skip
    return _straight(time_s, ahead - ahead[0])


def _straight(time_s: np.ndarray, ahead: np.ndarray) -> Poses:
    nothing = np.zeros((time_s.size, 3))
    return Poses(time_s, np.column_stack([ahead, nothing[:, :2]]), nothing)


def _column(run: Run, channel: str) -> str:
    """The first column that holds a channel; that of the eye before all others."""
    names = [name for name in run.columns if channel_of(name) == channel]
    return next((name for name in names if name.startswith(f"{EYE.name}.")), names[0] if names else "")


def _on(run: Run, name: str, time_s: np.ndarray) -> np.ndarray:
    if not name:
        return np.zeros(time_s.size)
    known_s, values = run.samples(name)
    return np.interp(time_s, known_s, np.unwrap(values) if name.endswith("_rad") else values)
