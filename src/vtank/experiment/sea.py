"""The [waves] of a scenario."""

from __future__ import annotations

from ..record.table import Table
from ..waves import Waves, breaking_height
from ..waves.sea import KINDS

MOST = 10_000  # components of a sea: a spectrum is smooth long before, and each is summed at every step; a choice


def read_waves(table: Table, depth_m: float) -> Waves:
    """The sea over a vehicle at that depth; InputError where waves would break or bare the vehicle."""
    kind = table.choice("kind", KINDS, None if table.entries else "none")
    regular, irregular = kind == "regular", kind == "irregular"
    height, period = ("significant_height_m", "peak_period_s") if irregular else ("height_m", "period_s")
    waves = Waves(
        kind=kind,
        height_m=table.number(height, None if regular or irregular else 0.0, 0.0, 30.0),
        period_s=table.number(period, None if regular or irregular else Waves.period_s, 0.5, 36000.0),
        water_depth_m=table.positive("water_depth_m", Waves.water_depth_m, float("inf")),
        peakedness=table.number("peakedness", Waves.peakedness, 1.0, 10.0),
        components=table.integer("components", Waves.components, 1, MOST),
        reflection=table.number("reflection", 0.0, 0.0, 1.0),
        ramp_s=table.number("ramp_s", 0.0, 0.0),
    )
    table.close()
    _check(table, waves, height, depth_m)
    return waves


def _check(table: Table, waves: Waves, key: str, depth_m: float) -> None:
    if not waves.water_depth_m > depth_m:
        raise table.error("water_depth_m", f"expected more than the vehicle's depth_m of {depth_m:g} m")
    steepest = breaking_height(waves.period_s, waves.water_depth_m)
    if waves.height_m > steepest:
        message = f"{waves.height_m:g} m: waves of {waves.period_s:g} s break from {steepest:.2g} m here"
        raise table.error(key, message)
    if waves.height_m > depth_m:
        raise table.error(key, f"{waves.height_m:g} m: linear theory wants the vehicle, at {depth_m:g} m, well below")
