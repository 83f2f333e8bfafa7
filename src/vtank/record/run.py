"""A run: what one experiment recorded, simulated or real."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from html import escape

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from .columns import column
from .shown import curve, html_table

TIME = "time_s"
INPUTS = ("n_rev_s", "command", "thrust_N")  # propeller speed [rev/s], normalised command -1..1, thrust [N]
CHANNEL = ("channel", "samples", "least", "greatest", "")  # of a run in a notebook
OUTPUTS = ("range_m", "position_m", "surge_m_s")  # distance to the wall ahead, distance made good ahead, surge speed

FloatArray = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Run:
    """One recording: channels on the union of their sample times.

    name      the file's name without .csv
    time_s    shape (T,) [s], strictly increasing
    columns   name -> values, shape (T,) [unit in the name]; NaN where the channel has no sample
    """

    name: str
    time_s: FloatArray
    columns: dict[str, FloatArray]

    def __post_init__(self) -> None:
        """Hold float64 arrays of one length; ValueError otherwise."""
        object.__setattr__(self, "time_s", np.ascontiguousarray(self.time_s, dtype=np.float64))
        columns = {name: np.ascontiguousarray(values, dtype=np.float64) for name, values in self.columns.items()}
        object.__setattr__(self, "columns", columns)
        for name, values in columns.items():
            if self.time_s.ndim != 1 or values.shape != self.time_s.shape:
                raise ValueError(f"{name} has shape {values.shape}, time_s {self.time_s.shape}: expected (T,) for both")

    def __repr__(self) -> str:
        """Name, rows, span and columns."""
        span = f"{self.time_s[0]:g} to {self.time_s[-1]:g} s" if self.time_s.size else "empty"
        return f"Run({self.name!r}, {self.time_s.size} rows, {span}: {', '.join(self.columns)})"

    def _repr_html_(self) -> str:
        """Each channel with its range and its curve, for a notebook."""
        rows = []
        for name in self.columns:
            time_s, values = self.samples(name)
            least, most = (f"{values.min():.4g}", f"{values.max():.4g}") if values.size else ("", "")
            rows.append((name, str(time_s.size), least, most, curve(time_s, values)))
        return f"<p>{escape(self.name)}, {self.duration_s:g} s</p>" + html_table(CHANNEL, rows, pictures=1)

    @classmethod
    def from_channels(cls, name: str, channels: Mapping[str, tuple[ArrayLike, ArrayLike]]) -> Run:
        """A run from channels with sample times of their own: name -> (time [s], values), shape (K,) each."""
        times = {channel: np.asarray(time, dtype=np.float64) for channel, (time, _) in channels.items()}
        union = np.unique(np.concatenate(list(times.values())))
        columns = {channel: np.full(union.size, np.nan) for channel in channels}
        for channel, (_, values) in channels.items():
            columns[channel][np.searchsorted(union, times[channel])] = values
        return cls(name, union, columns)

    @property
    def input(self) -> str:
        """The input's column, one of INPUTS; InputError where the run has none."""
        for name in INPUTS:
            if name in self.columns:
                return name
        drives = [name for name in self.columns if (known := column(name)) and known.role == "input"]
        whole = f"; {drives[0]} is of a whole vehicle, which needs its file: --nominal vehicle.toml" if drives else ""
        raise InputError(f"run {self.name}: no input column, expected one of {', '.join(INPUTS)}{whole}")

    @property
    def outputs(self) -> tuple[str, ...]:
        """Those of OUTPUTS that the run has."""
        return tuple(name for name in OUTPUTS if name in self.columns)

    @property
    def duration_s(self) -> float:
        """Time from the first row to the last [s]."""
        return float(self.time_s[-1] - self.time_s[0])

    def from_start(self) -> Run:
        """The run by a clock that begins with its first row, by which effects and laws in time count."""
        if self.time_s.size == 0 or self.time_s[0] == 0.0:
            return self
        return replace(self, time_s=self.time_s - self.time_s[0])

    def samples(self, name: str) -> tuple[FloatArray, FloatArray]:
        """The samples of a channel: time [s] and values, shape (K,) each, K <= T; InputError for an unknown name."""
        if name not in self.columns:
            raise InputError(f"run {self.name}: no column {name}; it has {', '.join(self.columns)}")
        values = self.columns[name]
        present = ~np.isnan(values)
        return self.time_s[present], values[present]
