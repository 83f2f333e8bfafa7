"""Excitations: the sinusoids, steps and sweeps commanded to the vehicle.

A position excitation [m] is a distance ahead of the start, commanded as a range to the wall and followed in closed
loop. A speed excitation [rev/s] is sent to the propellers as it is. The unit of the amplitude's key tells which.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .section import LARGEST, Section

Array = NDArray[np.float64]
Signal = tuple[Array, Array]  # value and its rate


@dataclass(frozen=True)
class Excitation:
    """What is commanded over time.

    Attributes:
        kind: one of KINDS.
        loop: "position" (amplitudes in m, closed loop) or "speed" (rev/s, open loop).
        amplitudes: of each component [m or rev/s].
        frequencies_rad_s: of each component; of a chirp, where it starts and ends [rad/s].
        offset: mean of the command [m or rev/s].
        ramp_s: time over which the whole command is faded in, (1 - cos)/2 [s].
        phase_rad: of a single sinusoid at t = 0 [rad].
        push_s, coast_s: of step and coast-down, repeated ahead, astern, astern, ahead [s].
    """

    kind: str
    loop: str
    amplitudes: tuple[float, ...]
    frequencies_rad_s: tuple[float, ...] = ()
    offset: float = 0.0
    ramp_s: float = 0.0
    phase_rad: float = 0.0
    push_s: float = 0.0
    coast_s: float = 0.0

    def command(self, time_s: Array, duration_s: float) -> Signal:
        """Command [m or rev/s] and its rate [per s] at these times, both of the shape of time_s."""
        value, rate = KINDS[self.kind](self, time_s, duration_s)
        value = value + self.offset
        fade, fade_rate = fade_in(time_s, self.ramp_s)
        return fade * value, fade * rate + fade_rate * value


def fade_in(time_s: Array, ramp_s: float) -> Signal:
    """(1 - cos(pi t/ramp))/2 up to the ramp's end, 1 after it, and its rate [1/s]."""
    if ramp_s == 0.0:
        return np.ones_like(time_s), np.zeros_like(time_s)
    angle = np.pi * np.clip(time_s / ramp_s, 0.0, 1.0)
    return 0.5 * (1.0 - np.cos(angle)), 0.5 * np.sin(angle) * np.pi / ramp_s


def sine(e: Excitation, t: Array, duration_s: float) -> Signal:
    """A sin(w t + phase)."""
    return components(t, e.amplitudes, e.frequencies_rad_s, (e.phase_rad,))


def multisine(e: Excitation, t: Array, duration_s: float) -> Signal:
    """Sum of A_i sin(w_i t + phase_i) with phases that keep the peak low: Schroeder, IEEE Trans. IT-16 (1970)."""
    count = len(e.frequencies_rad_s)
    phases = tuple(-math.pi * i * (i + 1) / count for i in range(count))
    return components(t, e.amplitudes, e.frequencies_rad_s, phases)


def components(t: Array, amplitudes: tuple[float, ...], rad_s: tuple[float, ...], phases: tuple[float, ...]) -> Signal:
    """Sum of sinusoids and its rate."""
    value, rate = np.zeros_like(t), np.zeros_like(t)
    for amplitude, w, phase in zip(amplitudes, rad_s, phases, strict=True):
        value += amplitude * np.sin(w * t + phase)
        rate += amplitude * w * np.cos(w * t + phase)
    return value, rate


def chirp(e: Excitation, t: Array, duration_s: float) -> Signal:
    """A sin(angle), whose frequency grows linearly from the first to the second over the run."""
    start, end = e.frequencies_rad_s
    growth = (end - start) / duration_s
    angle = (start + 0.5 * growth * t) * t + e.phase_rad
    return e.amplitudes[0] * np.sin(angle), e.amplitudes[0] * (start + growth * t) * np.cos(angle)


def square(e: Excitation, t: Array, duration_s: float) -> Signal:
    """+A and -A in turn; the rate is that between the jumps, zero."""
    half_periods = np.floor(t * e.frequencies_rad_s[0] / np.pi + e.phase_rad / np.pi + 1e-9)
    return e.amplitudes[0] * np.where(half_periods % 2 == 0, 1.0, -1.0), np.zeros_like(t)


def step_coast(e: Excitation, t: Array, duration_s: float) -> Signal:
    """A for push_s, nothing for coast_s, and so on: ahead, astern, astern, ahead, which brings any hull back."""
    cycle = (t + 1e-9) / (e.push_s + e.coast_s)
    pushing = (cycle % 1.0) * (e.push_s + e.coast_s) < e.push_s
    sign = np.array([1.0, -1.0, -1.0, 1.0])[np.floor(cycle).astype(int) % 4]
    return e.amplitudes[0] * sign * pushing, np.zeros_like(t)


KINDS: dict[str, Callable[[Excitation, Array, float], Signal]] = {
    "position_sine": sine,
    "speed_sine": sine,
    "multisine": multisine,
    "chirp": chirp,
    "square": square,
    "step_coast": step_coast,
}


def read_excitation(section: Section) -> Excitation:
    """The [excitation] of a scenario; InputError names file and key."""
    kind = section.choice("kind", tuple(KINDS))
    loop, amplitudes, suffix = _amplitudes(section, kind)
    pulsed, phased = kind == "step_coast", kind not in ("multisine", "step_coast")
    excitation = Excitation(
        kind=kind,
        loop=loop,
        amplitudes=amplitudes,
        frequencies_rad_s=_frequencies(section, kind, len(amplitudes)),
        offset=section.number("offset" + suffix, 0.0, -LARGEST, LARGEST),
        ramp_s=section.number("ramp_s", 0.0, 0.0),
        phase_rad=section.number("phase_rad", 0.0, -100.0, 100.0) if phased else 0.0,
        push_s=section.positive("push_s") if pulsed else 0.0,
        coast_s=section.number("coast_s", None, 0.0) if pulsed else 0.0,
    )
    section.close()
    return excitation


def _amplitudes(section: Section, kind: str) -> tuple[str, tuple[float, ...], str]:
    word = "amplitudes" if kind == "multisine" else "amplitude"
    if kind == "position_sine":
        key = f"{word}_m"
    elif kind in ("speed_sine", "step_coast"):
        key = f"{word}_rev_s"
    else:
        key = section.either(f"{word}_m", f"{word}_rev_s")
    values = section.numbers(key) if kind == "multisine" else (section.number(key, None, -LARGEST, LARGEST),)
    suffix = "_m" if key.endswith("_m") else "_rev_s"
    return "position" if suffix == "_m" else "speed", values, suffix


def _frequencies(section: Section, kind: str, count: int) -> tuple[float, ...]:
    if kind == "multisine":
        values = section.numbers("frequencies_rad_s", low=0.0)
        if len(values) != count:
            message = f"expected {count} numbers, one for each amplitude, found {len(values)}"
            raise section.error("frequencies_rad_s", message)
        return values
    if kind == "chirp":
        return section.positive("from_rad_s", None, LARGEST), section.positive("to_rad_s", None, LARGEST)
    return () if kind == "step_coast" else (section.positive("frequency_rad_s", None, LARGEST),)
