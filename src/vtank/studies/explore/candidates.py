"""Runs from which the next one is chosen: axes of a vehicle, kinds, amplitudes and frequencies of excitation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...experiment.allocation import able
from ...experiment.whole_scenario import WholeScenario, scenario_of
from ...plant import Vehicle
from ...plant.vehicle import AXES
from ...resources import models_dir

DURATION_S = 40.0  # [s] of a run; a choice
BANDS_RAD_S = {"slow": (0.15, 0.35, 0.7), "quick": (0.5, 1.1, 2.0)}  # choices, as all shares and speeds below
SHARE = 0.7  # of the largest force, of all that is excited together
PUSH_S, SPEED_M_S = 8.0, 0.4
TURN = 'kind = "zigzag"\namplitude_share = 0.4\nheading_rad = 0.3'
SWING = 'kind = "multisine"\namplitudes_rad = [0.12, 0.12, 0.12]\nfrequencies_rad_s = [0.06, 0.15, 0.3]\nramp_s = 5.0'


@dataclass(frozen=True)
class Candidate:
    """A run that could be flown: what it is in words, and the scenario file that flies it."""

    words: str
    text: str

    @property
    def minutes(self) -> float:
        """How long it takes [min]."""
        return DURATION_S / 60.0

    def scenario(self, seed: int) -> WholeScenario:
        """The scenario with another seed; InputError where the vehicle cannot fly it."""
        return scenario_of(self.text, "planned", seed)


def candidates(vehicle: Vehicle, depth_m: float | None = None, walls: str = "") -> list[Candidate]:
    """In the order in which one without a planner would fly them: all axes at once, then each by itself.

    depth_m: at which the runs begin, of what dives. walls: name of a basin or path of its MJCF.
    """
    axes = [axis for axis in able(vehicle) if axis in (*AXES[:3], "yaw")]
    steered = any(fin.limit_rad for fin in vehicle.fins)  # fins need speed
    runs = [] if steered else [("all axes", [_sines(a, "quick", SHARE / len(axes)) for a in axes], axes, False)]
    if "yaw" in axes and "surge" in axes:
        runs.append(("zig-zag ahead", [f'axis = "yaw"\n{TURN}'], ["yaw"], True))
        runs.append(("swings of the heading ahead", [f'axis = "yaw"\n{SWING}\nbandwidth_rad_s = 0.4'], ["yaw"], True))
    for axis in axes:
        ahead = steered and axis != "surge"
        for band in BANDS_RAD_S:
            runs.append((f"{axis}, {band} multisine", [_sines(axis, band, SHARE)], [axis], ahead))
        runs.append((f"{axis}, push and coast", [_steps(axis)], [axis], ahead))
    preset = vehicle.path.parent == models_dir()
    head = f'vehicle = "{vehicle.path.stem if preset else vehicle.path}"\nduration_s = {DURATION_S:g}\nseed = 1\n'
    head += f"depth_m = {depth_m:g}\n" if depth_m is not None else ""
    head += f'walls = "{walls}"\n' if walls else ""
    return [Candidate(words, _text(words, head, parts, excited, ahead)) for words, parts, excited, ahead in runs]


def _sines(axis: str, band: str, share: float) -> str:
    rates = BANDS_RAD_S[band]
    sizes = [round(share / len(rates), 4)] * len(rates)
    waves = f"amplitudes_share = {sizes}\nfrequencies_rad_s = {list(rates)}\nramp_s = 5.0"
    return f'axis = "{axis}"\nkind = "multisine"\n{waves}'


def _steps(axis: str) -> str:
    return f'axis = "{axis}"\nkind = "step_coast"\namplitude_share = {SHARE}\npush_s = {PUSH_S}\ncoast_s = {PUSH_S}'


def _text(words: str, head: str, parts: Sequence[str], excited: Sequence[str], ahead: bool) -> str:
    holds = [f'axis = "surge"\nspeed_m_s = {SPEED_M_S}\nbandwidth_rad_s = 0.3\notherwise = "leave"'] if ahead else []
    kept = (axis for axis in ("heave", "roll", "pitch", "yaw") if axis not in excited)
    holds += [f'axis = "{axis}"\nbandwidth_rad_s = 0.4\notherwise = "leave"' for axis in kept]
    blocks = [*(f"[[excite]]\n{part}" for part in parts), *(f"[[hold]]\n{hold}" for hold in holds)]
    return "\n\n".join([f'description = "{words}"\n{head}', *blocks]) + "\n"
