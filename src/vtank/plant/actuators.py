"""Thrusters and fins as a vehicle file has them: where they act, and what force follows from what is asked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..record.files import is_file, read_text
from ..record.table import Table
from ..record.toml import meant, no_file
from ..resources import models_dir

Array = NDArray[np.float64]
Vector = tuple[float, float, float]
Curve = tuple[tuple[float, float], ...]
INPUTS = ("rev_s", "command", "N")  # propeller speed [rev/s], normalised command -1..1, force [N]
GAIN = {"rev_s": "gain_N_s2_per_rev2", "command": "gain_N"}  # of n|n|, and of the command
DEAD_BAND = {"rev_s": "dead_band_rev_s", "command": "dead_band", "N": "dead_band_N"}
THRUSTER = ("name", "site", "direction", "input", *GAIN.values(), "curve", "lag_s", "limit_N", *DEAD_BAND.values())
FIN = ("name", "site", "axis", "area_m2", "lift_per_rad", "stall_rad", "drag", "suction", "limit_rad",
       "density_kg_per_m3")  # fmt: skip
FINE = 2001  # points at which a thruster's law is inverted; a choice
MOST_N = 1e8  # [N] of a thruster that is believed: as of a column; a choice
FRESH_KG_PER_M3 = 1000.0  # fresh water; a choice


@dataclass(frozen=True)
class Thruster:
    """A thruster at a site of the MJCF.

    Attributes:
        site: of the MJCF, where its force acts.
        direction: of positive force, a unit vector in body axes.
        limit_N: largest force either way [N].
        name: of its columns in a recording; the site's, where none is given.
        input: one of INPUTS: what it is asked for.
        gain: force per command [N], or per n|n| [N/(rev/s)2]; not used with a curve, or where the input is a force.
        curve: bench table as pairs (input, force [N]), inputs increasing; flat beyond its ends. Empty: none.
        lag_s: time constant with which the force follows [s].
        dead_band: input below which nothing happens, and by which it is less above, in the input's unit.
    """

    site: str
    direction: Vector
    limit_N: float
    name: str = ""
    input: str = "N"
    gain: float = 1.0
    curve: Curve = ()
    lag_s: float = 0.0
    dead_band: float = 0.0

    def __post_init__(self) -> None:
        """Named as its site, where it has no name of its own."""
        object.__setattr__(self, "name", self.name or self.site)

    @property
    def column(self) -> str:
        """Name of its input in a recording."""
        return f"{self.name}_{self.input}"

    def force_N(self, asked: Array) -> Array:
        """Steady force of inputs, in the unit of `input`, before the lag: same shape [N]."""
        asked = asked - np.clip(asked, -self.dead_band, self.dead_band)
        if self.curve:
            force = np.interp(asked, *np.transpose(self.curve))
        else:
            force = self.gain * asked * (np.abs(asked) if self.input == "rev_s" else 1.0)
        return np.clip(force, -self.limit_N, self.limit_N)

    def input_for(self, force_N: Array) -> Array:
        """The least input that makes a steady force: inverse of `force_N`, up to the largest force. Same shape."""
        found = np.zeros_like(force_N)
        for side, (made, asked) in self._inverse.items():
            found = np.where(side * force_N > 0.0, np.interp(side * force_N, made, asked), found)
        return found

    def most_N(self, side: float) -> float:
        """The largest force ahead (side 1) or astern (-1) [N]."""
        return float(self._inverse[side][0][-1])

    @cached_property
    def _inverse(self) -> dict[float, tuple[Array, Array]]:
        """Side, 1 ahead and -1 astern -> increasing sizes of force, and the least input for each."""
        most = {"rev_s": np.sqrt(self.limit_N / self.gain), "N": self.limit_N}.get(self.input, 0.0) + self.dead_band
        if self.input == "command":
            most = 1.0
        elif self.curve:
            most = max(abs(asked) for asked, _ in self.curve)
        sides = {}
        for side in (1.0, -1.0):
            asked = side * np.linspace(0.0, most, FINE)
            made, first = np.unique(np.maximum.accumulate(side * self.force_N(asked)), return_index=True)
            sides[side] = made, asked[first]
        return sides


@dataclass(frozen=True)
class Fin:
    """A control surface at a site of the MJCF, or one that is fixed (limit_rad 0), such as the lift of a hull.

    Attributes:
        name, site: as of a Thruster.
        axis: about which a positive angle turns it, a unit vector in body axes: y for a plane, z for a rudder.
        area_m2: planform [m2].
        lift_per_rad: slope of the lift coefficient [1/rad].
        stall_rad: angle of attack from which lift falls off [rad].
        drag: drag coefficient at no angle of attack.
        suction: share of the drag of its lift that suction at the leading edge takes off, 0 of a plate to 1.
        limit_rad: largest angle either way [rad].
        density_kg_per_m3: of the water [kg/m3].
    """

    name: str
    site: str
    axis: Vector
    area_m2: float
    lift_per_rad: float
    stall_rad: float
    drag: float = 0.0
    limit_rad: float = np.inf
    density_kg_per_m3: float = FRESH_KG_PER_M3
    suction: float = 0.0

    @property
    def column(self) -> str:
        """Name of its angle in a recording."""
        return f"{self.name}_rad"


def read_thruster(table: Table) -> Thruster:
    """One [[thruster]] of a vehicle file; InputError names file and key."""
    table.check_keys(THRUSTER)
    site, kind = table.text("site"), table.choice("input", INPUTS, "N")
    _check_input(table, kind)
    gain, curve, most = _steady(table, kind)
    return Thruster(
        site=site,
        direction=unit(table, "direction"),
        limit_N=table.positive("limit_N", most),
        name=table.name_of("name", ""),
        input=kind,
        gain=gain,
        curve=curve,
        lag_s=table.number("lag_s", 0.0, 0.0),
        dead_band=table.number(DEAD_BAND[kind], 0.0, 0.0),
    )


def _check_input(table: Table, kind: str) -> None:
    """Refuse keys of another input, and a thruster without gain or curve."""
    if not {"input", "limit_N"} & set(table.entries):
        message = "missing: 'command' or 'rev_s' with a gain or a curve, or 'N' with limit_N; a thruster makes no force"
        raise table.error("input", f"{message} without")
    for key in (*GAIN.values(), *DEAD_BAND.values(), "curve"):
        of_force = {GAIN[kind], "curve"} if kind in GAIN else {"limit_N"}
        fitting = {DEAD_BAND[kind]} if key in DEAD_BAND.values() else of_force
        if key in table.entries and key not in fitting:
            found = f"input = '{kind}'" if "input" in table.entries else "no input, which is then 'N'"
            raise table.error(key, f"does not go with {found}; expected {' or '.join(sorted(fitting))}")
    if kind in GAIN and not {GAIN[kind], "curve"} & set(table.entries):
        wanted = f"{GAIN[kind]}, or a curve (CSV with the columns {kind}, force_N)"
        raise table.error("input", f"'{kind}' makes no force without {wanted}; found neither")


def _steady(table: Table, kind: str) -> tuple[float, Curve, float | None]:
    """Gain, curve, and the largest force that these allow by themselves [N], if any."""
    if kind == "N":
        return 1.0, (), None
    if table.either(GAIN[kind], "curve") == "curve":
        curve = read_curve(_curve_file(table), kind)
        return 1.0, curve, max(abs(force) for _, force in curve)
    gain = table.positive(GAIN[kind])
    return gain, (), gain if kind == "command" else None


def _curve_file(table: Table) -> Path:
    """The bench table of that name in models/, or the *.csv beside the file that names it, with or without that."""
    value = table.file("curve", ending=".csv")
    presets = {path.stem: path for path in (*table.path.parent.glob("*.csv"), *models_dir().glob("*.csv"))}
    if not value.endswith(".csv") and value not in presets:
        raise table.error(
            "curve", f"no bench table '{value}'{meant(value, sorted(presets))}; or the path of a .csv file"
        )
    path = presets.get(value, Path(value))
    if not is_file(path):
        raise table.error("curve", no_file(path))
    return path


def read_fin(table: Table) -> Fin:
    """One [[fin]] of a vehicle file; InputError names file and key."""
    table.check_keys(FIN)
    axis = unit(table, "axis")
    if abs(axis[0]) > 1e-6:
        raise table.error("axis", "expected a direction across the hull, with x = 0")
    return Fin(
        name=table.name_of("name"),
        site=table.text("site"),
        axis=axis,
        area_m2=table.positive("area_m2"),
        lift_per_rad=table.positive("lift_per_rad"),
        stall_rad=table.positive("stall_rad", None, 0.5 * np.pi - 1e-6),
        drag=table.number("drag", 0.0, 0.0),
        suction=table.number("suction", 0.0, 0.0, 1.0),
        limit_rad=table.number("limit_rad", np.pi, 0.0, np.pi),
        density_kg_per_m3=table.positive("density_kg_per_m3", FRESH_KG_PER_M3),
    )


def read_curve(path: Path, kind: str) -> Curve:
    """The bench table in a CSV file with columns `kind` and force_N; InputError names file and line."""
    lines = read_text(path).splitlines()
    expected = f"{kind},force_N"
    if not lines or lines[0].replace(" ", "") != expected:
        raise InputError(f"{path}, line 1: expected the header '{expected}', found '{lines[0] if lines else ''}'")
    points: list[tuple[float, float]] = []
    for number, line in enumerate(lines[1:], 2):
        try:
            asked, force = map(float, line.split(","))
        except ValueError:
            raise InputError(f"{path}, line {number}: expected two numbers, found '{line[:60]}'") from None
        if not np.isfinite([asked, force]).all() or points and asked <= points[-1][0]:
            raise InputError(f"{path}, line {number}: expected finite numbers, {kind} increasing; found '{line[:60]}'")
        if kind == "command" and abs(asked) > 1.0 or abs(force) > MOST_N:
            expected = f"{kind} from -1 to 1 and" if kind == "command" else ""
            cause = "; is it in percent?" if kind == "command" and abs(asked) > 1.0 else ""
            raise InputError(
                f"{path}, line {number}: expected {expected} a force within {MOST_N:g} N, found '{line[:60]}'{cause}"
            )
        points.append((asked, force))
    if len(points) < 2:
        raise InputError(f"{path}: expected two points or more, found {len(points)}")
    return tuple(points)


def unit(table: Table, key: str) -> Vector:
    """A direction in body axes, of length 1."""
    direction = np.array(table.vector(key))
    if not np.linalg.norm(direction) > 0.0:
        raise table.error(key, "expected a direction in body axes that is not zero")
    x, y, z = direction / np.linalg.norm(direction)
    return float(x), float(y), float(z)
