"""The frequency: lines in the spectrum of what the refit cannot predict, and whether they follow the propeller.

A simulator without a gap leaves innovations that are white, whose periodogram, in units of the noise, is exponentially
distributed about one. A line counts when it stands above what the largest of all ordinates of all runs reaches by
chance in one of a hundred data sets (Fisher, Proc. R. Soc. A 125 (1929); Scargle, Astrophys. J. 263 (1982)), both
against the noise level and against its neighbours, so that a broad excess is not a row of lines.

Coherence with the input (its thrust, n|n|) is averaged over sine tapers: Riedel, Sidorenko, IEEE Trans. Signal
Process. 43 (1995). A line that coheres moves with the propeller; one that does not has a life of its own.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.ndimage import median_filter

from ...estimate.observed import Observed
from ..freeform import drive_frequency
from ..selection import Selection
from .gap import whitened
from .time import LEVEL

MOST_ORDINATES = 400  # frequencies looked at: 3.3 Hz for a run of 120 s
MOST_LINES = 4  # lines told per run, the strongest
NEIGHBOURS = 41  # ordinates whose median is the background of a line
TAPERS = 6  # sine tapers of the coherence; bandwidth +-3.5 ordinates
WIDTH = 4  # ordinates either side of a line that belong to it
ON_A_MULTIPLE = 1.0  # ordinates by which a line may miss a multiple of the drive frequency


@dataclass(frozen=True)
class Line:
    """A line of the residual spectrum.

    Attributes:
        run: the run's name.
        frequency_rad_s: where it stands [rad/s].
        power: over that of the noise [-].
        false_alarm: probability of so strong a line by chance, in all runs together.
        coherence: with the input [-].
        coherent: whether that is significant at LEVEL.
        multiple: of the drive frequency that it stands on, or None.
        drive_rad_s: frequency at which the run's input is strongest [rad/s].
    """

    run: str
    frequency_rad_s: float
    power: float
    false_alarm: float
    coherence: float
    coherent: bool
    multiple: int | None
    drive_rad_s: float

    def document(self) -> dict[str, Any]:
        """As plain data."""
        return {"run": self.run, "frequency": self.frequency_rad_s, "power": self.power,
                "false_alarm": self.false_alarm, "coherence": self.coherence, "coherent": self.coherent,
                "drive": self.drive_rad_s, "multiple_of_drive": self.multiple}  # fmt: skip


@dataclass(frozen=True)
class Spectrum:
    """Residual spectrum of one run.

    Attributes:
        run: the run's name.
        frequency_rad_s: shape (F,) [rad/s].
        power: of the innovations over that of the noise, shape (F,) [-].
        significant: power from which a line is significant, shape (F,) [-].
        coherence: with the input, shape (F,) [-].
        coherent: coherence that is significant at LEVEL at one frequency [-].
        drive_rad_s: frequency at which the input is strongest [rad/s].
        lines: the strongest significant lines.
    """

    run: str
    frequency_rad_s: np.ndarray
    power: np.ndarray
    significant: np.ndarray
    coherence: np.ndarray
    coherent: float
    drive_rad_s: float
    lines: tuple[Line, ...]


def residual_spectra(selection: Selection) -> tuple[Spectrum, ...]:
    """Spectrum of the refit's innovations, per run."""
    refit, runs = selection.refit, selection.setting.runs
    ends = np.cumsum([run.time_s.size for run in runs])[:-1]
    grids = [frequencies(run.time_s) for run in runs]
    needed = largest_by_chance(sum(grid.size for grid in grids))
    parts = np.split(whitened(refit), ends)
    return tuple(_spectrum(run, r, grid, needed) for run, r, grid in zip(runs, parts, grids, strict=True))


