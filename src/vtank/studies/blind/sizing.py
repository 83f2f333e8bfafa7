"""Sizes of the causes, solved so that each leaves the wanted signal-to-noise ratio d after the refit.

d is found on noise-free flights of the surge axis with the pilot in the loop, as the tank would fly them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ...effects import BY_NAME
from ...errors import InputError
from ...experiment import check_motion
from .case import Case, Frequencies, draw_case, given
from .cause import is_limit, with_limit
from .fly import Trip
from .refit import Fit, Recording, refit
from .replay import Replay
from .whitening import whitener

TRIALS, CLOSE = 8, 0.15  # steps of the search, and relative error of d at which it ends; choices
LEAST = 2.5  # d below which a case is drawn anew; the easiest stratum of the score begins at 3
ATTEMPTS = 40
STEEPEST = 5.0  # largest factor on a size in one step


def noise_free(case: Case, plans: Sequence[Trip]) -> list[Recording]:
    """Runs as they would be recorded without noise, with the noise they will have; InputError where a wall is hit."""
    recordings = []
    for plan in plans:
        replay = Replay(plan)
        n_read, range_m, n = replay.pushed(case.causes)
        check_motion(plan.scenario, replay.motion[0])
        x, u = replay.motion[:, : n.size].copy()
        noise = whitener(plan, x, u, n)
        recordings.append(Recording(replay, n_read, range_m, noise))
    return recordings


def post_refit(case: Case, recordings: Sequence[Recording]) -> Fit:
    """The refit of the nominal's own parameters to the noise-free recordings; its size is d."""
    return refit(recordings, case.truth.vector())


def ready_case(
    seed: int, number: int, frequencies: Frequencies, familiar: bool = False, first: int = 0
) -> tuple[Case, int]:
    """Case `number` with its sizes, and the attempt that gave it; attempts before `first` are known to fail."""
    for attempt in range(first, first + ATTEMPTS):
        case = draw_case(seed, number, attempt, frequencies, familiar)
        try:
            case = _with_top(case)
            case = case.sized([_size(case, i) for i in range(len(case.causes))])
            noise_free(case, [case.plan(k) for k in range(len(case.experiment.scenarios))])
        except InputError:
            continue
        return case, attempt
    names = "+".join(cause.name for cause in case.causes) or case.kind
    raise InputError(f"case {number} ({names}): no experiment in {ATTEMPTS} shows it without hitting a wall")


def _with_top(case: Case) -> Case:
    """The case with a thrust limit measured from the largest propeller speed that the case would have without it."""
    if not any(map(is_limit, case.causes)):
        return case
    plain = replace(case, causes=())
    top = max(float(np.max(np.abs(r.n_read))) for r in noise_free(plain, given(plain)))
    return replace(case, causes=tuple(with_limit(cause, top) for cause in case.causes))


def _size(case: Case, i: int) -> float:
    """Size of cause i by itself; InputError where it stays too small to see, or hits a wall."""
    cause, wanted = case.causes[i], case.wanted[i]
    if cause.known and BY_NAME[cause.name].standing == "absorbed":
        return 1.0 if cause.size < cause.largest else cause.largest
    best: tuple[float, float] | None = None
    for _ in range(TRIALS if cause.solved else 1):
        alone = replace(case, causes=(cause,))
        d = post_refit(alone, noise_free(alone, given(alone))).size
        if best is None or abs(d - wanted) < abs(best[1] - wanted):
            best = cause.size, d
        if abs(d / wanted - 1.0) < CLOSE or (d < wanted and cause.size >= cause.largest):
            break
        factor = wanted / d if d > 0.0 else STEEPEST
        cause = cause.sized(cause.size * min(max(factor, 1.0 / STEEPEST), STEEPEST))
    assert best is not None
    if best[1] < LEAST:
        raise InputError(f"{cause.name}: d = {best[1]:.2g} at its largest")
    return best[0]
