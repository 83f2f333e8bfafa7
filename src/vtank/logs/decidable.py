"""What can be decided from a recording, before anything is fitted: by its inputs, how often they come, how they move.

Only what the recording itself shows is judged, without a vehicle: a judgement is necessary and not sufficient.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..record.columns import MOTION, channel_of, column
from ..record.run import INPUTS, OUTPUTS, Run

Array = NDArray[np.float64]
Samples = dict[str, tuple[Array, Array]]  # column -> times [s] and values, shape (K,) each
AT_STOP = {"-": 0.05, "rad": 0.02, "rev/s": 0.5}  # moves nothing: dead band of a motor, play of a rudder; choices
COAST_S = 5.0  # [s] after a push in which a vehicle still moves by it; a choice
DRIVEN_S = 20.0  # [s] of inputs that are not at rest, below which little can be told apart; a choice
FOLLOWED = 0.3  # of `jumps`: above it, what was asked between two samples is not known; a choice
REPEATS = 10  # times at which no input changes, which a list of commands has not and a log by the clock has; a choice
LAG_S = 0.2  # [s] a thruster's lag, typically: T200 0.1 s, small electric thrusters 0.05 to 0.5 s; a guess


@dataclass(frozen=True)
class Decidable:
    """What a recording allows.

    Attributes:
        refusal: why nothing can be identified or diagnosed; "" where something can.
        undecidable: pairs of what cannot be told, and why.
        input_hz: of the input that is sampled least often [Hz]; 0 where they stand at their changes, not by a clock.
        driven_s: how long inputs were not at rest [s].
    """

    refusal: str = ""
    undecidable: tuple[tuple[str, str], ...] = ()
    input_hz: float = 0.0
    driven_s: float = 0.0

    def __str__(self) -> str:
        """One line for each."""
        lines = [f"nothing can be identified or diagnosed: {self.refusal}"] if self.refusal else []
        return "\n".join(lines + [f"not decidable: {what}: {why}" for what, why in self.undecidable])


def decidable(run: Run, armed: float | None = None) -> Decidable:
    """Judge a run; `armed` is the share of the time in which its motors were allowed to turn, None if not known."""
    inputs, motion = asked(run), moved(run)
    if not inputs:
        found = "its channels tell of motion only" if motion else "no motion either"
        return Decidable(f"no actuator channel: nothing tells what drove the vehicle; {found}")
    held = Held(inputs)
    if not held.driven_s:
        why = "never armed, and the motors at stop" if armed == 0.0 else "motors at stop throughout"
        refusal = f"{why}: {_furthest(inputs)}"
    elif not motion:
        refusal = "no channel of motion: nothing tells what the vehicle did"
    elif not held.changes:
        refusal = "the inputs never change: nothing parts thrust from drag or current"
    elif held.coarse and held.driven_s < DRIVEN_S:
        found = f"inputs at {held.rate_hz:.2g} Hz and {held.driven_s:.0f} s of excitation"
        refusal = f"{found}: too coarse to identify a lag or an inertia"
    else:
        refusal = ""
    missing = tuple(_undecidable(run, inputs, held)) if held.driven_s and motion else ()
    return Decidable(refusal, missing, held.rate_hz, held.driven_s)


def asked(run: Run) -> Samples:
    """The inputs of a run that have samples."""
    names = [name for name in run.columns if name in INPUTS or ((known := column(name)) and known.role == "input")]
    return {name: samples for name in names if (samples := run.samples(name))[0].size}


def moved(run: Run) -> list[str]:
    """The columns that tell of motion."""
    return [name for name in run.columns if name in OUTPUTS or channel_of(name) in MOTION]


class Held:
    """All inputs together, each held to its next sample.

    Attributes:
        driven_s: how long at least one was not at rest, pauses of up to COAST_S between included [s].
        changes: whether any changes by more than what moves nothing.
        rate_hz: of the input that is sampled least often [Hz]; 0 where they stand at their changes and not by a clock.
        coarse: whether most change from sample to sample so much that what was asked in between is not known.
    """

    def __init__(self, inputs: Samples) -> None:
        """Of the inputs of a run."""
        times = np.unique(np.concatenate([time_s for time_s, _ in inputs.values()]))
        driven, same = np.zeros(times.size, dtype=bool), np.ones(max(times.size - 1, 0), dtype=bool)
        for name, (time_s, values) in inputs.items():
            row = np.searchsorted(time_s, times, side="right") - 1
            value = np.where(row < 0, 0.0, values[np.maximum(row, 0)])
            driven |= np.abs(value) > at_stop(name)
            same &= np.diff(value) == 0.0
        sampled = int(same.sum()) >= REPEATS
        self.driven_s = _driven_s(np.diff(times), driven[:-1])
        self.changes = any(np.ptp(values) > at_stop(name) for name, (_, values) in inputs.items())
        self.rate_hz = min(_rate_hz(time_s) for time_s, _ in inputs.values()) if sampled else 0.0
        wild = [jumps(values[np.abs(values) > at_stop(name)]) > FOLLOWED for name, (_, values) in inputs.items()]
        self.coarse = sampled and sum(wild) > len(wild) // 2


def _driven_s(steps: Array, driven: NDArray[np.bool_]) -> float:
    stretches = np.split(np.arange(steps.size), np.flatnonzero(np.diff(driven)) + 1) if steps.size else []
    pauses = [float(steps[each].sum()) for each in stretches[1:-1] if not driven[each[0]]]
    return float(steps[driven].sum()) + sum(pause for pause in pauses if pause <= COAST_S)


def jumps(values: Array) -> float:
    """Mean square of changes over twice the variance (von Neumann): 0 for a slow signal, 1 for independent samples."""
    spread = 2.0 * float(np.var(values)) if values.size > 2 else 0.0
    return float(np.mean(np.diff(values) ** 2)) / spread if spread else 0.0


def at_stop(name: str) -> float:
    """The value up to which an input moves nothing, in its unit; a force has none such."""
    return AT_STOP.get(_unit(name), 0.0)


def _unit(name: str) -> str:
    """Of an input; those of a run along one axis have no row in the table of columns."""
    known = column(name)
    return known.unit if known else {"n_rev_s": "rev/s", "command": "-"}.get(name, "N")


def _rate_hz(time_s: Array) -> float:
    return float(1.0 / np.median(np.diff(time_s))) if time_s.size > 1 else 0.0


def _furthest(inputs: Samples) -> str:
    """How far the inputs are from stop at most."""
    most = max(float(np.abs(values).max()) for _, values in inputs.values())
    units = " or ".join(sorted({"of full command" if _unit(name) == "-" else _unit(name) for name in inputs}))
    return f"{len(inputs)} inputs, none further than {most:.2g} {units} from stop, which moves no vehicle"


def _undecidable(run: Run, inputs: Samples, held: Held) -> list[tuple[str, str]]:
    found = []
    if 0.0 < held.rate_hz < 1.0 / LAG_S:
        apart = f"inputs at {held.rate_hz:.2g} Hz, {1.0 / held.rate_hz:.2g} s apart"
        found.append(("thrust lag, delays", f"{apart}; a thruster's lag is about {LAG_S:g} s"))
    if held.coarse:
        found.append(("inertia, added mass", "the inputs change from one sample to the next as much as they do in all"))
    if held.driven_s < DRIVEN_S:
        found.append(("weak effects", f"{held.driven_s:.3g} s of excitation, expected {DRIVEN_S:g} s or more"))
    commands = [name for name in inputs if name.endswith("command")]
    if commands and not any(name.endswith("rev_s") for name in inputs):
        found.append(("propeller apart from motor", "no revolutions: a command does not tell what the propeller did"))
    if commands and "battery_V" not in run.columns:
        found.append(("supply sag apart from a motor that follows badly", "no battery_V beside the commands"))
    return found