def frequencies(time_s: np.ndarray) -> np.ndarray:
    """Fourier frequencies of a run [rad/s], up to half its sample rate or MOST_ORDINATES, shape (F,)."""
    step = float(np.median(np.diff(np.unique(time_s))))
    count = max(min(int((time_s[-1] - time_s[0]) / step) // 2, MOST_ORDINATES), 1)
    return 2.0 * np.pi * np.arange(1, count + 1) / (time_s[-1] - time_s[0] + step)


def largest_by_chance(ordinates: int) -> float:
    """What the largest of so many exponential ordinates of mean one exceeds with probability LEVEL."""
    return float(-np.log(-np.expm1(np.log1p(-LEVEL) / ordinates)))


def waves(time_s: np.ndarray, frequency: np.ndarray) -> np.ndarray:
    """exp(-i w t) at all stamps, shape (F, M), for the multiples w of the first frequency: powers of one wave."""
    first = np.exp(-1j * frequency[0] * (time_s - time_s[0]))
    return np.multiply.accumulate(np.broadcast_to(first, (frequency.size, first.size)), axis=0)


def periodogram(time_s: np.ndarray, values: np.ndarray, E: np.ndarray) -> np.ndarray:
    """Power of unit white noise is one on average; E: `waves`. Hann window, any stamps, shape (F,)."""
    phase = (time_s - time_s[0]) / (time_s[-1] - time_s[0])
    taper = np.sin(np.pi * phase) ** 2
    return np.asarray(np.abs(E @ (values * taper)) ** 2 / np.sum(taper**2))


def coherence(time_s: np.ndarray, a: np.ndarray, b: np.ndarray, E: np.ndarray) -> np.ndarray:
    """Magnitude-squared coherence of two signals at the same stamps, averaged over TAPERS; E: `waves`, shape (F,)."""
    phase = (time_s - time_s[0]) / (time_s[-1] - time_s[0])
    tapers = np.sin(np.pi * np.outer(phase, np.arange(1, TAPERS + 1)))
    A, B = (E @ (tapers * (signal - np.mean(signal))[:, None]) for signal in (a, b))
    cross = np.abs(np.sum(A * np.conj(B), axis=1)) ** 2
    whole = np.sum(np.abs(A) ** 2, axis=1) * np.sum(np.abs(B) ** 2, axis=1)
    return np.asarray(cross / np.maximum(whole, 1e-300))


def _spectrum(run: Observed, residual: np.ndarray, grid: np.ndarray, needed: float) -> Spectrum:
    E = waves(run.time_s, grid)
    power = periodogram(run.time_s, residual, E)
    background = median_filter(power, size=NEIGHBOURS, mode="reflect") / np.log(2.0)
    significant = needed * np.maximum(background, 1.0)
    held = run.input[np.clip(np.searchsorted(run.input_time_s, run.time_s, side="right") - 1, 0, None)]
    thrust = held if run.input_name == "thrust_N" else held * np.abs(held)
    shared = coherence(run.time_s, residual, thrust, E)
    coherent = 1.0 - LEVEL ** (1.0 / (TAPERS - 1))
    drive = drive_frequency(run.input_time_s, run.input)
    spectrum = Spectrum(run.name, grid, power, significant, shared, coherent, drive, ())
    return replace(spectrum, lines=_lines(spectrum, needed))


def _lines(s: Spectrum, needed: float) -> tuple[Line, ...]:
    """The strongest ordinates above the level, each WIDTH away from any stronger one."""
    lines: list[Line] = []
    taken = np.zeros(s.power.size, bool)
    total = LEVEL / np.exp(-needed)  # effective number of ordinates in all runs
    for i in np.argsort(-s.power / s.significant):
        if s.power[i] <= s.significant[i] or len(lines) == MOST_LINES:
            break
        if not taken[i]:
            ratio = s.power[i] * needed / s.significant[i]
            chance = float(-np.expm1(-total * np.exp(-ratio)))
            lines.append(Line(s.run, float(s.frequency_rad_s[i]), float(s.power[i]), chance, float(s.coherence[i]),
                              bool(s.coherence[i] > s.coherent), _multiple(s, i), s.drive_rad_s))  # fmt: skip
        taken[max(i - WIDTH, 0) : i + WIDTH + 1] = True
    return tuple(lines)


def _multiple(s: Spectrum, i: int) -> int | None:
    if s.drive_rad_s <= 0.0:  # a constant input
        return None
    nearest = round(float(s.frequency_rad_s[i] / s.drive_rad_s))
    miss = abs(s.frequency_rad_s[i] - nearest * s.drive_rad_s)
    return nearest if nearest >= 1 and miss <= ON_A_MULTIPLE * s.frequency_rad_s[0] else None
