"""Water that is uneven in time: runs, and stretches of them, in which a disturbance is several times as strong.

Runs are as loud as they are for every hypothesis. A louder stretch is a rival of forces that are there for a while:
these have a shape, a burst of turbulence has but a size. Stretches are found one after the other, each for what it adds
to the likelihood of the innovations, less what was looked through.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..estimate.noise_likelihood import Linear, apart, rows_of, squares_and_logs, whiten
from ..estimate.problem import Noise, Problem
from ..lanes import WIDTH
from .evidence import Fitted, Setting, evaluate
from .freeform.dictionary import BINS, SHORTEST_S
from .freeform.pursuit import WORTHWHILE, pursue
from .noise_floor import SEVERAL, log_prior, still

Array = NDArray[np.float64]
LOUDER = (2.5, 6.0)  # times as strong a disturbance as elsewhere, that are tried; they multiply where stretches overlap
LENGTHS = (1, 2, 4, 8, 16)  # of stretches, in bins; choices
QUIETER = (1.0, 0.8, 0.6, 0.45)  # of the disturbance as it was, that there then is elsewhere; choices
UNEVEN = 1e-4  # prior odds that a disturbance is uneven; a guess: of one burst, a force for a while is the likelier
MOST = 8  # stretches at most; a choice
LEVELS = 2.0 ** np.arange(-2.5, 2.6, 0.5)  # of a run's disturbance over what it was, alike likely; choices
UNLIKE = 4.6  # log evidence from which runs are not alike: odds of a hundred


def uneven(fit: Fitted, usual: float) -> float:
    """Log evidence of a fit by a disturbance that is louder for a while, over that by an even one; 0 where none is.

    usual: disturbance that is no surprise [m/s2].
    """
    before, runs = fit.problem.noise, apart(fit.problem, fit.optimum.theta)
    noise, spans = before, [_spans(run) for run in runs]
    if noise.sigma == 0.0 or not any(map(len, spans)):
        return 0.0
    looked = float(np.log(len(LOUDER) * sum(map(len, spans))))
    start = likelihood = float(_likelihoods(runs, [noise])[0])
    loudest, found = 1.0, 0
    while found < MOST:
        most = SEVERAL * usual / noise.sigma
        tried = [_tried(run, noise, own, most) for run, own in zip(runs, spans, strict=True)]
        best = [float(gains.max(initial=-np.inf)) for gains, _ in tried]
        k = int(np.argmax(best))
        if best[k] - looked < WORTHWHILE:
            break
        gains, loud = tried[k]
        column = loud[:, int(np.argmax(gains))]
        runs[k] = runs[k].louder(np.repeat(column[:, None], WIDTH, axis=1))
        loudest, found = max(loudest, float(column.max())), found + 1
        quieter = [replace(noise, sigma=share * noise.sigma) for share in QUIETER]
        likelihoods = _likelihoods(runs, quieter)
        noise, likelihood = quieter[int(np.argmax(likelihoods))], float(likelihoods.max())
    prior = log_prior(replace(noise, sigma=loudest * noise.sigma), usual) - log_prior(before, usual)
    return max(likelihood - start - found * looked + prior + float(np.log(UNEVEN)), 0.0) if found else 0.0


def unlike(setting: Setting, fit: Fitted) -> Setting:
    """The setting with each run as loud as is likeliest; as it was where they may be alike, or the noise is not sought.

    fit: the likeliest hypothesis, beside which what has no name is taken out first as in still water, lest what acts in
    one run passes for its water; which is no rival of what mostly repeats. The noise then has the mean square of all.
    """
    if setting.foreign or setting.noise.sigma == 0.0 or len(setting.runs) < 2:
        return setting
    fit = evaluate(setting, fit.hypothesis, [fit.start()])
    if np.all(loudness(fit.problem, fit.optimum.theta) == 1.0):
        return setting
    noise = still(setting.noise, setting.usual)
    fit = evaluate(setting.with_noise(noise), fit.hypothesis, [fit.start()])
    free = pursue(fit, pitching=False)
    if free.mostly_repeats:
        return setting
    loud = loudness(free.cleared() if free.components else fit.problem, fit.optimum.theta)
    usual = float(np.sqrt(np.mean(loud**2)))
    runs = tuple(replace(run, loud=float(one) / usual) for run, one in zip(setting.runs, loud, strict=True))
    return replace(setting, runs=runs).with_noise(replace(noise, sigma=usual * noise.sigma))


def loudness(problem: Problem, theta: Array) -> Array:
    """The disturbance of each run over that of the problem's noise, (R,); ones where they may be alike."""
    likely = np.array([_louder(run, problem.noise, LEVELS * run.loud[:, :1]) for run in apart(problem, theta)])
    alike, own = (np.logaddexp.reduce(part, axis=-1) - np.log(LEVELS.size) for part in (likely.sum(axis=0), likely))
    return LEVELS[np.argmax(likely, axis=1)] if np.sum(own) - alike > UNLIKE else np.ones(len(likely))


def _likelihoods(runs: Sequence[Linear], noises: Sequence[Noise]) -> Array:
    squares, logs, _ = squares_and_logs([(1, run) for run in runs], noises)
    return np.asarray(-0.5 * (squares + logs))


def _spans(run: Linear) -> NDArray[np.bool_]:
    """Stretches of a run: which measurements each holds, (L, M)."""
    time_s = np.cumsum(run.gap_s[:, 0])
    count = int(min(max(time_s[-1] // SHORTEST_S, 1), BINS))
    bins = np.minimum((time_s / max(time_s[-1], 1e-9) * count).astype(int), count - 1)
    begins = [(first, length) for length in LENGTHS if 2 * length < count
              for first in range(0, count - length + 1, max(length // 2, 1))]  # fmt: skip
    return np.array([(first <= bins) & (bins < first + length) for first, length in begins]).reshape(-1, bins.size)


def _tried(run: Linear, noise: Noise, spans: NDArray[np.bool_], most: float) -> tuple[Array, Array]:
    """What a louder stretch adds to the log-likelihood of a run, (L,), and how loud measurements then are, (M, L).

    None is louder than `most` times the disturbance, beyond which no water is plausible.
    """
    now = run.loud[:, :1]
    loud = np.hstack([now, *(np.where(spans.T, times * now, now) for times in LOUDER)])
    totals = _louder(run, noise, loud)
    return np.where(loud[:, 1:].max(axis=0) <= most, totals[1:] - totals[0], -np.inf), loud[:, 1:]


def _louder(run: Linear, noise: Noise, loud: Array) -> Array:
    """Log-likelihood of a run under disturbances that are as loud at its measurements, (M, L); shape (L,)."""
    level, totals = np.repeat(rows_of([noise]).T, WIDTH, axis=1), np.empty(loud.shape[1])
    for first in range(0, loud.shape[1], WIDTH):
        some = np.minimum(np.arange(first, first + WIDTH), loud.shape[1] - 1)
        found = np.empty((2, WIDTH))
        whiten(run.louder(loud[:, some]), level, found)
        totals[first : first + WIDTH] = -0.5 * found.sum(axis=0)[: loud.shape[1] - first]
    return totals
