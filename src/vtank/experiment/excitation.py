"""Excitations: the sinusoids, steps and sweeps commanded to the vehicle, along one of its axes.

A position excitation [m or rad] is a distance from the start, followed in closed loop; that of surge is commanded as a
range to the wall. In open loop surge takes a propeller speed [rev/s], which is sent to the propellers as it is, and
another axis a force [N] or a moment [N m], which is sent to the thrusters. The unit of the amplitude's key tells which.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..record.table import LARGEST, Table

Array = NDArray[np.float64]
Signal = tuple[Array, Array]  # value and its rate

# Axis -> units of a position and of an open-loop input, as suffixes of keys
SUFFIXES = {
    "surge": ("_m", "_rev_s"),
    "sway": ("_m", "_N"),
    "heave": ("_m", "_N"),
    "pitch": ("_rad", "_N_m"),
    "yaw": ("_rad", "_N_m"),
}


@dataclass(frozen=True)
class Excitation:
    """What is commanded over time.

    Attributes:
        kind: one of KINDS.
        loop: "position" (closed loop), or in open loop "speed" (of the propellers) or "force" (of the thrusters).
        amplitudes: of each component [m or rad, rev/s, N or N m].
        frequencies_rad_s: of each component; of a chirp, where it starts and ends [rad/s].
        offset: mean of the command, in the amplitudes' unit.
        ramp_s: time over which the whole command is faded in, (1 - cos)/2 [s].
        phase_rad: of a single sinusoid at t = 0 [rad].
        push_s, coast_s: of step and coast-down, repeated ahead, astern, astern, ahead [s].
        axis: one of SUFFIXES; the others are held where they are.
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
    axis: str = "surge"

    def command(self, time_s: Array, duration_s: float) -> Signal:
        """Command, in the amplitudes' unit, and its rate [per s] at these times, both of the shape of time_s."""
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
    """A sin(w t + phase); nothing, to stay where the vehicle is, without an amplitude."""
    return components(t, e.amplitudes, e.frequencies_rad_s, (e.phase_rad,) * len(e.amplitudes))


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
    "force_sine": sine,
    "multisine": multisine,
    "chirp": chirp,
    "square": square,
    "step_coast": step_coast,
    "station": sine,
}
CLOSED, OPEN = ("position_sine", "station"), ("speed_sine", "force_sine", "step_coast")  # the others: either loop


SIGNALS = ("multisine", "chirp", "square", "step_coast")  # in open loop, along any axis or of any input


def read_excitation(table: Table) -> Excitation:
    """The [excitation] of a scenario; InputError names file and key."""
    kind = table.choice("kind", tuple(KINDS))
    axis = table.choice("axis", tuple(SUFFIXES), "surge")
    if kind == ("force_sine" if axis == "surge" else "speed_sine"):
        raise table.error("kind", f"found {kind} along {axis}: surge has a propeller speed, every other axis a force")
    excitation = _signal(table, kind, *_amplitudes(table, kind, axis), axis)
    table.close()
    return excitation


def read_signal(table: Table, unit: str) -> Excitation:
    """An open-loop excitation whose amplitudes have the suffix `unit`, of a table that may hold other keys too."""
    kind = table.choice("kind", SIGNALS)
    key = ("amplitudes" if kind == "multisine" else "amplitude") + unit
    values = table.numbers(key) if kind == "multisine" else (table.number(key, None, -LARGEST, LARGEST),)
    return _signal(table, kind, "force", values, unit, "")


def _signal(table: Table, kind: str, loop: str, amplitudes: tuple[float, ...], suffix: str, axis: str) -> Excitation:
    pulsed, phased = kind == "step_coast", kind not in ("multisine", "step_coast", "station")
    return Excitation(
        kind=kind,
        loop=loop,
        amplitudes=amplitudes,
        frequencies_rad_s=_frequencies(table, kind, len(amplitudes)),
        offset=table.number("offset" + suffix, 0.0, -LARGEST, LARGEST),
        ramp_s=table.number("ramp_s", 0.0, 0.0),
        phase_rad=table.number("phase_rad", 0.0, -100.0, 100.0) if phased else 0.0,
        push_s=table.positive("push_s") if pulsed else 0.0,
        coast_s=table.number("coast_s", None, 0.0) if pulsed else 0.0,
        axis=axis,
    )


def _amplitudes(table: Table, kind: str, axis: str) -> tuple[str, tuple[float, ...], str]:
    """Loop, amplitudes and the unit's suffix."""
    place, drive = SUFFIXES[axis]
    if kind == "station":
        return "position", (), place
    word = "amplitudes" if kind == "multisine" else "amplitude"
    if kind in CLOSED:
        key = word + place
    else:
        key = word + drive if kind in OPEN else table.either(word + place, word + drive)
    values = table.numbers(key) if kind == "multisine" else (table.number(key, None, -LARGEST, LARGEST),)
    if key == word + place:
        return "position", values, place
    return "speed" if axis == "surge" else "force", values, drive


def check_frequencies(table: Table, signal: Excitation, period_s: float) -> None:
    """InputError where a frequency is more than a command every period_s [s] can follow."""
    most = math.pi / period_s
    if (worst := max(signal.frequencies_rad_s, default=0.0)) >= most:
        chirp = "from_rad_s" if worst == signal.frequencies_rad_s[0] else "to_rad_s"
        key = {"multisine": "frequencies_rad_s", "chirp": chirp}.get(signal.kind, "frequency_rad_s")
        why = f"a command every {period_s:g} s (period_s) cannot follow more"
        raise table.error(key, f"expected less than {most:.4g} rad/s, found {worst:g}: {why}")


def _frequencies(table: Table, kind: str, count: int) -> tuple[float, ...]:
    if kind == "multisine":
        values = table.numbers("frequencies_rad_s", low=0.0)
        if len(values) != count:
            message = f"expected {count} numbers, one for each amplitude, found {len(values)}"
            raise table.error("frequencies_rad_s", message)
        return values
    if kind == "chirp":
        return table.positive("from_rad_s", None, LARGEST), table.positive("to_rad_s", None, LARGEST)
    return () if kind in ("step_coast", "station") else (table.positive("frequency_rad_s", None, LARGEST),)
