"""Laws that are deliberately not in the catalogue: the right answer to them is "none of these".

Three act on the hull, three in the thrust, three in the sensors. A push is an acceleration evaluated at each tick from
the true state, half a tick ahead so that holding it over the tick costs second order only; a distortion changes the
recorded columns and nothing else. All are guesses in form and size, chosen to be plausible in a tank and different
from every law of `vtank.effects`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Memory = dict[str, float]


class Sight(NamedTuple):
    """What a push sees: tick length h [s], place x [m], speed u [m/s], its rate a [m/s2], propeller speed n [rev/s],
    drag alpha [1/m] and thrust gain beta [m/rev2] of the hull."""

    h: float
    x: float
    u: float
    a: float
    n: float
    alpha: float
    beta: float


Push = Callable[[float, Sight, Memory], float]
Distortion = Callable[[float, np.random.Generator, Array, Array], tuple[Array, Array]]


@dataclass(frozen=True)
class OutsideLaw:
    """A law of no catalogue; `largest` is the largest plausible size [-], 1 being a moderate one."""

    name: str
    largest: float
    push: Push | None = None
    distort: Distortion | None = None


def _low_pass(memory: Memory, key: str, value: float, h: float, time_s: float) -> float:
    state = memory.get(key, value if key == "level" else 0.0)
    memory[key] = value + (state - value) * math.exp(-h / time_s)
    return state


def cubic_drag(size: float, s: Sight, memory: Memory) -> float:
    """Drag with the cube of speed: wave making of a hull near the surface [m/s2]."""
    return -size * 5.0 * s.u**3  # 5 s/m2: half the quadratic drag at 0.25 m/s


def drag_crisis(size: float, s: Sight, memory: Memory) -> float:
    """Drag drops above a critical speed, where the boundary layer turns turbulent [m/s2]."""
    share = 1.0 / (1.0 + math.exp(-(abs(s.u) - 0.15) / 0.02))  # 0.15 m/s and 0.02 m/s wide
    return -size * 0.3 * share * s.alpha * s.u * abs(s.u)


def speed_inertia(size: float, s: Sight, memory: Memory) -> float:
    """Added mass that grows with speed, on the acceleration of the tick before [m/s2]."""
    return -min(size * (s.u / 0.3) ** 2, 0.7) * s.a  # twice the inertia at 0.3 m/s; below 0.7, where it is stable


def thrust_hysteresis(size: float, s: Sight, memory: Memory) -> float:
    """The propeller pushes more while it speeds up than while it slows down [m/s2]."""
    behind = _low_pass(memory, "level", abs(s.n), s.h, 1.0)
    return size * 0.2 * s.beta * s.n * abs(s.n) * math.tanh((abs(s.n) - behind) / 2.0)


def propeller_beat(size: float, s: Sight, memory: Memory) -> float:
    """Two propellers whose speeds differ by a sixtieth drift in and out of step, and the thrust beats [m/s2]."""
    turned = memory.get("turned", 0.0)
    memory["turned"] = turned + s.n * s.h
    return size * 0.1 * s.beta * s.n * abs(s.n) * math.sin(2.0 * math.pi * turned / 60.0)


def returning_wash(size: float, s: Sight, memory: Memory) -> float:
    """The slipstream goes round the tank and comes back against the hull some 10 s later [m/s2]."""
    near = _low_pass(memory, "near", s.beta * s.n * abs(s.n), s.h, 5.0)
    return -size * 0.3 * _low_pass(memory, "far", near, s.h, 5.0)


def sonar_bend(size: float, random: np.random.Generator, n: Array, range_m: Array) -> tuple[Array, Array]:
    """Ranges bent by temperature layers: an error with the cube of the distance from the first reading [m]."""
    away = range_m - range_m[np.isfinite(range_m)][0]
    return n, range_m + size * 0.3 * away**3  # 1 cm at 0.3 m


def sonar_stick(size: float, random: np.random.Generator, n: Array, range_m: Array) -> tuple[Array, Array]:
    """The serial line repeats its last range for up to a second now and then."""
    stuck, left, last = range_m.copy(), 0, math.nan
    starts, lengths = random.random(n.size) < 0.02 * size, random.integers(2, 10, n.size)
    for k in range(n.size):
        left = int(lengths[k]) if left == 0 and starts[k] and last == last else max(left - 1, 0)
        if left and range_m[k] == range_m[k]:
            stuck[k] = last
        last = stuck[k] if stuck[k] == stuck[k] else last
    return n, stuck


def tachometer_threshold(size: float, random: np.random.Generator, n: Array, range_m: Array) -> tuple[Array, Array]:
    """The tachometer says zero below a speed at which its brushes lose contact [rev/s]."""
    return np.where(np.abs(n) < 2.0 * size, 0.0, n), range_m


OUTSIDE: dict[str, OutsideLaw] = {
    law.name: law
    for law in (
        OutsideLaw("cubic_drag", 4.0, push=cubic_drag),
        OutsideLaw("drag_crisis", 2.5, push=drag_crisis),
        OutsideLaw("speed_inertia", 2.0, push=speed_inertia),
        OutsideLaw("thrust_hysteresis", 4.0, push=thrust_hysteresis),
        OutsideLaw("propeller_beat", 4.0, push=propeller_beat),
        OutsideLaw("returning_wash", 2.0, push=returning_wash),
        OutsideLaw("sonar_bend", 6.0, distort=sonar_bend),
        OutsideLaw("sonar_stick", 3.0, distort=sonar_stick),
        OutsideLaw("tachometer_threshold", 2.5, distort=tachometer_threshold),
    )
}
