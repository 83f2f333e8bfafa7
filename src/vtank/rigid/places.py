"""The catalogue of a whole vehicle: every effect at every place where it may act, with what is known of it beforehand.

An effect at a place moves some slots of the layout. Sizes are scaled by what the vehicle did: forces by those that its
thrusters made along that axis, speeds by its speeds, so that no number here belongs to one vehicle.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..record.columns import ACCELERATION, ATTITUDE, RATES, VELOCITY, channel_of
from .layout import AXES, COUPLES, XYZ, Layout
from .readings import CHANNELS, ROLL

Array = NDArray[np.float64]
EARTH = ("north", "east", "down")
# Own parameters of a vehicle file, and the prior deviations of its numbers as shares of them: by what the tables of
# such vehicles differ (models/README.md); guesses
OWN_OF_AXIS = {"quadratic_drag": 0.3, "linear_drag": 0.3, "added_mass": 0.3}
OWN_OF_THRUSTERS = {"gain": 0.2, "own_gain": 0.03, "lag": 0.5}
OWN_OF_FINS = {"lift": 0.3}
BODY = 0.2  # of its mass, by which a simulator's hull may be heavier than its file; a guess
TWINS = {"sensor_latency": "clock_offset"}  # the same to any recording
UNITS = (  # unit, channels that may be in it, and how many of it make one of SI
    ("knots", VELOCITY, 1.943844), ("km/h", VELOCITY, 3.6), ("ft/s", VELOCITY, 3.28084), ("cm/s", VELOCITY, 100.0),
    ("mm/s", VELOCITY, 1000.0), ("degrees", (*ATTITUDE, *RATES), 57.29578), ("degrees/s", RATES, 57.29578),
    ("degrees, its rates in rad/s", ATTITUDE, 57.29578), ("feet", CHANNELS[:ROLL], 3.28084),
    ("cm", CHANNELS[:ROLL], 100.0), ("mm", CHANNELS[:ROLL], 1000.0), ("g", ACCELERATION, 0.1019716),
)  # fmt: skip
SPIKE = 0.05  # of the largest input, below which what stands alone is no spike; a choice
FACTOR, SIGN = "it is wrong by a factor", "it has the other sign"
HELD_S = 0.1  # [s] for which inputs are held in most recordings; a delay may be off by that and fit well; a guess
LATE_S = (0.4, 0.8, 1.6, 3.2)  # [s] by which an instrument may be grossly late or early, or what it moves; choices
USUAL_WAKE_S = 5.0  # [s] that a wake lasts before anything is known of it; a guess
SPEED_UNIT = ("m/s", "rad/s")
HYDRODYNAMICS, ACTUATOR, SENSOR_CHANNEL = "hydrodynamics", "actuator", "sensor"


@dataclass(frozen=True)
class Parameter:
    """One number of an effect: its slots (more than one move alike), unit, prior deviation, bounds, where fits begin.

    Attributes:
        name: as in the effect's law, as the tank's effect has it. slots: names in the layout. unit: SI.
        scale: prior standard deviation about `null`; 0 fixes the number at its only start.
        null: value that does nothing; where it is finite the slot has it, and the fit finds how far off it is.
        low, high: bounds, about the vehicle file's.
        starts: where fits begin.
        far: gross values, each farther off than the one before: a fit that begins at none of them never gets there.
        grain: how far apart best fits lie that are best about themselves only; 0 where there is one.
        optional: whether it is a component of a vector, of which some are as likely nothing as not.
        factor: whether it is off by a factor, whose logarithm has that deviation, those bounds and those starts.
    """

    name: str
    slots: tuple[str, ...]
    unit: str
    scale: float
    low: float = -np.inf
    high: float = np.inf
    starts: tuple[float, ...] = ()
    null: float = 0.0
    far: tuple[float, ...] = ()
    grain: float = 0.0
    optional: bool = False
    factor: bool = False

    def moved(self, value: Array | float, off: float) -> Array | float:
        """What is in a slot whose value it is, once the number is off by so much."""
        return value * np.exp(off) if self.factor else (value if np.isfinite(self.null) else 0.0) + off


@dataclass(frozen=True)
class Placed:
    """An effect at a place.

    Attributes:
        effect, place: `linear_drag`, `yaw`. channel: hydrodynamics, actuator or sensor.
        parameters: its numbers. sentence: what it is.
        detail: which column of an instrument, where it is one of several.
        mimicry: log evidence that it finds where it is not, and that is taken off what it finds.
    """

    effect: str
    place: str
    channel: str
    parameters: tuple[Parameter, ...]
    sentence: str
    detail: str = ""
    mimicry: float = 0.0

    @property
    def exchange(self) -> bool:
        """Whether it exchanges the inputs of its place and of its detail, so that it stands at both."""
        return any(slot.startswith("wired@") for number in self.parameters for slot in number.slots)

    @property
    def name(self) -> str:
        """EFFECT@PLACE, and the column where the effect is that of one."""
        return f"{self.effect}@{self.place}" + (f":{self.detail}" if self.detail else "")


@dataclass(frozen=True)
class Sizes:
    """What the vehicle did, by axis: root mean squares of force, speed and displacement, shape (6,); duration [s].

    waves: frequencies [rad/s] at which the disturbance of surge, sway and heave is strongest. lone: size of the largest
    inputs of each thruster that stand alone.
    """

    force: Array
    speed: Array
    away: Array
    duration_s: float
    length_m: float
    asked: Array
    lone: Array
    waves: tuple[tuple[float, ...], ...] = ((), (), ())

    @classmethod
    def unit(cls, layout: Layout) -> Sizes:
        """Before anything is known of what the vehicle did."""
        thrusters = np.ones(len(layout.pushes))
        return cls(np.ones(6), np.ones(6), np.ones(6), 1.0, 1.0, thrusters, thrusters)


def catalogue(layout: Layout, asked: Sequence[bool] | NDArray[np.bool_], sizes: Sizes) -> tuple[Placed, ...]:
    """Every effect at every place of a vehicle and its recordings."""
    axes = [i for i in range(6) if asked[i]]
    found = [placed for i in axes for placed in _axis(i, layout, sizes)]
    found += [placed for k in range(len(layout.pushes)) for placed in _thruster(k, layout, sizes)]
    found += [placed for fin in layout.vehicle.fins if fin.limit_rad for placed in _fin(fin.name)]
    found += [placed for sensor in layout.sensors for placed in _sensor(sensor, layout, sizes)]
    return (*found, *_vehicle(layout, asked, sizes))


def _axis(i: int, layout: Layout, s: Sizes) -> Iterator[Placed]:
    axis, newton, speed = AXES[i], ("N", "N m")[i > 2], SPEED_UNIT[i > 2]
    F, U = s.force[i], s.speed[i]
    away = ("m", "rad")[i > 2]

    def one(effect: str, name: str, slot: str, unit: str, scale: float, words: str, **more: float) -> Placed:
        number = Parameter(name, (f"{slot}@{axis}",), unit, scale, **more)  # type: ignore[arg-type]
        return Placed(effect, axis, HYDRODYNAMICS, (number,), words)

    yield one("linear_drag", "c", "linear_drag", f"{newton} per {speed}", 0.3 * F / U,
              "drag grows with speed itself, which the simulator leaves out", low=0.0)  # fmt: skip
    yield one(
        "coulomb_friction", "f", "coulomb_friction", newton, 0.3 * F, "something rubs with a constant force", low=0.0
    )
    if layout.null[layout.slot(f"quadratic_drag@{axis}")] > 0.0:
        yield one(
            "drag_asymmetry", "e", "drag_asymmetry", "-", 0.3, "the two ends do not drag alike", low=-1.0, high=1.0
        )
    yield one("ambient_current", "U", "drift", speed, 0.3 * U, "the water drifts along the vehicle's own axis")
    yield one(
        "tether", "k", "spring", f"{newton}/{away}", 0.3 * F / s.away[i], "something pulls back to the start", low=0.0
    )
    yield one("constant_force", "F", "force", newton, 0.3 * F, "something pushes all the time")
    for w in s.waves[i] if i < 3 else ():
        yield Placed("seiche", axis, HYDRODYNAMICS, (
            Parameter("sine", (f"swell@{axis}",), speed, 0.3 * U),
            Parameter("cosine", (f"swell_ahead@{axis}",), speed, 0.3 * U),
            Parameter("frequency", (f"swell_rate@{axis}",), "rad/s", 0.0, starts=(w,)),
            Parameter("detuning", (f"swell_rate@{axis}",), "rad/s", np.pi / s.duration_s, -0.5 * w, 0.5 * w),
        ), "a standing wave carries the hull to and fro", f"{w:.3g} rad/s")  # fmt: skip
    yield Placed("wake_memory", axis, HYDRODYNAMICS, (
        Parameter("k", (f"wake@{axis}",), "-", 0.3, 0.0, 0.95),
        Parameter("T", (f"recovery@{axis}",), "s", 1.0, -3.9, 2.6, (0.0, -1.0, 1.0), USUAL_WAKE_S, factor=True),
    ), "the hull meets the water again that it has set in motion")  # fmt: skip
    if axis == "surge" and any(channel_of(column) == "range_m" for column in layout.columns):
        yield Placed("wall_proximity", axis, HYDRODYNAMICS, (
            Parameter("drag", ("wall_drag@surge",), "-", 0.3, 0.0, 3.0, optional=True),
            Parameter("mass", ("wall_mass@surge",), "-", 0.1, 0.0, 1.0, optional=True),
        ), "near the wall ahead added mass and drag grow")  # fmt: skip
    if axis in COUPLES and axis in ("surge", "sway", "heave"):
        yield one("coriolis", "c", "coupling", "kg", 0.3 * _mass(layout, i),
                  f"another mass turns with the hull than the simulator has: {COUPLES[axis]}")  # fmt: skip
    if axis in ("pitch", "yaw"):
        yield one("munk_moment", "c", "coupling", "kg", 0.3 * _mass(layout, 1 if i == 5 else 2),
                  f"the moment of the hull in oblique flow is another: {COUPLES[axis]}")  # fmt: skip


def _mass(layout: Layout, i: int) -> float:
    return float(layout.null[0] + layout.null[layout.slot(f"added_mass@{AXES[i]}")])


def _thruster(k: int, layout: Layout, s: Sizes) -> Iterator[Placed]:
    push = layout.pushes[k]
    reach, unit = float(s.asked[k]), push.unit

    def one(
        effect: str, name: str, slot: str, unit: str, scale: float, words: str, **more: float | tuple[float, ...]
    ) -> Placed:
        number = Parameter(name, (f"{slot}@{push.name}",), unit, scale, **more)  # type: ignore[arg-type]
        return Placed(effect, push.name, ACTUATOR, (number,), words)

    yield one("thruster_dead", "share", "lost", "-", 0.5, "it makes only part of its force, or none", low=0.0, high=1.0,
              starts=(0.5, 1.0))  # fmt: skip
    yield one("thruster_reversed", "share", "lost", "-", 0.0, "it pushes the other way", starts=(2.0,))
    for other in range(k + 1, len(layout.pushes)):
        name = layout.pushes[other].name
        if layout.pushes[other].kind == push.kind:
            this = Parameter("this", (f"wired@{push.name}",), "-", 0.0, starts=(other + 1.0,))
            that = Parameter("other", (f"wired@{name}",), "-", 0.0, starts=(k + 1.0,))
            words = f"its input and that of {name} are exchanged"
            yield Placed("wrong_allocation", push.name, ACTUATOR, (this, that), words, name)
    yield one(
        "thrust_deadband",
        "n0",
        "deadband",
        unit,
        0.2 * reach,
        "below a threshold it makes no force",
        low=0.0,
        high=reach,
    )
    yield Placed("thrust_saturation", push.name, ACTUATOR, (
        Parameter("n_max", (f"saturation@{push.name}",), unit, 0.5 * reach, 0.2 * reach, 1.2 * reach,
                  (0.9 * reach, 0.7 * reach, 0.5 * reach), np.inf),
    ), "beyond some input it pushes no harder")  # fmt: skip
    yield one("thrust_asymmetry", "e", "asymmetry", "-", 0.3, "it pushes less astern than the file has it",
              low=-0.95, high=0.95)  # fmt: skip
    yield one("thrust_lag", "tau", "slower", "s", 0.5, "its force follows more slowly", low=0.0, high=30.0,
              starts=(0.2, 1.0, 0.0))  # fmt: skip
    yield one("command_delay", "d", "delay", "s", 0.3, "it obeys late", low=0.0, high=30.0, starts=(0.1, 0.4, 1.0, 0.0),
              far=LATE_S, grain=HELD_S)  # fmt: skip
    flow = max(float(np.abs(np.array(push.direction) @ s.speed[:3])), 1e-6)
    yield one("thrust_loss", "gamma", "loss", f"N per {unit} m/s", 0.3 * _force(layout, k, reach) / (reach * flow),
              "the faster it advances, the less it pushes", low=0.0)  # fmt: skip
    yield one("supply_sag", "r", "sag", "1/s", 1.0 / s.duration_s, "it pushes less and less with time", low=0.0)
    yield one("tachometer_bias", "b", "misread", unit, 0.1 * reach, "its recorded input is off")
    if (lone := float(s.lone[k])) > SPIKE * reach:
        words = "single readings of its input are far off"
        yield one(
            "tachometer_spikes",
            "size",
            "spiked",
            unit,
            lone,
            words,
            low=0.0,
            high=2.0 * lone,
            starts=(lone, 0.5 * lone),
        )
    if push.thruster is not None:
        yield Placed("thruster_turned", push.name, ACTUATOR, (
            Parameter("yaw", (f"yawed@{push.name}",), "rad", 0.3, -3.2, 3.2, optional=True),
            Parameter("pitch", (f"pitched@{push.name}",), "rad", 0.3, -3.2, 3.2, optional=True),
        ), "it does not push in the direction that the vehicle file has")  # fmt: skip


def _force(layout: Layout, k: int, reach: float) -> float:
    push = layout.pushes[k]
    return float(np.abs(push.table(reach)[-1])) + 1e-9


def _fin(name: str) -> Iterator[Placed]:
    def one(
        number: str, slot: str, unit: str, scale: float, low: float, **more: float | tuple[float, ...]
    ) -> Parameter:
        return Parameter(number, (f"{slot}@{name}",), unit, scale, low, **more)  # type: ignore[arg-type]

    for effect, number, words in (
        ("fin_offset", one("angle", "offset", "rad", 0.1, -1.5), "it does not stand straight when it is told to"),
        ("fin_weak", one("share", "lost", "-", 0.5, 0.0, high=1.0), "part of its area is lost"),
        ("fin_delay", one("d", "late", "s", 0.3, 0.0, far=LATE_S, grain=HELD_S), "it obeys late"),
        ("fin_drag", one("k", "induced_drag", "N s2/m2", 5.0, 0.0), "it drags with the square of its angle"),
    ):
        yield Placed(effect, name, ACTUATOR, (number,), words)


def _sensor(name: str, layout: Layout, s: Sizes) -> Iterator[Placed]:
    judged = (column for column in layout.columns if column not in layout.followed)
    columns = [column for column in judged if layout.vehicle.instrument(column) == name]
    if not columns:
        return
    channels = {channel_of(column): column for column in columns}
    place = name or "recording"

    def placed(effect: str, words: str, *numbers: Parameter, detail: str = "") -> Placed:
        return Placed(effect, place, SENSOR_CHANNEL, numbers, words, detail)

    late = Parameter("d", (f"latency@{name}",), "s", 0.3, 0.0, 30.0, far=LATE_S)
    yield placed("sensor_latency", "it is recorded late", late)
    early = replace(late, name="o", low=-30.0, high=0.0, far=tuple(-late_s for late_s in LATE_S))
    yield placed("clock_offset", "its clock is apart from the others'", early)
    yield placed("clock_skew", "its clock runs slow or fast",
                 Parameter("s", (f"skew@{name}",), "-", 0.3 / s.duration_s, -0.1, 0.1))  # fmt: skip
    if len(columns) > 1:
        slots = tuple(f"scale@{column}" for column in columns)
        yield placed("sensor_scale", f"all of {FACTOR}", Parameter("s", slots, "-", 0.2, -3.0, 3.0))
        yield placed("wrong_sign", f"all of {SIGN}", Parameter("s", slots, "-", 0.0, starts=(-2.0,)))
    for kind, column in channels.items():
        slot, several = (f"scale@{column}",), len(columns) > 1
        if kind == "accel_z_m_s2":
            continue
        detail = column if several else ""
        yield placed("sensor_scale", FACTOR, Parameter("s", slot, "-", 0.2, -3.0, 3.0), detail=detail)
        yield placed("wrong_sign", SIGN, Parameter("s", slot, "-", 0.0, starts=(-2.0,)), detail=detail)
    units: dict[tuple[tuple[str, ...], float], str] = {}
    for unit, kinds, factor in UNITS:
        if slots := tuple(f"scale@{column}" for kind, column in channels.items() if kind in kinds):
            units.setdefault((slots, factor), unit)
    for (slots, factor), unit in units.items():
        number = Parameter("factor", slots, "-", 0.0, starts=(factor - 1.0,))
        yield placed("wrong_unit", f"it is recorded in {unit}", number, detail=unit)
    if {"surge_m_s", "sway_m_s"} & channels.keys():
        yield placed("earth_axes", "velocity is recorded along north and east",
                     Parameter("share", (f"earth@{name}",), "-", 0.0, starts=(1.0,)))  # fmt: skip
    if {*VELOCITY, *RATES, *ACCELERATION} & channels.keys() or {*ATTITUDE} <= channels.keys():
        numbers = tuple(Parameter(angle, (f"rotation_{angle}@{name}",), "rad", 0.2, -3.2, 3.2, optional=True)
                        for angle in ("roll", "pitch", "yaw"))  # fmt: skip
        yield placed("sensor_rotated", "it is mounted at other angles", *numbers)
    if {"surge_m_s", "accel_x_m_s2", "north_m", "depth_m"} & channels.keys():
        numbers = tuple(Parameter(i, (f"position_{i}@{name}",), "m", 0.3 * s.length_m, -10.0, 10.0, optional=True)
                        for i in XYZ)  # fmt: skip
        yield placed("sensor_displaced", "it sits elsewhere", *numbers)
    if "range_m" in channels:  # no simulation is moved by it: `diagnose.whole.echoes`
        echo = Parameter("p", (), "-", 0.0, starts=(0.0,)), Parameter("extra", (), "m", 0.0, starts=(0.0,))
        yield placed("sonar_multipath", "some pings come back by a longer way", *echo)
    for effect, kinds, unit, scale, words in (
        ("gyro_bias", RATES, "rad/s", 0.05, "it turns where nothing turns"),
        ("accelerometer_bias", ACCELERATION, "m/s2", 0.3, "it reads what is not there"),
        ("magnetometer_bias", ("heading_rad",), "rad", 0.2, "the heading is off by an angle"),
        ("depth_offset", ("depth_m",), "m", 0.5, "it was set to zero elsewhere"),
        ("sonar_offset", ("range_m",), "m", 0.3, "it measures from another point"),
    ):  # fmt: skip
        some = [kind for kind in kinds if kind in channels]
        if some:
            biases = (Parameter(kind, (f"bias@{channels[kind]}",), unit, scale, optional=True) for kind in some)
            yield placed(effect, words, *biases)


def _water(layout: Layout) -> Iterator[Parameter]:
    """How much of a simulator's mass is the body's and not the water's, which its runs do not tell."""
    lent = float(layout.null[layout.slot("lent@hull")])
    if lent > 0.0:
        yield Parameter("lent", ("lent@hull",), "kg", BODY * (lent + float(layout.null[0])), -lent, null=lent)


