"""A run as the estimators see it: one held input, and every sample of range, position and speed in time order."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..channels import channels
from ..errors import InputError
from ..plant.plant import Plant
from ..plant.surge import SURGE
from ..record.run import Run
from .kernels import Record, Steps

RANGE, POSITION, SPEED = 0, 1, 2
CHANNELS = {row.name: kind for kind, row in enumerate(channels(SURGE))}


@dataclass(frozen=True, eq=False)
class Observed:
    """Input and measurements of one run, for the compiled kernels.

    Attributes:
        name: the run's name.
        input_name: "n_rev_s", "command" or "thrust_N".
        input_time_s: stamps of the input, shape (I,).
        input: input values, held from each stamp to the next, shape (I,).
        time_s: stamps of the measurements, ascending, shape (M,).
        value: measurements [m or m/s], shape (M,).
        kind: channel of each, its place in the plant's table, here RANGE, POSITION or SPEED, shape (M,).
        lone: how far each input value that stands alone lies off, 0 where it does not (default everywhere), shape (I,).
        plant: whose inputs and measurements these are.
    """

    name: str
    input_name: str
    input_time_s: np.ndarray
    input: np.ndarray
    time_s: np.ndarray
    value: np.ndarray
    kind: np.ndarray
    lone: np.ndarray = field(default_factory=lambda: np.zeros(0))
    plant: Plant = SURGE

    def __post_init__(self) -> None:
        if self.lone.shape != self.input.shape:
            object.__setattr__(self, "lone", np.zeros(self.input.shape))

    @cached_property
    def record(self) -> Record:
        """The same for the compiled kernels."""
        stamp, reading, lone, time, value = (
            np.ascontiguousarray(a, dtype=float)
            for a in (self.input_time_s, self.input, self.lone, self.time_s, self.value)
        )
        colour = np.array([float(row.coloured) for row in channels(self.plant)])[self.kind]
        return Record(stamp, reading, lone, time, value, np.ascontiguousarray(self.kind, dtype=np.int64), colour)

    @cached_property
    def plans(self) -> dict[tuple[float, ...], Steps]:
        """Step plans of this run, by the delays they were made for."""
        return {}

    @cached_property
    def has_position(self) -> bool:
        """Whether any channel fixes the hull's place, and not only its speed."""
        return bool(np.any(self.kind != SPEED))

    @cached_property
    def first(self) -> dict[int, float]:
        """First value of each channel that was measured."""
        kinds, index = np.unique(self.kind, return_index=True)
        return {int(kind): float(self.value[k]) for kind, k in zip(kinds, index, strict=True)}

    @cached_property
    def standoff(self) -> float | None:
        """Distance from sonar to wall where x = 0, at the start of the run [m]; None where there is no sonar."""
        if RANGE not in self.first:
            return None
        opening = self.value[self.kind == RANGE][:5]  # a median of five, since any ping may be an outlier
        return float(np.median(opening)) + self.first.get(POSITION, 0.0)

    def start(self, standoff: float) -> np.ndarray:
        """First guess of the state (x, u, z, wake) at the first measurement, shape (4,), hull at rest if unknown.

        standoff: distance from the sonar to the wall where x = 0 [m].
        """
        x = standoff - self.first[RANGE] if RANGE in self.first else 0.0
        return np.array([self.first.get(POSITION, x), self.first.get(SPEED, 0.0), 0.0, 0.0])


def observe(run: Run) -> Observed:
    """Collect a run's input and measurements; InputError where it has nothing to fit."""
    input_time, values = run.samples(run.input)
    parts = [(CHANNELS[name], *run.samples(name)) for name in CHANNELS if name in run.columns]
    if not parts:
        raise InputError(f"run '{run.name}': no measurement to fit; expected one of {', '.join(CHANNELS)}")
    kind = np.concatenate([np.full(time.size, kind) for kind, time, _ in parts])
    time = np.concatenate([time for _, time, _ in parts])
    value = np.concatenate([value for _, _, value in parts])
    order = np.argsort(time, kind="stable")
    return Observed(run.name, run.input, input_time, values, time[order], value[order], kind[order])
