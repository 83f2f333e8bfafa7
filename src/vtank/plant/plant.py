"""What a plant is: named states and inputs, and the laws that move them; its kernels are made from these.

The states of a plant are moved by `rates`, but for those that lag an input through a first-order law: these settle
exactly towards their `targets`, so that a short time constant costs no small steps. Unmodelled accelerations
(turbulence, a known push) act on the axes; each axis carries a disturbance d [m/s2 or rad/s2] behind the states.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..compiled import bind, term
from ..errors import InputError
from ..lanes import where
from ..record.toml import meant


class Axis(NamedTuple):
    """A degree of freedom that unmodelled accelerations push: indices of its speed and of its place, where it has one.

    A place is a state that is this speed's integral, in axes that do not turn; -1 where there is none.
    """

    speed: int
    place: int = -1


@dataclass(frozen=True, eq=False)
class Parameters:
    """What a plant reads from parameters: the names of the vector's slots and their null values, shape (P,)."""

    names: tuple[str, ...]
    null: np.ndarray

    def slot(self, name: str) -> int:
        """Index of a parameter in the vector; InputError lists the names that exist."""
        if name not in self.names:
            raise InputError(f"no parameter '{name}'{meant(name, self.names)}")
        return self.names.index(name)

    @cached_property
    def _places(self) -> dict[tuple[str, ...], np.ndarray]:
        return {}

    def slots(self, names: tuple[str, ...]) -> np.ndarray:
        """Indices of several parameters, shape (K,)."""
        if names not in self._places:
            self._places[names] = np.array([self.slot(name) for name in names], dtype=int)
        return self._places[names]

    def vector(self, values: Mapping[str, float], base: np.ndarray | None = None) -> np.ndarray:
        """A copy of `base` (default: the null values), shape (P,), with the named slots set."""
        p = self.null.copy() if base is None else base.copy()
        for name, value in values.items():
            p[self.slot(name)] = value
        return p


