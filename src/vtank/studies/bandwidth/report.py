"""Responses and sea states as tables for the terminal and the page, and as CSV."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from ...present import Heading, Links, Paragraph, Picture, Table, fixed
from ...present.document import csv_text, html
from .loop import Complex
from .response import Response, unwrapped
from .station import ERROR_M, HELD, Stations

STATION_COLUMNS = ("kind", "water_depth_m", "height_m", "period_s", "error_rms_m", "error_95_m", "share_at_limit",
                   "n_rms_rev_s", "water_rms_m_s", "held")  # fmt: skip
FILES = {
    "response.csv": "every amplitude and frequency, measured, by the linear loop and by harmonic balance",
    "seas.csv": "every sea state",
    "response.png": "Gain and phase of the position against its command, and time with the propellers at their limit.",
    "seas.png": "Error of a kept station over period and height of the waves; the numbers are passed 5 % of the time.",
}
INTRODUCTION = (
    "What the controller can follow, simulated in the MuJoCo tank, and which waves the vehicle can be held in before "
    "a wall."
)


def page(subject: str, tables: Iterable[Table], files: Iterable[str]) -> str:
    """The tables, and the pictures and CSV files that lie beside the page, as HTML."""
    pictures = [Picture(name, FILES[name]) for name in files if name.endswith(".png")]
    links = Links(tuple((name, FILES[name]) for name in files if name.endswith(".csv")))
    title = Heading(f"Bandwidth: {subject}", 1)
    return html(title.text, [title, Paragraph(INTRODUCTION), *pictures, *tables, Heading("Files"), links])


def response_csv(measured: Response, linear: Complex, balanced: Complex) -> str:
    """One line for each amplitude and frequency; linear (W,), balanced (A, W)."""
    columns = {
        "amplitude_m": measured.amplitude_m[:, None],
        "frequency_rad_s": measured.rad_s,
        "gain": measured.gain,
        "phase_deg": np.degrees(measured.phase_rad),
        "share_at_limit": measured.at_limit,
        "n_rms_rev_s": measured.n_rms_rev_s,
        "distortion": measured.distortion,
        "unrest": measured.unrest,
        "linear_gain": np.abs(linear),
        "linear_phase_deg": np.degrees(unwrapped(linear)),
        "harmonic_balance_gain": np.abs(balanced),
        "harmonic_balance_phase_deg": np.degrees(unwrapped(balanced)),
    }
    return csv_text(list(columns), zip(*(each.flat for each in np.broadcast_arrays(*columns.values())), strict=True))


def station_csv(seas: Sequence[Stations]) -> str:
    """One line for each sea state that is possible."""
    rows: list[tuple[object, ...]] = []
    for sea in seas:
        grid = np.meshgrid(sea.water_depth_m, sea.height_m, sea.period_s, indexing="ij")
        measured = (sea.rms_m, sea.most_m, sea.at_limit, sea.n_rms_rev_s, sea.water_rms_m_s)
        columns = (each[np.isfinite(sea.at_limit)] for each in (*grid, *measured, (sea.burden <= 1.0).astype(int)))
        rows += [(sea.kind, *state) for state in zip(*columns, strict=True)]
    return csv_text(STATION_COLUMNS, rows)


def response_table(measured: Response) -> Table:
    """Gain and phase over frequency, and for each amplitude the bandwidth and where the limit takes over."""
    phase = np.degrees(measured.phase_rad)
    rows = []
    for j, w in enumerate(measured.rad_s):
        columns = zip(measured.gain[:, j], phase[:, j], measured.at_limit[:, j], strict=True)
        cells = (f"{g:.2f} {angle:+5.0f}{'*' if share > 0.5 else ' '}" for g, angle, share in columns)
        rows.append((f"{w:.3g}", *cells))
    rows.append(("-3 dB at", *(fixed(w, 2) for w in measured.bandwidth_rad_s())))
    rows.append(("limit from", *(fixed(w, 2) for w in measured.limit_rad_s())))
    header = ("rad/s", *(f"{amplitude:g} m" for amplitude in measured.amplitude_m))
    title = "Position over command: gain and phase [deg]; * propellers at their limit most of the time"
    return Table(header, tuple(rows), left=0, title=title)


def station_tables(sea: Stations) -> list[Table]:
    """Greatest wave height that is held, over water depth and period, and error and propeller use in every sea."""
    word = "significant height" if sea.kind == "irregular" else "height"
    title = (
        f"{sea.kind.capitalize()} waves: greatest {word} [m] that is held "
        f"(error within {ERROR_M:g} m and propellers below their limit for {100 * HELD:.0f} % of the time)"
    )
    periods, held = tuple(f"{period:g} s" for period in sea.period_s), sea.held_height_m()
    found = [(f"{depth:g}", *(_held(sea, d, p, held[d, p]) for p in range(sea.period_s.size)))
             for d, depth in enumerate(sea.water_depth_m)]  # fmt: skip
    tables = [Table(("water [m]", *periods), tuple(found), left=0, title=title)]
    for d, depth in enumerate(sea.water_depth_m):
        title = f"Rms error [m] and time with the propellers at their limit, {sea.kind} waves in {depth:g} m of water"
        rows = tuple((f"{height:g}", *_cells(sea, d, h)) for h, height in enumerate(sea.height_m))
        tables.append(Table(("height [m]", *periods), rows, left=0, title=title))
    return tables


def _cells(sea: Stations, d: int, h: int) -> list[str]:
    pairs = zip(sea.rms_m[d, h], sea.at_limit[d, h], strict=True)
    return [f"{rms:.2f} {100.0 * share:3.0f} %" if np.isfinite(share) else "breaks" for rms, share in pairs]


def _held(sea: Stations, d: int, p: int, height: float) -> str:
    if np.isnan(height):
        return f"< {sea.height_m[0]:g}"
    tried = sea.height_m[np.isfinite(sea.burden[d, :, p])]
    return f">= {height:.2g}" if height >= tried[-1] else f"{height:.2f}"
