"""What varies over a campaign: axes of a grid, and random draws.

Keys are those of scenario files (`sonar.noise_m`, `effects.linear_drag.c_per_s`). In [grid] a key has one value, a list
or a range; in [draw] a law:

    sonar.noise_m = [0.003, 0.006]
    excitation.amplitude_m = { from = 0.1, to = 0.4, count = 4 }                  # spacing = "log": equal ratios
    effects.linear_drag.c_per_s = { log_uniform = [0.001, 0.1] }                  # uniform, log_uniform, normal, choice
"""

from __future__ import annotations

import math
import sys
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import InputError
from ...record import Table, line_of, shown

DRAWN = 2**16  # with a run's number the random stream of what is drawn; noise (pilot/noise.py) has streams of its own
MOST_RUNS = 10_000_000  # of a campaign, and so of values in a range: hours at a thousand runs a second; a choice
RANGE = ("from", "to", "count", "spacing")


@dataclass(frozen=True)
class Axis:
    """A key of the grid and the values it takes in turn."""

    key: str
    values: tuple[Any, ...]


@dataclass(frozen=True)
class Draw:
    """A key that is drawn anew for every run: `law` is one of LAWS, `numbers` its two numbers, or its choices."""

    key: str
    law: str
    numbers: tuple[Any, ...]

    def value(self, seed: int, run: int) -> Any:
        """The value of a run. It depends on seed, run and key alone, not on what else is drawn."""
        sequence = np.random.SeedSequence(seed, spawn_key=(run, DRAWN, zlib.crc32(self.key.encode())))
        return LAWS[self.law](np.random.Generator(np.random.Philox(sequence)), self.numbers)

    @property
    def ends(self) -> tuple[Any, ...]:
        """Values to try before any run: the ends of a range, the mean, every choice."""
        return self.numbers[:1] if self.law == "normal" else self.numbers


def log_uniform(random: np.random.Generator, ends: tuple[Any, ...]) -> float:
    """Uniform in the logarithm, between two ends of one sign."""
    low, high = ends
    value = low * math.exp(random.random() * math.log(high / low))
    return min(max(value, low), high)


LAWS: dict[str, Callable[[np.random.Generator, tuple[Any, ...]], Any]] = {
    "uniform": lambda random, ends: random.uniform(*ends),
    "log_uniform": log_uniform,
    "normal": lambda random, moments: moments[0] + moments[1] * random.standard_normal(),
    "choice": lambda random, choices: choices[random.integers(len(choices))],
}


def read_grid(section: Table) -> tuple[Axis, ...]:
    """The axes of [grid] in the file's order; InputError names file and key."""
    return tuple(Axis(key, _values(section, key, entry)) for key, entry in _leaves(section, section.entries, RANGE))


def read_draws(section: Table) -> tuple[Draw, ...]:
    """The draws of [draw]; InputError names file and key."""
    return tuple(_draw(section, key, entry) for key, entry in _leaves(section, section.entries, tuple(LAWS)))


def _leaves(section: Table, entries: dict[str, Any], words: tuple[str, ...], above: str = "") -> Iterator[Any]:
    """(dotted key, entry) of all tables within, down to lists, plain values and tables of these words."""
    for name, entry in entries.items():
        section.known.add(name)
        if isinstance(entry, dict) and entry and not set(entry) & set(words):
            yield from _leaves(section, entry, words, f"{above}{name}.")
        else:
            yield above + name, entry


def _values(section: Table, key: str, entry: Any) -> tuple[Any, ...]:
    if isinstance(entry, list):
        if not entry:
            raise refusal(section, key, "expected at least one value in the list")
        return tuple(entry)
    return _spaced(section, key, entry) if isinstance(entry, dict) else (entry,)


def _spaced(section: Table, key: str, entry: dict[str, Any]) -> tuple[Any, ...]:
    """The numbers of a range; whole numbers where ends and distance are whole."""
    start, end, count = (entry.get(word, math.nan) for word in RANGE[:3])
    spacing = entry.get("spacing", "linear")
    if isinstance(count, int) and count > MOST_RUNS:
        raise refusal(section, key, f"expected {MOST_RUNS:,} values at most, found count = {count:.3g}")
    if not (_are_numbers(start, end) and isinstance(count, int) and count >= 2) or set(entry) - set(RANGE):
        example = "{ from = 0.1, to = 0.4, count = 4 }, with at least two values"
        raise refusal(
            section, key, f"expected a value, a list of values or a range such as {example}; found {shown(entry)}"
        )
    if spacing == "log" and start * end > 0.0:
        return tuple(float(value) for value in np.geomspace(start, end, count))
    if spacing != "linear":
        raise refusal(section, key, 'expected spacing = "linear", or "log" between two ends of one sign')
    if isinstance(start, int) and isinstance(end, int) and (end - start) % (count - 1) == 0:
        return tuple(int(value) for value in np.linspace(start, end, count))
    return tuple(float(value) for value in np.linspace(start, end, count))


def _draw(section: Table, key: str, entry: Any) -> Draw:
    laws = ", ".join(LAWS)
    if not isinstance(entry, dict) or len(entry) != 1:
        raise refusal(section, key, f"expected one of {laws}, such as {{ uniform = [0.1, 0.4] }}; found {shown(entry)}")
    law, numbers = next(iter(entry.items()))
    if law not in LAWS:
        raise refusal(section, key, f"expected one of {laws}; found {shown(law)}")
    rising = _pair(numbers) and numbers[0] < numbers[1]
    fits, expected = {
        "choice": (isinstance(numbers, list) and numbers, "a list of values"),
        "normal": (_pair(numbers) and numbers[1] >= 0, "[mean, standard deviation]"),
        "uniform": (rising, "[low, high]"),
        "log_uniform": (rising and numbers[0] * numbers[1] > 0.0, "[low, high], one sign"),
    }[law]
    if not fits:
        raise refusal(section, key, f"{law}: expected {expected}; found {shown(numbers)}")
    return Draw(key, law, tuple(numbers))


def refusal(section: Table, key: str, message: str) -> InputError:
    """An InputError that names file, line and key; the key may stand in a table within the section."""
    full = f"{section.name}.{key}"
    table, _, last = full.rpartition(".")
    line = line_of(section.path, section.name, key) or line_of(section.path, table, last)
    return InputError(f"{section.path}{f':{line}' if line else ''}: {full}: {message}")


def _pair(numbers: Any) -> bool:
    return isinstance(numbers, list) and len(numbers) == 2 and _are_numbers(*numbers)


def _are_numbers(*values: Any) -> bool:
    return all(isinstance(v, int | float) and not isinstance(v, bool) and abs(v) <= sys.float_info.max for v in values)
