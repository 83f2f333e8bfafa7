"""The [waves] of a scenario."""

from __future__ import annotations

from ..record.section import Section
from ..waves import Waves, breaking_height
from ..waves.sea import KINDS


def read_waves(section: Section, depth_m: float) -> Waves:
    """The sea over a vehicle at that depth; InputError where waves would break or bare the vehicle."""
    kind = section.choice("kind", KINDS, None if section.entries else "none")
    regular, irregular = kind == "regular", kind == "irregular"
    height, period = ("significant_height_m", "peak_period_s") if irregular else ("height_m", "period_s")
    waves = Waves(
        kind=kind,
        height_m=section.number(height, None if regular or irregular else 0.0, 0.0, 30.0),
        period_s=section.number(period, None if regular or irregular else Waves.period_s, 0.5, 36000.0),
        water_depth_m=section.positive("water_depth_m", Waves.water_depth_m),
        peakedness=section.number("peakedness", Waves.peakedness, 1.0, 10.0),
        components=section.integer("components", Waves.components, 1),
        reflection=section.number("reflection", 0.0, 0.0, 1.0),
        ramp_s=section.number("ramp_s", 0.0, 0.0),
    )
    section.close()
    _check(section, waves, height, depth_m)
    return waves


def _check(section: Section, waves: Waves, key: str, depth_m: float) -> None:
    if not waves.water_depth_m > depth_m:
        raise section.error("water_depth_m", f"expected more than the vehicle's depth_m of {depth_m:g} m")
    steepest = breaking_height(waves.period_s, waves.water_depth_m)
    if waves.height_m > steepest:
        message = f"{waves.height_m:g} m: waves of {waves.period_s:g} s break from {steepest:.2g} m here"
        raise section.error(key, message)
    if waves.height_m > depth_m:
        raise section.error(key, f"{waves.height_m:g} m: linear theory wants the vehicle, at {depth_m:g} m, well below")
