"""Which run comes next: that from which the largest drop of doubt per minute is expected, inside walls and limits."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...diagnose.whole import Hypothesis, drop_of_doubt, foreseen
from ...errors import InputError
from ...experiment.whole_scenario import fly_whole
from ...plant import Vehicle
from ...plant.sensor import Sensor
from ...record import Run
from ...record.columns import ACCELERATION, ATTITUDE, RATES, VELOCITY
from ...rigid.filtered import Noise
from .candidates import Candidate

SEED = 1  # of the flights of the nominal, whose noise nothing depends on
TIED = 3.0  # deviations below which two hypotheses are not told apart
INSTRUMENTS = (  # that could be added, with the noise of usual ones (models/README.md); guesses
    Sensor("added_dvl", VELOCITY, noise=(0.01, 0.01, 0.01)),
    Sensor("added_gyro", RATES, noise=(0.002, 0.002, 0.002)),
    Sensor("added_attitude", ATTITUDE, noise=(0.005, 0.005, 0.01)),
    Sensor("added_accelerometer", ACCELERATION, noise=(0.02, 0.02, 0.02)),
    Sensor("added_motion_capture", ("north_m", "east_m"), noise=(0.005, 0.005)),
    Sensor("added_depth", ("depth_m",), noise=(0.01,)),
)


@dataclass(frozen=True, eq=False)
class Plan:
    """A run and what it would tell.

    Attributes:
        candidate: the run. drop: of the doubt that is expected, at least [nats]. apart: deviations between the
            hypotheses, (L, L).
    """

    candidate: Candidate
    drop: float
    apart: NDArray[np.float64]

    @property
    def per_minute(self) -> float:
        """Drop of the doubt per minute [nats/min]."""
        return self.drop / self.candidate.minutes


class Planner:
    """Candidates that a vehicle can fly, each flown once by its nominal.

    Attributes:
        flown: candidates that stay inside walls and limits, in order. flights: their recordings of the nominal.
    """

    def __init__(self, vehicle: Vehicle, candidates: Sequence[Candidate]) -> None:
        """InputError where the vehicle can fly none of them."""
        self.vehicle, self.refused = vehicle, dict[str, str]()
        self.flown: list[Candidate] = []
        self.flights: list[Run] = []
        for candidate in candidates:
            run = self._fly(candidate, vehicle)
            if run is not None:
                self.flown.append(candidate)
                self.flights.append(run)
        if not self.flown:
            raise InputError(f"{vehicle.name}: none of {len(candidates)} runs can be flown: "
                             + "; ".join(f"{name}: {why}" for name, why in self.refused.items()))  # fmt: skip

    def _fly(self, candidate: Candidate, vehicle: Vehicle) -> Run | None:
        """The nominal's recording; None where it strikes a wall or cannot do what is asked."""
        try:
            flown = fly_whole(candidate.scenario(SEED), vehicle)
        except InputError as reason:
            self.refused[candidate.words] = str(reason)
            return None
        if flown.ended:
            self.refused[candidate.words] = flown.ended
        return None if flown.ended else replace(flown.run, name=candidate.words.replace(" ", "_"))

    def plans(self, hypotheses: Sequence[Hypothesis], noise: Noise | None = None) -> list[Plan]:
        """What every candidate would tell of hypotheses, the largest drop per minute first.

        noise: of the disturbance (default: still water).
        """
        seen = foreseen(self.vehicle, self.flights, hypotheses, noise)
        found = [Plan(candidate, 0.0, one.apart(hypotheses)) for candidate, one in zip(self.flown, seen, strict=True)]
        return ranked(found, hypotheses)

    def sensor(self, hypotheses: Sequence[Hypothesis], candidate: Candidate) -> tuple[Sensor, float] | None:
        """The instrument that would set the first two hypotheses apart, and how far; None where none does."""
        found = []
        for sensor in INSTRUMENTS:
            if any(set(sensor.channels) <= set(own.channels) for own in self.vehicle.sensors):
                continue
            more = replace(self.vehicle, sensors=(*self.vehicle.sensors, sensor))
            run = self._fly(candidate, more)
            if run is not None:
                apart = foreseen(more, [run], hypotheses[:2])[0].apart(hypotheses[:2])
                found.append((sensor, float(min(apart[0, 1], apart[1, 0]))))
        best = max(found, key=lambda pair: pair[1], default=None)
        return best if best and best[1] >= TIED else None


def ranked(plans: Sequence[Plan], hypotheses: Sequence[Hypothesis]) -> list[Plan]:
    """Plans with the drop of doubt at these hypotheses' chances, the largest per minute first."""
    chances = [h.chance for h in hypotheses]
    found = [replace(plan, drop=drop_of_doubt(chances, plan.apart)) for plan in plans]
    return sorted(found, key=lambda plan: -plan.per_minute)
