"""Effects of one thruster or fin: what acts of its input, and what force comes of it."""

from __future__ import annotations

import numpy as np

from ...plant.vehicle import Vehicle
from .effect import Array, Moving, Number, PlacedEffect, Values, part, with_part

INPUT = ("_rev_s", "", "_N")  # endings by the thruster's input: rev_s, command, N
LOSS = ("_N_s2_per_rev_m", "_N_s_per_m", "_s_per_m")  # force per input and speed


def dead_band(n: Array, p: Values) -> Array:
    """Nothing below n0, n0 less above."""
    return n - np.clip(n, -p["n0"], p["n0"])


def saturated(n: Array, p: Values) -> Array:
    """Flat beyond n_max."""
    return np.clip(n, -p["n_max"], p["n_max"])


def misread(n: Array, p: Values) -> Array:
    """The recording has b more than what acts."""
    return n - p["b"]


def spiked(n: Array, p: Values, random: np.random.Generator) -> Array:
    """Single readings are far off, either way."""
    return n + p["size"] * random.choice([-1.0, 1.0], n.size) * (random.random(n.size) < p["p"])


def one_sided(time_s: Array, n: Array, force: Array, p: Values) -> Array:
    """(1 + e) ahead, (1 - e) astern."""
    return force * (1.0 + p["e"] * np.sign(force))


def fading(time_s: Array, n: Array, force: Array, p: Values) -> Array:
    """Less and less as the battery runs down."""
    return force * np.exp(-p["r"] * time_s)


def weak(time_s: Array, n: Array, force: Array, p: Values) -> Array:
    """What is left of it."""
    return force * (1.0 - p["share"])


def reversed_(time_s: Array, n: Array, force: Array, p: Values) -> Array:
    """The other way."""
    return -force


def later(p: Values) -> float:
    """Delay [s]."""
    return p["d"]


def slower(vehicle: Vehicle, name: str, p: Values) -> Vehicle:
    """Longer lag."""
    return with_part(vehicle, "thrusters", name, lag_s=part(vehicle, "thrusters", name).lag_s + p["tau"])


def turned(vehicle: Vehicle, name: str, p: Values) -> Vehicle:
    """Mounted at another angle: yaw about z, then pitch about y, of the body's axes."""
    x, y, z = part(vehicle, "thrusters", name).direction
    c, s = np.cos(p["yaw"]), np.sin(p["yaw"])
    x, y = c * x - s * y, s * x + c * y
    c, s = np.cos(p["pitch"]), np.sin(p["pitch"])
    x, z = c * x + s * z, c * z - s * x
    return with_part(vehicle, "thrusters", name, direction=(float(x), float(y), float(z)))


def advance_loss(s: Moving, name: str, p: Values) -> Array:
    """Less thrust the faster the propeller advances: -gamma |n| u_a along its direction."""
    gear = s.gears[name]
    return -p["gamma"] * abs(s.asked.get(name, 0.0)) * float(gear @ s.through) * gear


def offset(angle: Array, p: Values) -> Array:
    """Neutral is not where the file has it."""
    return angle + p["angle"]


def smaller(vehicle: Vehicle, name: str, p: Values) -> Vehicle:
    """Part of a fin's area gone."""
    fin = part(vehicle, "fins", name)
    return with_part(vehicle, "fins", name, area_m2=fin.area_m2 * (1.0 - p["share"]))


