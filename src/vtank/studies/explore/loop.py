"""The loop: what is possible, the run that parts it best, the flight, the diagnosis, until it is decided."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial, reduce
from operator import add

import numpy as np

from ...diagnose.whole import Foreseen, Hypothesis, WholeDiagnosis, diagnose, fitted, foreseen, possible
from ...errors import InputError
from ...record import Run
from .candidates import Candidate
from .planner import TIED, Plan, Planner, ranked

Fly = Callable[[str, int], Run]  # text of a scenario, seed -> recording
Say = Callable[[str], None]
SURE = 0.95  # probability from which it is decided
POSSIBLE = 0.01  # probability from which a hypothesis is looked at
RIVALS = 6  # that are looked at, at most
EXPLAINED = 0.5  # share of the error that may be left where effects are named; a choice
LEAST = 0.01  # [nats] of the doubt, below which a run is not worth flying; a choice


@dataclass(frozen=True, eq=False)
class Step:
    """One turn of the loop: the plan that was followed, the minutes flown in all, and what is said after it."""

    plan: Plan
    minutes: float
    diagnosis: WholeDiagnosis


@dataclass(frozen=True, eq=False)
class Explored:
    """What a loop came to.

    Attributes:
        steps: its turns, at least one. ended: decided; tied, where no run decides between what is left; seen, where no
            run shows more; or minutes, where these were spent.
        chance: of the answer. plan: the run that would come next; None where nothing is left to be told.
        sensor: instrument that would decide, its channels, and deviations by which it sets the first two apart.
        runs: that were flown.
    """

    steps: tuple[Step, ...]
    ended: str
    chance: float
    plan: Plan | None
    sensor: tuple[str, tuple[str, ...], float] | None
    runs: tuple[Run, ...] = field(repr=False)

    @property
    def answer(self) -> str:
        """none, unknown, or effects at places joined with +."""
        return answer_of(self.steps[-1].diagnosis)


def explore(
    planner: Planner, fly: Fly, minutes: float, *, fixed: bool = False, effects: Sequence[str] | None = None,
    say: Say = lambda text: None,
) -> Explored:  # fmt: skip
    """Fly and diagnose until it is decided, or the minutes are spent.

    fixed: fly the candidates in their order instead, as a plan without a planner would. effects: as of `diagnose`.
    InputError where not one run fits into the minutes, or no candidate can be flown.
    """
    doubt = Doubt(planner, effects)
    runs: list[Run] = []
    steps: list[Step] = []
    spent, left, ended, chance = 0.0, list(planner.flown), "", 0.0
    say("what every run would tell")
    plans = doubt.plans(None)
    while True:
        plan = _next(plans, left, fixed, minutes - spent)
        if plan is None:
            break
        left = [candidate for candidate in left if candidate is not plan.candidate] if fixed else left
        say(f"flying: {plan.candidate.words}")
        runs.append(replace(fly(plan.candidate.text, len(runs) + 1), name=f"run_{len(runs) + 1}"))
        spent += plan.candidate.minutes
        so_far = f"{len(runs)} runs, {spent:.1f} of at most {minutes:g} min"
        say(f"diagnosing {so_far}")
        diagnosis = diagnose(runs, planner.vehicle, None, effects, partial(_beside, say, so_far))
        steps.append(Step(plan, spent, diagnosis))
        chance, decided = doubt.decided(diagnosis, runs)
        plans = [] if decided else doubt.plans(diagnosis)
        ended = "decided" if decided else doubt.ended(plans)
        if ended:
            break
    if not steps:
        raise InputError(f"{minutes:g} min: expected room for one run of {planner.flown[0].minutes:g} min at least")
    sensor = doubt.sensor(plans) if ended == "tied" else None
    return Explored(tuple(steps), ended or "minutes", chance, plans[0] if plans else None, sensor, tuple(runs))


def _beside(say: Say, so_far: str, text: str) -> None:
    say(f"{so_far}: {text}")


def _next(plans: Sequence[Plan], left: Sequence[Candidate], fixed: bool, minutes: float) -> Plan | None:
    """The best plan that fits into the minutes; of a fixed order its next."""
    fits = [plan for plan in plans if plan.candidate.minutes <= minutes + 1e-9]
    if fixed:
        return next((plan for candidate in left for plan in fits if plan.candidate is candidate), None)
    return fits[0] if fits else None


def answer_of(diagnosis: WholeDiagnosis) -> str:
    """What a diagnosis names most probable: none, unknown, or effects at places; own parameters are no effect."""
    chances: dict[str, float] = {}
    for name, chance in diagnosis.probabilities.items():
        short = "unknown" if name.startswith("unknown@") else "none" if name == "parameters" else name
        chances[short] = chances.get(short, 0.0) + chance
    return max(chances, key=lambda name: chances[name])


class Doubt:
    """What is still possible about a vehicle, and what the candidates would tell of it."""

    def __init__(self, planner: Planner, effects: Sequence[str] | None) -> None:
        self.planner = planner
        self.open = possible(planner.vehicle, planner.flights, effects)
        self._prior = np.array([h.chance for h in self.open])
        self._unseen: list[Plan] = []
        self._past: list[Foreseen] = []
        self._hypotheses: list[Hypothesis] = self.open

    def plans(self, diagnosis: WholeDiagnosis | None) -> list[Plan]:
        """What each candidate would tell, the best first: of effects not seen yet, or of what was found and rivals."""
        found = [] if diagnosis is None or answer_of(diagnosis) == "none" else self._found(diagnosis)
        if len(found) > 1:
            self._hypotheses = found
            return self.planner.plans(found, noise=diagnosis.selection.best.fit.noise if diagnosis else None)
        self._hypotheses = self.open
        if not self._unseen:
            self._unseen = self.planner.plans(self.open)
        return ranked(self._unseen, self.open)

    def _found(self, diagnosis: WholeDiagnosis) -> list[Hypothesis]:
        """Sets of effects that were fitted and are possible, the most probable first."""
        sets = diagnosis.selection.sets
        chances = [(name, p) for name, p in diagnosis.probabilities.items() if name in sets and p >= POSSIBLE]
        return [fitted(sets[name], name, p) for name, p in chances[:RIVALS]]

    def decided(self, diagnosis: WholeDiagnosis, runs: Sequence[Run]) -> tuple[float, bool]:
        """Chance of the answer, and whether that and the budget are enough.

        That there is no effect is as sure as the runs would have shown small ones: a size at which an effect would
        have been seen at d deviations is the less likely by exp(-d^2 / 2).
        """
        verdict, answer = diagnosis.verdict, answer_of(diagnosis)
        if answer != "none":
            chance = verdict.probability
            known = verdict.kind in ("effect", "effects", "unknown") and not verdict.doubt
            return chance, known and chance >= SURE and (verdict.kind == "unknown" or diagnosis.budget.left < EXPLAINED)
        self._past += foreseen(self.planner.vehicle, runs[len(self._past) :], self.open)
        seen = reduce(add, self._past).apart(self.open)[:, 0]
        chances = self._prior * np.exp(-0.5 * seen**2)
        self.open = [replace(h, chance=float(c)) for h, c in zip(self.open, chances, strict=True)]
        said = sum(p for name, p in diagnosis.probabilities.items() if name in ("none", "parameters"))
        chance = said * float(chances[0] / chances.sum())
        return chance, chance >= SURE and verdict.kind != "undecided"

    def ended(self, plans: Sequence[Plan]) -> str:
        """Why no run is worth flying: tied, seen, or "" where one is."""
        if self._hypotheses is not self.open and all(_between(plan) < TIED for plan in plans):
            return "tied"
        return "seen" if plans[0].drop < LEAST else ""

    def sensor(self, plans: Sequence[Plan]) -> tuple[str, tuple[str, ...], float] | None:
        """The instrument that would set the two most probable apart, its channels, and by how many deviations."""
        found = self.planner.sensor(self._hypotheses, max(plans, key=_between).candidate)
        return (found[0].name, found[0].channels, found[1]) if found else None


def _between(plan: Plan) -> float:
    """Deviations between the two most probable hypotheses."""
    return float(min(plan.apart[0, 1], plan.apart[1, 0]))