def _vehicle(layout: Layout, asked: Sequence[bool] | NDArray[np.bool_], s: Sizes) -> Iterator[Placed]:
    L, W = max(s.length_m, 0.1), float(layout.null[layout.slot("weight@hull")])
    mass = float(layout.null[0])

    def placed(effect: str, words: str, *numbers: Parameter) -> Placed:
        return Placed(effect, "vehicle", HYDRODYNAMICS, numbers, words)

    def along(slot: str, names: Sequence[str], unit: str, scale: float, high: float) -> tuple[Parameter, ...]:
        return tuple(Parameter(i, (f"{slot}_{i}@hull",), unit, scale, -high, high, optional=True) for i in names)

    tilts = asked[3] or asked[4]
    if tilts or asked[5] and (asked[0] or asked[1]):
        yield placed("centre_of_gravity", "the centre of gravity is elsewhere",
                     *along("centre_of_gravity", XYZ if tilts else XYZ[:2], "m", 0.03 * L, L))  # fmt: skip
    if tilts:
        yield placed("centre_of_buoyancy", "the centre of buoyancy is elsewhere",
                     *along("centre_of_buoyancy", XYZ, "m", 0.03 * L, L))  # fmt: skip
    if asked[2]:
        yield placed("buoyancy", "it is lighter or heavier in water",
                     Parameter("B", ("buoyancy@hull",), "N", 0.03 * W))  # fmt: skip
        if tilts:
            yield placed("trim_weight", "a weight was added and forgotten",
                         Parameter("m", ("trim@hull",), "kg", 0.05 * mass, 0.0, mass, (0.02 * mass,)),
                         *along("trim", XYZ, "m", 0.3 * L, L))  # fmt: skip
    if sum(bool(asked[i]) for i in range(6)) > 1:
        yield placed("coriolis_left_out", "terms of turning of the added mass are left out of what the vehicle does",
                     Parameter("share", ("left_out@hull",), "-", 0.7, -1.0, 2.0, (1.0,)), *_water(layout))  # fmt: skip
    if asked[5] and asked[1] or asked[4] and asked[2]:
        planes = [("sway", "h", 1, 5), ("heave", "v", 2, 4)]
        cross = [
            Parameter(
                name, (f"crossflow_{end}@hull",), "N s2/m3", 0.3 * s.force[i] / s.speed[i] ** 2 / L, 0.0, optional=True
            )
            for name, end, i, k in planes
            if asked[i] and asked[k]
        ]
        ends = [
            Parameter(end, (f"{end}@hull",), "m", 0.2 * L, -0.45 * L, 0.45 * L, (0.0,), x)
            for end, x in zip(("nose", "tail"), layout.vehicle.ends_m, strict=True)
        ]
        yield placed("cross_flow_drag", "every strip of the hull drags in the flow that it meets itself", *cross, *ends)
    flow = 0.3 * float(np.max(s.speed[:3]))
    drift = [
        i for i, k in zip(EARTH, (0, 1, 2), strict=True) if asked[k] or (k < 2 and asked[5] and (asked[0] or asked[1]))
    ]
    if drift:
        yield placed("current", "the water drifts steadily over ground", *along("current", drift, "m/s", flow, 5.0))
        F = 0.3 * float(np.max(s.force[:3]))
        stiffness = Parameter(
            "k", ("tether@hull",), "N/m", F / max(float(np.max(s.away[:3])), 1e-3), 0.0, optional=True
        )
        seat = along("held_at", XYZ, "m", 0.3 * L, L) if asked[3] or asked[4] or asked[5] else ()
        yield placed("tether", "a cable pulls at the hull", *along("pull", drift, "N", F, np.inf), stiffness, *seat)
