"""Short events: stretches of a few readings that are all off, and packets of waves.

A sensor that stalls or stutters makes the first, and so does a knock; a passing wake or a loose part makes the second.
They are looked for where the innovations lean to one side together, or swing together, by their ranks and over what is
usual in the run: heavy tails alone, an error that is somewhat coloured, or a line that is always there make no event.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri

from ..outliers import spread

LEAST, LEAST_WAVE = 3, 16  # [readings] of an event and of a packet; choices
MOST = 4  # events of a run that are looked at; a choice
Found = list[tuple[float, int, int, float]]  # lean, first reading, number of readings, frequency [rad/s]


@dataclass(frozen=True)
class Events:
    """Stretches of a run's readings, the most telling first.

    Attributes:
        lean: how far the innovations lean or swing together in each, in usual deviations, shape (E,); inf where
            something else shows them.
        spans: first and last time of each [s].
        rad_s: frequencies of packets of waves [rad/s]; 0 of a lean to one side, shape (E,).
        looked: number of stretches that were looked through.
    """

    lean: np.ndarray
    spans: tuple[tuple[float, float], ...]
    rad_s: np.ndarray
    looked: int

    @classmethod
    def known(cls, spans: tuple[tuple[float, float], ...]) -> Events:
        """Stretches that something else than the innovations shows."""
        return cls(np.full(len(spans), np.inf), spans, np.zeros(len(spans)), len(spans))

    @property
    def each(self) -> int:
        """Functions of time of each event: of a packet sine and cosine."""
        return 1 + bool(np.any(self.rad_s))

    def functions(self, t: np.ndarray) -> np.ndarray:
        """Functions of time at instants t, shape (I,), side by side: shape (I, E each)."""
        inside = np.array([(t >= a) & (t <= b) for a, b in self.spans], dtype=float).T
        return inside if self.each == 1 else waves(np.outer(t - t[0], self.rad_s)) * np.repeat(inside, 2, axis=1)


def events(time: np.ndarray, innovation: np.ndarray, longest_s: float) -> Events:
    """Events among innovations over their deviations at these times, shapes (M,); NaN where one does not count."""
    there, scores = _scores(innovation)
    total = np.concatenate([[0.0], np.cumsum(scores)])
    found, looked = Found(), 0
    for length in _lengths(LEAST, there.size):
        lean = (total[length:] - total[:-length]) / np.sqrt(length)
        lean /= max(spread(lean), 1.0)
        brief = time[there[length - 1 :]] - time[there[: lean.size]] < longest_s
        looked += int(np.sum(brief))
        at = np.argsort(-np.abs(lean) * brief)[: MOST * length]
        found += [(float(lean[j]), int(j), length, 0.0) for j in at if brief[j]]
    return _apart(found, time[there], looked)


def packets(time: np.ndarray, innovation: np.ndarray) -> Events:
    """Packets of waves among the same: where a frequency is far louder than it usually is in this run."""
    there, scores = _scores(innovation)
    found, looked, step = Found(), 0, float(np.median(np.diff(time[there]))) if there.size > 1 else 1.0
    for length in _lengths(LEAST_WAVE, there.size):
        every, taper = length // 4, np.hanning(length)
        frames = np.lib.stride_tricks.sliding_window_view(scores, length)[::every] * taper
        power = np.abs(np.fft.rfft(frames, 2 * length)) ** 2 / np.sum(taper**2)
        power /= np.maximum(np.median(power, axis=0) / np.log(2.0), 1.0)
        power[:, :3] = 0.0  # less than a period and a half
        looked += there.size
        for at in np.argsort(-power, axis=None)[:MOST]:
            j, i = np.unravel_index(at, power.shape)
            found.append(
                (float(np.sqrt(2.0 * power[j, i])), int(j) * every, length, float(np.pi * i / (length * step)))
            )
    return _apart(found, time[there], looked)


def _lengths(least: int, size: int) -> Iterator[int]:
    """Lengths of stretches [readings], two to the octave, up to a quarter of all."""
    k = 0
    while (length := round(least * 2.0 ** (0.5 * k))) < size // 4:
        yield length
        k += 1


def _scores(innovation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the innovations that count, and the normal scores of their ranks, shapes (N,)."""
    there = np.flatnonzero(np.isfinite(innovation))
    _, place, count = np.unique(innovation[there], return_inverse=True, return_counts=True)
    return there, ndtri((np.cumsum(count) - 0.5 * count)[place] / max(there.size, 1))  # of the middle of equal ranks


def _apart(found: Found, time: np.ndarray, looked: int) -> Events:
    """The most telling, none of which overlap; time: of the innovations that count."""
    chosen = Found()
    for one in sorted(found, key=lambda f: -abs(f[0])):
        if len(chosen) < MOST and all(one[1] + one[2] <= i or i + n <= one[1] for _, i, n, _ in chosen):
            chosen.append(one)
    spans = tuple((float(time[j]), float(time[j + n - 1])) for _, j, n, _ in chosen)
    return Events(np.array([f[0] for f in chosen]), spans, np.array([f[3] for f in chosen]), looked)


def waves(phase: np.ndarray) -> np.ndarray:
    """Sine and cosine of every column of phases, side by side, shape (I, 2 K)."""
    out = np.empty((*phase.shape, 2))
    np.sin(phase, out=out[:, :, 0])
    np.cos(phase, out=out[:, :, 1])
    return out.reshape(phase.shape[0], -1)
