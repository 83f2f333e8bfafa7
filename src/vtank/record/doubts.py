"""Values that can be, but that another unit would explain better: the user is told, the run is read as it stands."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .columns import channel_of
from .run import TIME, Run

SHORTEST_S = 1e-3  # [s] between rows; below, they are faster than any recorder of a vehicle; a choice

# Column, or channel of a sensor -> typical size beyond which the unit is doubted, and the likely cause; guesses, about
# ten times what is usual in a tank or under a vehicle
DOUBTED = {
    "range_m": (500.0, "is it mm or cm?"),
    "position_m": (5000.0, "is it mm or cm?"),
    "depth_m": (2000.0, "is it mm, cm or mbar?"),
    "roll_rad": (1.6, "is it degrees?"),
    "pitch_rad": (1.6, "is it degrees?"),
    "accel_x_m_s2": (50.0, "is it mg or cm/s2?"),
    "accel_y_m_s2": (50.0, "is it mg or cm/s2?"),
    "accel_z_m_s2": (50.0, "is it mg or cm/s2?"),
    "battery_V": (1000.0, "is it mV?"),
    "surge_m_s": (15.0, "is it cm/s or mm/s?"),
    "sway_m_s": (15.0, "is it cm/s or mm/s?"),
    "heave_m_s": (15.0, "is it cm/s or mm/s?"),
    "n_rev_s": (100.0, "is it rad/s or rpm?"),
    "heading_rad": (50.0, "is it degrees?"),
    "roll_rate_rad_s": (5.0, "is it deg/s?"),
    "pitch_rate_rad_s": (5.0, "is it deg/s?"),
    "yaw_rate_rad_s": (5.0, "is it deg/s?"),
}


def doubts(run: Run) -> Iterator[str]:
    """What is doubted of a sound run, with the likely cause, a sentence each."""
    step_s = float(np.median(np.diff(run.time_s)))
    if step_s < SHORTEST_S:
        yield f"column {TIME}: rows {step_s:.3g} s apart; are they hours or days?"
    for name, values in run.columns.items():
        most, cause = DOUBTED.get(channel_of(name), (np.inf, ""))
        if (typical := float(np.nanmedian(np.abs(values)))) > most:
            yield f"column {name}: typically {typical:.4g}; {cause}"