THRUSTERS = (  # in the order in which they act: what is read, what acts of it, the force
    PlacedEffect(
        "tachometer_bias",
        "thruster",
        "The recorded input is off by an amount.",
        "n_read = n + b",
        (Number("b", INPUT, "offset of what is recorded", usual=lambda s: 0.2 * s.input),),
        input=misread,
    ),
    PlacedEffect(
        "thrust_deadband",
        "thruster",
        "Below a threshold the propeller only churns, or the drive does not turn it.",
        "n_e = sign(n) max(|n| - n0, 0)",
        (Number("n0", INPUT, "threshold, in the unit of the input", low=0.0, usual=lambda s: 0.3 * s.input),),
        input=dead_band,
    ),
    PlacedEffect(
        "thrust_saturation",
        "thruster",
        "Beyond some input the thruster pushes no harder.",
        "n_e = min(max(n, -n_max), n_max)",
        (Number("n_max", INPUT, "where it flattens", low=0.0, usual=lambda s: 0.6 * s.input, shape=True),),
        input=saturated,
    ),
    PlacedEffect(
        "thrust_asymmetry",
        "thruster",
        "Blades are cambered for going ahead, so the same input pushes less astern.",
        "F -> F (1 + e sign(F))",
        (Number("e", ("",), "half the relative difference", low=-0.95, high=0.95, usual=lambda _: 0.3),),
        thrust=one_sided,
    ),
    PlacedEffect(
        "thrust_lag",
        "thruster",
        "The force follows more slowly than the vehicle file has it.",
        "lag_s -> lag_s + tau",
        (Number("tau", ("_s",), "more time constant", low=0.0, high=60.0, usual=lambda _: 0.4),),
        changes=slower,
    ),
    PlacedEffect(
        "thrust_loss",
        "thruster",
        "The faster the propeller advances through the water, the less it pushes.",
        "F -= gamma |n| u_a",
        (
            Number(
                "gamma",
                LOSS,
                "loss per input and speed of advance",
                low=0.0,
                usual=lambda s: 0.3 * s.force / s.input / s.u,
            ),
        ),
        wrench=advance_loss,
    ),
    PlacedEffect(
        "supply_sag",
        "thruster",
        "The battery runs down, and the same input pushes less and less.",
        "F -> F exp(-r t)",
        (Number("r", ("_per_s",), "relative fading", low=0.0, high=1.0, usual=lambda _: 0.003),),
        thrust=fading,
    ),
    PlacedEffect(
        "command_delay",
        "thruster",
        "The drive obeys late.",
        "n(t) -> n(t - d)",
        (Number("d", ("_s",), "delay", low=0.0, high=60.0, usual=lambda _: 0.4),),
        delay=later,
    ),
    PlacedEffect(
        "tachometer_spikes",
        "thruster",
        "Single recorded inputs are far off, though the thruster turned evenly.",
        "n_read = n +- size with probability p",
        (
            Number("p", ("",), "probability per reading", low=0.0, high=1.0, usual=lambda _: 0.05, shape=True),
            Number("size", INPUT, "size of a spike", low=0.0, usual=lambda s: 0.5 * s.input),
        ),
        recorded=spiked,
    ),
    PlacedEffect(
        "thruster_dead",
        "thruster",
        "A thruster is dead, or makes only part of its force.",
        "F -> (1 - share) F",
        (Number("share", ("",), "of its force that is lost", 1.0, 0.0, 1.0, usual=lambda _: 0.5),),
        thrust=weak,
    ),
    PlacedEffect(
        "thruster_reversed",
        "thruster",
        "A thruster pushes the other way: wires or blades are the wrong way round.",
        "F -> -F",
        thrust=reversed_,
    ),
    PlacedEffect(
        "wrong_allocation",
        "thruster",
        "The inputs of two thrusters are exchanged.",
        "n_this <-> n_other",
        text="other",
    ),
    PlacedEffect(
        "thruster_turned",
        "thruster",
        "A thruster does not push in the direction that the vehicle file has.",
        "direction -> R_y(pitch) R_z(yaw) direction",
        (
            Number("yaw", ("_rad",), "about the body's z", 0.0, -3.2, 3.2, usual=lambda _: 0.3),
            Number("pitch", ("_rad",), "about the body's y", 0.0, -3.2, 3.2, usual=lambda _: 0.2),
        ),
        changes=turned,
    ),
    PlacedEffect(
        "fin_offset",
        "fin",
        "A fin stands at an angle when it is told to stand straight.",
        "angle -> angle + angle_0",
        (Number("angle", ("_rad",), "at which it stands", low=-1.6, high=1.6, usual=lambda _: 0.05),),
        input=offset,
    ),
    PlacedEffect(
        "fin_weak",
        "fin",
        "A fin has lost part of its area.",
        "A -> (1 - share) A",
        (Number("share", ("",), "of its area that is lost", 1.0, 0.0, 0.999, usual=lambda _: 0.4),),
        changes=smaller,
    ),
    PlacedEffect(
        "fin_delay",
        "fin",
        "A fin obeys late.",
        "angle(t) -> angle(t - d)",
        (Number("d", ("_s",), "delay", low=0.0, high=60.0, usual=lambda _: 0.4),),
        delay=later,
    ),
)
