"""A row of the table of sensors: what a channel reads of the state and its derivative, and when."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from ..compiled import bind, term
from ..plant.hooks import unchanged
from ..plant.plant import Plant


@dataclass(frozen=True)
class Channel:
    """One channel of recordings.

    Attributes:
        name: of its column, unit included.
        unit: SI unit.
        reading: (t, s, ds, p) -> noise-free value in states s with derivatives ds, at time t [s].
        instant: (stamp, p) -> when a measurement of that stamp was true [s].
        of_rates: whether the reading looks at ds, which costs one more evaluation of the plant's rates; a reading that
            does, where this says that it does not, fails to compile.
        coloured: whether its error may have a coloured part beside the white one.
        state: index of the state that its first value tells, if it tells one.
        begins: (value, p) -> that state.
        words: what it is called in a sentence, by default its column.
    """

    name: str
    unit: str
    reading: Callable[..., Any]
    instant: Callable[..., Any] = unchanged
    of_rates: bool = False
    coloured: bool = False
    state: int | None = None
    begins: Callable[..., float] = lambda value, p: value
    words: str = ""


def reads_state(i: int) -> Any:
    """The reading that is a state itself."""
    return term(lambda t, s, ds, p: s[i])


def readers(plant: Plant, channels: Sequence[Channel]) -> dict[str, Any]:
    """The laws `read` and `instant` of all channels: which row answers is told by its place in the table."""
    read, instant = _nothing_read, at_no_time
    for index, row in reversed(list(enumerate(channels))):
        own = {"index": index, "reading": row.reading, "when": row.instant, "other": read, "otherwise": instant}
        template = _read_rates if row.of_rates else _read
        read = bind(template, f"{plant.name}_read_{row.name}", {**plant.laws, **own}, term)
        instant = bind(_instant, f"{plant.name}_instant_{row.name}", own, term)
    return {"read": read, "instant": instant}


# --- templates; `bind` puts a plant's and a row's own laws in the place of these names
unbound: Any = None
index = reading = when = other = otherwise = motion = disturbance = pushing = lagging = put = acting = rates = (
    targets
) = lags = unbound


@term
def _nothing_read(kind, t, s, n, push, p):
    return 0.0 * s[0]


@term
def at_no_time(kind, stamp, p):
    """Behind the last row."""
    return stamp


def _read(kind, t, s, n, push, p):
    """Reading of channel `kind` in states s under inputs n and a known acceleration."""
    return reading(t, s, None, p) if kind == index else other(kind, t, s, n, push, p)


def _read_rates(kind, t, s, n, push, p):
    """The same for a channel that looks at the derivatives."""
    if kind != index:
        return other(kind, t, s, n, push, p)
    own = motion(s)
    own = put(own, acting(lagging(own), targets(t, n, p), lags(p)))
    return reading(t, own, rates(t, own, n, pushing(disturbance(s), 1.0, push), p), p)


def _instant(kind, stamp, p):
    """Instant at which a measurement of channel `kind` was true [s]."""
    return when(stamp, p) if kind == index else otherwise(kind, stamp, p)
