"""Scenarios of blind trials: several axes of any vehicle excited, the others held where it can."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....experiment.allocation import able
from ....experiment.whole_scenario import DEEP_M
from ....plant.vehicle import AXES, Vehicle
from ..cause import log_uniform

FAMILIES = ("forces", "steps", "zigzag", "swing")
DURATION_S, SPEED_M_S, BAND_RAD_S = (60.0, 150.0), (0.3, 0.6), (0.15, 1.5)  # choices
SHARE = 0.6  # of the largest force, of all components of a multisine together; a choice


def draw_scenario(random: np.random.Generator, vehicle: Vehicle, family: str) -> str:
    """A scenario as a TOML text."""
    axes, duration_s = able(vehicle), round(float(random.uniform(*DURATION_S)))
    steered = any(fin.limit_rad for fin in vehicle.fins)  # fins need speed
    excited = list(random.permutation([axis for axis in axes if axis in AXES[:3] or axis == "yaw"])[:3])
    if family in ("zigzag", "swing") or steered:
        excited = ["yaw"]
    if family == "steps":
        excited = excited[:1]
    parts = [_excited(random, axis, family, len(excited)) for axis in excited]
    if "surge" not in excited and (steered or family in ("zigzag", "swing")):
        parts.append(_hold("surge", f"speed_m_s = {random.uniform(*SPEED_M_S):.3f}\nbandwidth_rad_s = 0.3"))
    parts += [_hold(axis, "bandwidth_rad_s = 0.4") for axis in ("heave", "roll", "pitch", "yaw") if axis not in excited]
    head = f'vehicle = "{vehicle.name}"\nduration_s = {duration_s}\nseed = {random.integers(2**31)}\n'
    if not vehicle.heave_N_per_m:
        head += f"depth_m = {DEEP_M}\n"
    return "\n".join([head, *parts])


def _excited(random: np.random.Generator, axis: str, family: str, count: int) -> str:
    if family == "zigzag":
        keys = {
            "kind": '"zigzag"',
            "amplitude_share": random.uniform(0.2, 0.6),
            "heading_rad": random.uniform(0.1, 0.4),
        }
    elif family == "steps":
        push_s = random.uniform(6.0, 20.0)
        share = float(random.choice([-1.0, 1.0])) * random.uniform(0.3, 0.7)
        keys = {"kind": '"step_coast"', "amplitude_share": share, "push_s": push_s, "coast_s": push_s}
    else:
        rad_s = sorted(log_uniform(random, *BAND_RAD_S) for _ in range(3))
        turning = family == "swing"
        sizes = [0.3 / 3.0] * 3 if turning else [SHARE / 3.0 / count] * 3
        rad_s = [0.3 * w for w in rad_s] if turning else rad_s  # an angle is followed more slowly than a force
        key = "amplitudes_rad" if turning else "amplitudes_share"
        keys = {"kind": '"multisine"', key: sizes, "frequencies_rad_s": rad_s, "ramp_s": 5.0}
        keys |= {"bandwidth_rad_s": 0.4} if turning else {}
    return "\n".join(["[[excite]]", f'axis = "{axis}"', *(f"{key} = {_shown(value)}" for key, value in keys.items())])


def _hold(axis: str, more: str) -> str:
    return f'[[hold]]\naxis = "{axis}"\n{more}\notherwise = "leave"'


def _shown(value: object) -> str:
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ", ".join(map(_shown, value)) + "]"
    return str(value) if isinstance(value, str) else f"{value:.4f}"