@dataclass(frozen=True, eq=False)
class Plant:
    """A vehicle's equations of motion.

    Laws get time t [s], the states s and inputs n as tuples, the accelerations `push` by axis, and the parameters p.

    Attributes:
        name: of the plant.
        states: names of all states.
        lagging: those that lag an input, in the order of `targets`, and the parameter that is their time constant.
        axes: where unmodelled accelerations act.
        parameters: what it reads from parameters.
        rates: (t, s, n, push, p) -> d/dt of every state; unused for lagging ones, which s holds as they act.
        targets: (t, n, p) -> what the lagging states settle to.
        lags: (p) -> their time constants [s]; 0 is no lag.
        inputs: (reading, lone, j, p) -> the inputs n behind sample j of the recorded ones, `lone` off where alone.
        acts: (t, p) -> stamp of the input that acts at time t [s].
        shifting: names of the parameters that shift instants, of the input or of a measurement.
    """

    name: str
    states: tuple[str, ...]
    lagging: Mapping[str, str]
    axes: tuple[Axis, ...]
    parameters: Parameters
    rates: Callable[..., Any]
    targets: Callable[..., Any]
    lags: Callable[..., Any]
    inputs: Callable[..., Any]
    acts: Callable[..., Any]
    shifting: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Its name and states."""
        return f"Plant({self.name}: {', '.join(self.states)})"

    @property
    def size(self) -> int:
        """Number of states, disturbances included."""
        return len(self.states) + len(self.axes)

    @cached_property
    def laws(self) -> dict[str, Any]:
        """The names that templates of kernels use, as they mean for this plant."""
        own = {name: getattr(self, name) for name in ("rates", "targets", "lags", "inputs", "acts")}
        held = [self.states.index(name) for name in self.lagging]
        own |= _tuples(len(self.states), held, len(self.axes))
        for template in (fades, advance, step):
            own[template.__name__] = bind(template, f"{self.name}_{template.__name__}", own, term)
        return own

    @cached_property
    def move(self) -> Callable[..., Any]:
        """(t, h, s, n, push, p) -> states after one step of h [s] from time t [s], inputs and accelerations held."""
        return bind(move, f"{self.name}_move", self.laws)


# --- templates; `bind` puts a plant's own laws, and its arithmetic from `_tuples`, in the place of these names
unbound: Any = None
rates = targets = lags = along = fourth = lagging = put = acting = settled = faded = motion = disturbance = pushing = (
    dying
) = joined = unbound


def fades(h, p):
    """What half a step of h [s] leaves of the distance between lagging states and their targets."""
    return faded(0.5 * h, lags(p))


def advance(t, h, s, n, push, fade, p):
    """States after one step of h [s] from time t [s]; inputs n and accelerations `push` are held; fade: see `fades`.

    Classical fourth-order Runge-Kutta; the lagging states are solved exactly.
    """
    g = 0.5 * h
    goal = targets(t + g, n, p)
    z1 = acting(lagging(s), goal, lags(p))
    z2 = settled(z1, goal, fade)
    z3 = settled(z2, goal, fade)
    s1 = put(s, z1)
    k1 = rates(t, s1, n, push, p)
    k2 = rates(t + g, put(along(s1, g, k1), z2), n, push, p)
    k3 = rates(t + g, put(along(s1, g, k2), z2), n, push, p)
    k4 = rates(t + h, put(along(s1, h, k3), z3), n, push, p)
    return put(fourth(s1, h / 6.0, k1, k2, k3, k4), z3)


def move(t, h, s, n, push, p):
    """One step by itself."""
    return advance(t, h, s, n, push, fades(h, p), p)


def step(t, h, s, n, push, keep, mean, fade, p):
    """States and disturbances after one step; of a disturbance is left the share `keep`, and `mean` within the step.

    push: known acceleration on the first axis [m/s2].
    """
    d = disturbance(s)
    return joined(advance(t, h, motion(s), n, pushing(d, mean, push), fade, p), dying(d, keep))


def _tuples(states: int, held: Sequence[int], axes: int) -> dict[str, Any]:
    """Arithmetic on tuples of states, written out, since numba unrolls no loop over a tuple.

    held: indices of the lagging states. `lagging(s)` takes these out of the states and `put(s, z)` puts others in;
    `motion(s)` and `disturbance(s)` are the parts of what an estimator carries, and `joined` their inverse.
    """

    def each(text: str, count: int, first: int = 0) -> str:
        return "".join(text.replace("#", str(i)) + ", " for i in range(first, first + count))

    stands = {i: f"z[{k}]" for k, i in enumerate(held)}
    texts = {
        "along(s, h, k)": each("s[#] + h * k[#]", states),
        "fourth(s, h, a, b, c, d)": each("s[#] + h * (a[#] + 2.0 * (b[#] + c[#]) + d[#])", states),
        "lagging(s)": "".join(f"s[{i}], " for i in held),
        "put(s, z)": "".join(stands.get(i, f"s[{i}]") + ", " for i in range(states)),
        "acting(z, goal, tau)": each("where(tau[#] > 0.0, z[#], goal[#])", len(held)),
        "settled(z, goal, fade)": each("goal[#] + (z[#] - goal[#]) * fade[#]", len(held)),
        "faded(h, tau)": each("exp(-h / tau[#])", len(held)),
        "motion(s)": each("s[#]", states),
        "disturbance(s)": each("s[#]", axes, states),
        "pushing(d, mean, push)": "d[0] * mean + push, " + each("d[#] * mean", axes - 1, 1),
        "dying(d, keep)": each("d[#] * keep", axes),
        "joined(s, d)": each("s[#]", states) + each("d[#]", axes),
    }
    found: dict[str, Any] = {"where": where, "exp": math.exp}
    for head, body in texts.items():
        exec(f"def {head}:\n    return ({body})\n", found)
        name = head.partition("(")[0]
        found[name] = term(found[name])
    return found
