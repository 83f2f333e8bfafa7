"""What can be decided from a recording, before anything is fitted: by what its inputs are, how often, and how they move.

Only what the recording itself shows is judged, without a vehicle: a judgement is necessary and not sufficient.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..record.columns import MOTION, column
from ..record.run import INPUTS, OUTPUTS, Run

Array = NDArray[np.float64]
AT_STOP = {
    "-": 0.05,
    "rad": 0.02,
    "rev/s": 0.5,
}  # what moves no vehicle: within the dead band of a motor, or the play of a
# rudder; choices. A force counts as it is.
COAST_S = 5.0  # [s] after a push in which a vehicle still moves by it; a choice
DRIVEN_S = 20.0  # [s] of inputs that are not at rest, below which little can be told apart; a choice
FOLLOWED = (
    0.3  # share of an input's variance that its changes from sample to sample may have; 1: no sample tells the next.
)
# Above it, what was asked between two samples is not known; a choice.
LAG_S = 0.2  # [s] a thruster's lag, typically: T200 0.1 s, small electric thrusters 0.05 to 0.5 s; a guess
REVOLUTIONS = ("thrust loss with speed", "supply sag", "a motor that does not follow its command")


@dataclass(frozen=True)
class Decidable:
    """What a recording allows.

    Attributes:
        refusal: why nothing can be identified or diagnosed; "" where something can.
        undecidable: what cannot be told apart or measured -> why.
        input_hz: of the input that is sampled least often [Hz]; 0 without inputs.
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
    rate_hz = min(_rate_hz(*each) for each in inputs.values())
    driven_s, changes = _driven(inputs)
    rest = {name: float(np.abs(values).max()) for name, (_, values) in inputs.items()}
    most = f"{len(inputs)} inputs, none further than {max(rest.values()):.2g} {_units(inputs)} from stop"
    if armed == 0.0 and not driven_s:
        return Decidable(f"never armed, and the motors at stop: {most}", (), rate_hz)
    if not driven_s:
        return Decidable(f"motors at stop throughout: {most}, which moves no vehicle", (), rate_hz)
    if not motion:
        return Decidable("no channel of motion: nothing tells what the vehicle did", (), rate_hz, driven_s)
    if not changes:
        return Decidable("the inputs never change: nothing parts thrust from drag or current", (), rate_hz, driven_s)
    coarse = _coarse(inputs)
    why = _refusal(rate_hz, driven_s, coarse, inputs)
    return Decidable(why, tuple(_undecidable(run, inputs, rate_hz, driven_s)), rate_hz, driven_s)


def asked(run: Run) -> dict[str, tuple[Array, Array]]:
    """The inputs of a run: column -> times [s] and values, shape (K,) each."""
    names = [name for name in run.columns if name in INPUTS or ((known := column(name)) and known.role == "input")]
    return {name: samples for name in names if (samples := run.samples(name))[0].size}


def moved(run: Run) -> list[str]:
    """The columns that tell of motion."""
    return [name for name in run.columns if name in OUTPUTS or name.rpartition(".")[2] in MOTION]


def _rate_hz(time_s: Array, _: Array) -> float:
    return float(1.0 / np.median(np.diff(time_s))) if time_s.size > 1 else 0.0


def _at_stop(name: str) -> float:
    """The value up to which an input moves nothing."""
    unit = (
        "rev/s" if name == "n_rev_s" else "-" if name == "command" else (known.unit if (known := column(name)) else "N")
    )
    return AT_STOP.get(unit, 0.0)


def _units(inputs: dict[str, tuple[Array, Array]]) -> str:
    """Of the inputs, in words."""
    units = {"of full command" if name.endswith("command") else known.unit if (known := column(name)) else "" for name in
             inputs}  # fmt: skip
    return " or ".join(sorted(units))


def _driven(inputs: dict[str, tuple[Array, Array]]) -> tuple[float, bool]:
    """How long inputs were not at rest, short pauses between included [s], each held to its next; whether any changed."""
    changes = any(np.ptp(values) > _at_stop(name) for name, (_, values) in inputs.items())
    edges = np.unique(np.concatenate([time_s for time_s, _ in inputs.values()]))
    held = np.zeros(edges.size, dtype=bool)
    for name, (time_s, values) in inputs.items():
        row = np.searchsorted(time_s, edges, side="right") - 1
        held |= (row >= 0) & (np.abs(values)[np.maximum(row, 0)] > _at_stop(name))
    steps, held = np.diff(edges), held[:-1]
    pauses = np.split(np.arange(steps.size), np.flatnonzero(np.diff(held)) + 1) if steps.size else []
    inner = [pause for pause in pauses[1:-1] if not held[pause[0]] and steps[pause].sum() <= COAST_S]
    return float(steps[held].sum() + sum(steps[pause].sum() for pause in inner)), changes


def _coarse(inputs: dict[str, tuple[Array, Array]]) -> list[str]:
    """Inputs that change so much from sample to sample that what was asked in between is not known."""
    return [name for name, (_, values) in inputs.items() if _jumps(values[np.abs(values) > _at_stop(name)]) > FOLLOWED]


def _jumps(values: Array) -> float:
    """Mean square of changes over twice the variance (von Neumann): 0 for a slow signal, 1 where samples are strangers."""
    spread = 2.0 * float(np.var(values)) if values.size > 2 else 0.0
    return float(np.mean(np.diff(values) ** 2)) / spread if spread else 0.0


def _refusal(rate_hz: float, driven_s: float, coarse: list[str], inputs: dict[str, tuple[Array, Array]]) -> str:
    """Why a driven recording is too coarse for any dynamics; "" where it is not."""
    if len(coarse) <= len(inputs) // 2 or driven_s > DRIVEN_S:
        return ""
    return (f"inputs at {rate_hz:.2g} Hz and {driven_s:.0f} s of excitation: too coarse to identify a lag or an inertia, "
            "since what was asked between two samples is not known")  # fmt: skip


def _undecidable(
    run: Run, inputs: dict[str, tuple[Array, Array]], rate_hz: float, driven_s: float
) -> list[tuple[str, str]]:
    found = []
    if rate_hz < 1.0 / LAG_S:
        found.append(
            (
                "thrust lag, delays of command and sensors",
                f"inputs at {rate_hz:.2g} Hz, {1.0 / rate_hz:.2g} s apart, a thruster's lag is about {LAG_S:g} s",
            )
        )
    if _coarse(inputs):
        found.append(
            ("inertia and added mass", "the inputs change from one sample to the next as much as they do in all")
        )
    if driven_s < DRIVEN_S:
        found.append(("drag apart from thrust", f"{driven_s:.0f} s of excitation, expected {DRIVEN_S:g} s or more"))
    if not any(name.endswith("rev_s") for name in inputs) and any(name.endswith("command") for name in inputs):
        found.append((", ".join(REVOLUTIONS), "no revolutions: a command does not tell what the propeller did"))
    if any(name.endswith("command") for name in inputs) and "battery_V" not in run.columns:
        found.append(("a tired battery", "no battery_V beside the commands"))
    return found
