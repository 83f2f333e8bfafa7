"""A scenario: one experiment in the tank as it would be written on a test card.

Every imperfection has a null value, which is its default: no noise, no quantisation, no drop-outs, no turbulence. The
controllers' gains are guesses: the paper does not give its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..plant.truth import read_effects
from ..record.files import run_name
from ..record.table import GREATEST, Table, open_table
from ..record.toml import find_file
from ..resources import models_dir, scenarios_dir
from ..units import FOOT_M
from ..waves import Waves
from .excitation import Excitation, check_frequencies, read_excitation
from .sea import read_waves

STEP_S = 0.01  # [s] step of the tank's integrator, of which the tick is a multiple (models/phoenix.xml)
SHALLOWEST_M = 0.2  # [m] least depth of the hull's centre, whose half height is 0.13 m: the surface is not modelled
FT2_M2 = FOOT_M**2  # [m2/ft2]
INFINITE = float("inf")


def within(default: float, low: float, high: float) -> Any:
    """A field that a file may set within [low, high]."""
    return field(default=default, metadata={"read": lambda table, key: table.number(key, default, low, high)})


def above_zero(default: float, high: float = GREATEST) -> Any:
    """A field that a file may set above zero, up to `high`."""
    return field(default=default, metadata={"read": lambda table, key: table.positive(key, default, high)})


def stated() -> Any:
    """A field that a file may set above zero, and None where it does not."""
    return field(default=None, metadata={"read": lambda table, key: table.positive(key) if table.has(key) else None})


@dataclass(frozen=True)
class Sonar:
    """Beam, ping rate and imperfections of the sonar that looks at the wall ahead.

    Attributes:
        beam: "pencil" (a cone of width_deg) or "sector" (1 deg across, width_deg high).
        width_deg: full opening angle [deg]; 0 is a single ray.
        rate_hz: pings per second; the tick rate divided by a whole number [Hz].
        resolution_m: ranges are rounded to multiples of it; 0 for none [m].
        noise_m: standard deviation of a range before rounding [m].
        dropout: probability that a ping brings no range [-].
        max_range_m: echoes from beyond are not heard [m].
    """

    beam: str = "pencil"
    width_deg: float = within(0.0, 0.0, 120.0)
    rate_hz: float = 10.0
    resolution_m: float = within(0.0, 0.0, 1.0)
    noise_m: float = within(0.0, 0.0, 10.0)
    dropout: float = within(0.0, 0.0, 1.0)
    max_range_m: float = above_zero(INFINITE, INFINITE)


@dataclass(frozen=True)
class Tachometer:
    """Propeller speed sensor: noise [rev/s], and the rate [1/s] at which the motor drive follows its reading."""

    noise_rev_s: float = within(0.0, 0.0, 10.0)
    governor_per_s: float = 0.0


@dataclass(frozen=True)
class Turbulence:
    """Surge acceleration by turbulence: Ornstein-Uhlenbeck, standard deviation [m/s2] and correlation time [s]."""

    acceleration_m_s2: float = within(0.0, 0.0, 10.0)
    time_s: float = above_zero(1.0)


@dataclass(frozen=True)
class SonarFilter:
    """On-board three-state filter: white jerk q [m2/s5] and range variance r [m2].

    r = 0.01 ft2 is the paper's; it gives no q: from about 1 ft2/s5 the filter's gain is "almost unitary", as it says.
    """

    q_m2_per_s5: float = 1.0 * FT2_M2
    r_m2: float = 0.01 * FT2_M2


@dataclass(frozen=True)
class Control:
    """Gains of the controllers: all guesses.

    Surge: acceleration demand = position gain x error + speed gain x error of speed; propeller speed = the square root
    of the demand over what the controller takes for beta (`thrust_m_per_rev2`, None for the truth's), blunted below
    `blunt_rev_s`.
    The other axes: natural frequency [rad/s] and damping ratio on the true pose (perfect gyro and depth cell).
    """

    position_per_s2: float = within(0.4, 0.0, 100.0)
    speed_per_s: float = within(1.0, 0.0, 100.0)
    thrust_m_per_rev2: float | None = stated()
    blunt_rev_s: float = within(5.0, 0.0, 20.0)
    hold_rad_s: float = within(0.5, 0.0, 5.0)
    hold_damping: float = within(1.0, 0.0, 10.0)


@dataclass(frozen=True)
class Scenario:
    """One experiment. Angles, feet and rpm stop at the file; everything here is SI.

    Attributes:
        name: the file's.
        description: one sentence.
        truth: truth preset, name or path; a path in the file starts beside the file.
        duration_s, period_s: length of the record and of a tick [s].
        standoff_m: distance from sonar to wall at the start [m].
        depth_m: of the hull's centre [m].
        n_limit_rev_s: largest commanded propeller speed either way, None for the truth's [rev/s].
        hold: "thrusters" holds the other axes with their thrusters, "rigid" holds them exactly.
        seed: of all noise.
        vehicle: vehicle file, name or path, as `truth`.
        walls: MJCF of the walls around it, name in models/ or path, as `truth`.
        effects: slot of the parameter vector -> value, of the effects that are switched on.
    """

    name: str
    path: Path
    description: str
    truth: str
    duration_s: float
    period_s: float
    standoff_m: float
    depth_m: float
    n_limit_rev_s: float | None
    hold: str
    seed: int
    excitation: Excitation
    sonar: Sonar = Sonar()
    tachometer: Tachometer = Tachometer()
    turbulence: Turbulence = Turbulence()
    filter: SonarFilter = SonarFilter()
    control: Control = Control()
    effects: Mapping[str, float] = field(default_factory=dict)
    vehicle: str = "phoenix"
    walls: str = "basin"
    waves: Waves = Waves()

    @property
    def samples(self) -> int:
        """Samples in the record, the first at t = 0 and the last at the end."""
        return int(np.floor(self.duration_s / self.period_s + 1e-9)) + 1

    @property
    def time_s(self) -> NDArray[np.float64]:
        """Instants of the samples, shape (samples,) [s]."""
        return np.arange(self.samples, dtype=np.float64) * self.period_s


def load_scenario(name_or_path: str | Path, settings: Sequence[str] = ()) -> Scenario:
    """The scenario of that name in scenarios/, or of that TOML file, with `key=value` settings laid over it.

    InputError names file, line and key of whatever is unknown, of the wrong type or unit, out of bounds or unsafe.
    """
    path = scenario_file(name_or_path)
    return read_scenario(open_table(path, tuple(settings)))


def scenario_file(name_or_path: str | Path) -> Path:
    """The scenario of that name in scenarios/, of one axis or a whole vehicle, or that TOML file; InputError else."""
    return find_file(name_or_path, scenarios_dir(), "scenario", inner="whole")


def read_scenario(table: Table) -> Scenario:
    """The scenario in a whole file that is open already; InputError as `load_scenario`."""
    period_s, tachometer = _period(table), table.table("tachometer")
    scenario = Scenario(
        name=run_name(table.path),
        path=table.path,
        description=table.text("description", ""),
        truth=table.file("truth", "paper-ii", presets=(models_dir() / "truths", "truth preset")),
        duration_s=table.positive("duration_s", 120.0, 86400.0),
        period_s=period_s,
        standoff_m=table.positive("standoff_m", 10.0 * FOOT_M, 1000.0),
        depth_m=table.number("depth_m", 3.0 * FOOT_M, SHALLOWEST_M, 1000.0),
        n_limit_rev_s=table.positive("n_limit_rev_s") if table.has("n_limit_rev_s") else None,
        hold=table.choice("hold", ("thrusters", "rigid"), "thrusters"),
        seed=table.integer("seed", 0),
        excitation=read_excitation(table.table("excitation")),
        sonar=_sonar(table.table("sonar"), period_s),
        tachometer=_section(
            tachometer, Tachometer, governor_per_s=tachometer.number("governor_per_s", 0.0, 0.0, 1.0 / period_s)
        ),
        turbulence=_section(table.table("turbulence"), Turbulence),
        filter=_filter(table.table("filter")),
        control=_section(table.table("control"), Control),
        effects=read_effects(table.table("effects")),
        vehicle=table.file("vehicle", "phoenix", presets=(models_dir(), "vehicle")),
        walls=table.file("walls", "basin", ".xml"),
        waves=read_waves(table.table("waves"), table.number("depth_m", 3.0 * FOOT_M)),
    )
    table.close()
    check_frequencies(table.table("excitation"), scenario.excitation, period_s)
    return scenario


def scenario_names() -> tuple[str, ...]:
    """Names of the scenarios that come with vtank."""
    return tuple(sorted(path.stem for path in scenarios_dir().glob("*.toml")))


def _period(table: Table) -> float:
    period = table.positive("period_s", 0.1, 10.0)
    if abs(period / STEP_S - round(period / STEP_S)) > 1e-9:
        raise table.error("period_s", f"expected a multiple of the tank's step, {STEP_S:g} s; found {period:g}")
    return period


def _section(table: Table, kind: type[Any], **others: Any) -> Any:
    """A dataclass whose fields are read as they say, but for the others, which are known."""
    values = {f.name: f.metadata["read"](table, f.name) for f in fields(kind) if f.name not in others}
    table.close()
    return kind(**values, **others)


def _sonar(table: Table, period_s: float) -> Any:
    rate = table.positive("rate_hz", 1.0 / period_s)
    ticks = 1.0 / (rate * period_s)
    if abs(ticks - round(ticks)) > 1e-6 or ticks < 0.5:
        message = f"expected the tick rate, {1.0 / period_s:g} Hz, divided by a whole number; found {rate:g}"
        raise table.error("rate_hz", message)
    beam = table.choice("beam", ("pencil", "sector"), "pencil")
    return _section(table, Sonar, beam=beam, rate_hz=rate)


def _filter(table: Table) -> SonarFilter:
    values = []
    for name, unit, default in (("q", "2_per_s5", SonarFilter.q_m2_per_s5), ("r", "2", SonarFilter.r_m2)):
        feet, metres = f"{name}_ft{unit}", f"{name}_m{unit}"
        if table.has(feet):
            table.either(feet, metres)
            values.append(table.positive(feet) * FT2_M2)
        else:
            values.append(table.positive(metres, default))
    table.close()
    return SonarFilter(*values)
