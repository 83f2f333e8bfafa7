"""Responses and sea states as text for the terminal and as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np

from .loop import Complex
from .response import Response, unwrapped
from .station import ERROR_M, HELD, Stations

RESPONSE_COLUMNS = (
    "amplitude_m",
    "frequency_rad_s",
    "gain",
    "phase_deg",
    "share_at_limit",
    "n_rms_rev_s",
    "distortion",
    "unrest",
    "linear_gain",
    "linear_phase_deg",
    "harmonic_balance_gain",
    "harmonic_balance_phase_deg",
)
STATION_COLUMNS = (
    "kind",
    "water_depth_m",
    "height_m",
    "period_s",
    "error_rms_m",
    "error_95_m",
    "share_at_limit",
    "n_rms_rev_s",
    "water_rms_m_s",
    "held",
)


def response_csv(measured: Response, linear: Complex, balanced: Complex) -> str:
    """One line for each amplitude and frequency; linear (W,), balanced (A, W)."""
    rows = []
    phase = measured.phase_rad
    balanced_phase, linear_phase = unwrapped(balanced), unwrapped(linear[None])[0]
    for i, amplitude in enumerate(measured.amplitude_m):
        for j, w in enumerate(measured.rad_s):
            own = (measured.gain[i, j], np.degrees(phase[i, j]), measured.at_limit[i, j], measured.n_rms_rev_s[i, j])
            doubts = (measured.distortion[i, j], measured.unrest[i, j])
            models = (
                abs(linear[j]),
                np.degrees(linear_phase[j]),
                abs(balanced[i, j]),
                np.degrees(balanced_phase[i, j]),
            )
            rows.append((amplitude, w, *own, *doubts, *models))
    return _csv(RESPONSE_COLUMNS, rows)


def station_csv(seas: Sequence[Stations]) -> str:
    """One line for each sea state that is possible."""
    rows = []
    for sea in seas:
        for place in np.argwhere(np.isfinite(sea.at_limit)):
            d, h, p = (int(index) for index in place)
            state = (sea.kind, sea.water_depth_m[d], sea.height_m[h], sea.period_s[p])
            effort = (sea.at_limit[d, h, p], sea.n_rms_rev_s[d, h, p], sea.water_rms_m_s[d, h, p])
            held = int(sea.burden[d, h, p] <= 1.0)
            rows.append((*state, sea.rms_m[d, h, p], sea.most_m[d, h, p], *effort, held))
    return _csv(STATION_COLUMNS, rows)


def response_text(measured: Response) -> str:
    """Gain and phase over frequency, and for each amplitude the bandwidth and where the limit takes over."""
    head = ["rad/s", *(f"{amplitude:g} m" for amplitude in measured.amplitude_m)]
    lines = []
    phase = np.degrees(measured.phase_rad)
    for j, w in enumerate(measured.rad_s):
        columns = zip(measured.gain[:, j], phase[:, j], measured.at_limit[:, j], strict=True)
        lines.append(
            [f"{w:.3g}", *(f"{g:.2f} {angle:+5.0f}{'*' if share > 0.5 else ' '}" for g, angle, share in columns)]
        )
    lines.append(["-3 dB at", *(_number(w) for w in measured.bandwidth_rad_s())])
    lines.append(["limit from", *(_number(w) for w in measured.limit_rad_s())])
    title = "Position over command: gain and phase [deg]; * propellers at their limit most of the time"
    return f"{title}\n{_table([head, *lines])}"


def station_text(sea: Stations) -> str:
    """Greatest wave height that is held, over water depth and period, and error and propeller use in every sea."""
    word = "significant height" if sea.kind == "irregular" else "height"
    title = (
        f"{sea.kind.capitalize()} waves: greatest {word} [m] that is held "
        f"(error within {ERROR_M:g} m and propellers below their limit for {100 * HELD:.0f} % of the time)"
    )
    head = ["water [m]", *(f"{period:g} s" for period in sea.period_s)]
    held = sea.held_height_m()
    rows = [
        [f"{depth:g}", *(_held(sea, d, p, held[d, p]) for p in range(sea.period_s.size))]
        for d, depth in enumerate(sea.water_depth_m)
    ]
    errors = [f"Rms error [m] and time with the propellers at their limit, over {word} [m]"]
    for d, depth in enumerate(sea.water_depth_m):
        lines = [[f"{depth:g} m water", *head[1:]]]
        lines += [[f"{height:g}", *_cells(sea, d, h)] for h, height in enumerate(sea.height_m)]
        errors.append(_table(lines))
    return "\n".join([title, _table([head, *rows]), *errors])


def _cells(sea: Stations, d: int, h: int) -> list[str]:
    pairs = zip(sea.rms_m[d, h], sea.at_limit[d, h], strict=True)
    return [f"{rms:.2f} {100.0 * share:3.0f} %" if np.isfinite(share) else "breaks" for rms, share in pairs]


def _held(sea: Stations, d: int, p: int, height: float) -> str:
    if np.isnan(height):
        return f"< {sea.height_m[0]:g}"
    tried = sea.height_m[np.isfinite(sea.burden[d, :, p])]
    return f">= {height:.2g}" if height >= tried[-1] else f"{height:.2f}"


def _number(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else "-"


def _table(rows: Sequence[Sequence[str]]) -> str:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(cell.rjust(width) for cell, width in zip(row, widths, strict=True)) for row in rows)


def _csv(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([f"{float(x):.6g}" if isinstance(x, float | np.floating) else x for x in row] for row in rows)
    return file.getvalue()
