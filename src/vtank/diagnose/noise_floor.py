"""One noise level for all hypotheses.

Left to itself, each hypothesis would call its own misfit noise. The level is therefore taken from the explanation
that needs the least of it and then holds for everybody: measurement variance, and an Ornstein-Uhlenbeck disturbance
for turbulence and wake, by the likelihood of the innovations.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np

from ..estimate.noise_likelihood import linearised, squares_and_logs
from ..estimate.noise_search import COLOUR, DISTURBANCE, HOPELESS, Likelihood, NoiseSearch, together
from ..estimate.observed import RANGE
from ..estimate.problem import Noise, Problem
from ..estimate.simplex import Walk
from .evidence import STILL_SIGMA, Fitted, Setting, evaluate
from .freeform.pursuit import pursue

# How much more of a disturbance than usual there may be, what is several times as much, and the memory of what is usual
STILL_SPREAD, SEVERAL, STILL_MEMORY_S = 0.7, 4.0, 2.0  # [powers of e], [-], [s]; guesses
CONTENDERS = 2  # hypotheses whose own noise level is looked at
ROUNDS = 2  # alternations of fit and noise level
SETTLED = 0.2  # change of the log of deviations that no longer matters
LEAST_SIGMA = 1e-5  # [m/s2] disturbance too weak to matter over a run: 0.1 mm after 4 s
LARGEST_SIGMA = float(np.exp(3.0))  # [m/s2, m] disturbance or coloured error beyond any water's
DRIFTS = 2.0  # coloured error over the white one from which it may stand for errors in windows; a choice
COLOURED = 5.0  # log-likelihood that the two numbers of a coloured error must gain
MEMORY_S = (0.2, 30.0)  # [s] shortest and longest memory of the disturbance that is looked for
STARTS_S = (0.5, 4.0)  # [s] memories from which the search sets out: the likelihood often has two hills
EVALUATIONS = 80  # of the likelihood in a search for two numbers; twice that for four
FIRST_STEPS = (-1.0, 0.7, -0.7, 0.5)  # of the search, in powers of e


def noise_at(problem: Problem, theta: np.ndarray, usual: float = np.inf, exact: bool = False) -> Noise:
    """Most probable noise level given the innovations at theta, without or with a coloured error of the sonar.

    usual: disturbance that is no surprise [m/s2]; inf where none is. exact: search on with the extended Kalman filter
    itself, for recordings more disturbed than driven. So it is in any case where the simulation runs away, which the
    filter may well follow.
    """
    before = partial(log_prior, usual=usual)
    linear, noise = partial(squares_and_logs, linearised(problem, theta)), problem.noise
    kinds = [(time_s, coloured) for coloured in (False, True) for time_s in STARTS_S]
    tried = together([_search(linear, noise, before, *kind) for kind in kinds])
    (plain, cost), (coloured, other) = (min(some, key=lambda f: f[1]) for some in (tried[:2], tried[2:]))
    found = coloured if other < cost - COLOURED else plain
    if not exact and min(cost, other) < HOPELESS:
        return found
    filtered = partial(_filtered, problem, theta)
    return together([_search(filtered, found, before, found.correlation_time, found.colour_sigma > 0.0)])[0][0]


def _filtered(problem: Problem, theta: np.ndarray, noises: Sequence[Noise]) -> tuple[np.ndarray, np.ndarray, int]:
    """The same as `squares_and_logs`, by the extended Kalman filter."""
    found, used = [], np.concatenate([problem.used(k) for k in range(len(problem.runs))])
    for noise in noises:
        filtered = problem.with_noise(noise).filter(theta)
        e, S = (
            np.concatenate(parts)[used] for parts in zip(*((f.innovation, f.variance) for f in filtered), strict=True)
        )
        found.append((np.sum(e * e / S), np.sum(np.log(S))))
    squares, logs = np.array(found).T
    return squares, logs, int(used.sum())


def _search(
    likelihood: Likelihood, noise: Noise, before: Callable[[Noise], float], memory_s: float, coloured: bool
) -> tuple[NoiseSearch, Walk]:
    """The search for the most probable noise level of one kind."""
    start = [max(noise.sigma, 10.0 * LEAST_SIGMA), memory_s]
    if coloured:
        start += [noise.colour_sigma or float(np.sqrt(noise.variance[0])), min(noise.colour_time, 0.5)]
    parts = (DISTURBANCE, COLOUR)[: 1 + coloured]
    search = NoiseSearch(likelihood, noise, (LEAST_SIGMA, LARGEST_SIGMA), MEMORY_S, parts, before)
    return search, search.walk(np.log(start), FIRST_STEPS[: len(start)], EVALUATIONS * (1 + coloured), 0.05, 0.3)


def settle(setting: Setting, fits: Sequence[Fitted], least: float = -np.inf) -> tuple[Setting, float]:
    """The setting at the noise level of the contender that, with its own level, is most likely; and how likely.

    Contenders are the likeliest hypotheses, alone and with what has no name beside them: what repeats, or is there in
    a window only, is no turbulence, whatever level would swallow it, and an error in windows no colour of all readings.
    Of a foreign vehicle, whose model is not complete before its effects are found one by one, the hypotheses alone are
    asked, whatever its waters are. least: of the setting's own level, which stays where nothing is likelier.
    """
    ranked = sorted(fits, key=lambda f: -f.log_evidence)[:CONTENDERS]
    refit = next((f for f in fits if f.hypothesis.name == "parameters"), ranked[0])
    bases = {id(fit): fit for fit in (refit, ranked[0])}.values()
    with ThreadPoolExecutor(2) as pool:
        alone = list(pool.map(lambda fit: _alternate(setting, fit), ranked))
    if setting.foreign:
        likely, noise = max(alone, key=lambda pair: pair[0])
        return setting.with_noise(noise), likely
    coloured = np.unique(np.concatenate([run.kind[run.coloured > 0.0] for run in setting.runs])).tolist()
    likeliest = max(alone, key=lambda pair: pair[0])[1]
    calm = [still(likeliest, setting.usual, coloured)]
    if coloured and likeliest.colour_sigma > DRIFTS * np.sqrt(likeliest.variance[coloured[0]]):
        calm.append(still(likeliest, setting.usual, ()))
    with ThreadPoolExecutor(2) as pool:
        beyond = list(pool.map(lambda pair: _beyond(setting, *pair), product(bases, calm)))
    likely, noise = max([(least, setting.noise), *alone, *beyond], key=lambda pair: pair[0])
    return setting.with_noise(noise), likely


def still(noise: Noise, usual: float = STILL_SIGMA, coloured: Collection[int] = (RANGE,)) -> Noise:
    """The noise in still water: no more of a disturbance, nor of a slower one, than usual, and no coloured error.

    What was coloured is white, in the channels of which it is, and gone in others.
    """
    variance = tuple(v + noise.colour_sigma**2 * (kind in coloured) for kind, v in enumerate(noise.variance))
    noise = replace(noise, variance=variance, colour_sigma=0.0)
    if noise.sigma <= usual and noise.correlation_time <= STILL_MEMORY_S:
        return noise
    return replace(noise, sigma=min(noise.sigma, usual), correlation_time=STILL_MEMORY_S)


def plausible(noise: Noise, usual: float = STILL_SIGMA) -> bool:
    """Whether a disturbance is no more than water that was left alone has, several times over."""
    return noise.sigma <= SEVERAL * usual


def log_prior(noise: Noise, usual: float = STILL_SIGMA) -> float:
    """Log density of a disturbance beforehand, over its largest: falls where it moves more than still water does.

    By its size, and by the speed that it gives in its memory: a weak one that lasts moves a vehicle as far.
    """
    return _above(noise.sigma / usual * max(noise.correlation_time / STILL_MEMORY_S, 1.0))


def rarity(noise: Noise, usual: float = STILL_SIGMA) -> float:
    """The same by its size alone, however long it lasts."""
    return _above(noise.sigma / usual)


def _above(times: float) -> float:
    return -0.5 * float(np.log(max(times, 1.0)) / STILL_SPREAD) ** 2


def _beyond(setting: Setting, fit: Fitted, noise: Noise) -> tuple[float, Noise]:
    """Log evidence of a hypothesis with what has no name beside it, and the noise level that then is left."""
    found = []
    for turn in range(ROUNDS):
        fit = evaluate(setting.with_noise(noise), fit.hypothesis, [fit.start()])
        free = pursue(fit, pitching=False)
        found.append((fit.log_evidence + free.gain + log_prior(noise, setting.usual), noise))
        if not free.components or turn == ROUNDS - 1:
            break
        noise = noise_at(free.cleared(), fit.optimum.theta, setting.usual)
    return max(found, key=lambda pair: pair[0])


def _apart(one: Noise, other: Noise) -> float:
    """By how much the larger of disturbance and errors of the readings differ, in powers of e."""
    sizes = [(max(n.sigma, LEAST_SIGMA), np.sqrt(n.variance[0] + n.colour_sigma**2)) for n in (one, other)]
    return float(np.max(np.abs(np.diff(np.log(sizes), axis=0))))


def _alternate(setting: Setting, fit: Fitted) -> tuple[float, Noise]:
    """Log evidence of a hypothesis with the noise level it prefers, and that level: fit and level in turns."""
    usual = np.inf if setting.foreign else setting.usual
    for _ in range(ROUNDS):
        noise = noise_at(fit.problem, fit.optimum.theta, usual, setting.foreign)
        change = _apart(noise, fit.problem.noise)
        fit = evaluate(setting.with_noise(noise), fit.hypothesis, [fit.start()])
        if change < SETTLED:
            break
    return fit.log_evidence + log_prior(noise, usual), noise
