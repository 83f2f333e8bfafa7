"""All runs in one HDF5 file: `recording` (run, time, channel) with labelled axes, and the table of runs beside it.

xarray.open_dataset("runs.h5", engine="h5netcdf") reads it as it is. Runs shorter than the longest are filled up with
NaN, failed ones are NaN throughout.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np

from ...errors import InputError
from ...record import DECIMALS
from .campaign import Campaign
from .folder import write_table
from .journal import HDF5, Journal, renamed
from .table import Row, cell, columns, numeric

CHANNELS = ("n_rev_s", "range_m")  # after the time in every recording
RUN, TIME, CHANNEL = "run", "time_s", "channel"
BLOCK = 1024  # rows of the table written at a time; part of what decides the file's bytes
NUMBERS = 2**21  # of recordings written at a time, 16 MB
LEVEL = 1  # of gzip: the numbers are decimal steps plus noise, higher levels gain a few percent for twice the time


def check_hdf5(campaign: Campaign) -> None:
    """InputError where h5py is missing, or the runs have no common time axis."""
    _h5py()
    if len(campaign.periods) > 1:
        raise InputError("HDF5 has one time axis for all runs: expected one period_s, or write CSV")


def write_hdf5(journal: Journal, campaign: Campaign) -> int:
    """Write runs.h5 and runs.csv; returns the number of failed runs."""
    longest = max((row["samples"] for row in journal.rows() if "sha256" in row), default=0)
    with renamed(journal.out / HDF5) as part, _h5py().File(part, "w") as file:
        for name, value in journal.identity.items():
            file.attrs[name] = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
        _axes(file, campaign, longest)
        _recordings(file, journal, longest)
        _columns(file, journal, campaign)
    return write_table(journal, campaign)


def _axes(file: Any, campaign: Campaign, longest: int) -> None:
    """The labels of run, time and channel, as scales that the other data sets refer to."""
    names = [campaign.run_name(number) for number in range(len(campaign))]
    period = next(iter(campaign.periods))
    file.create_dataset(RUN, data=names, dtype=_h5py().string_dtype())
    file[TIME] = np.round(np.arange(longest) * period, DECIMALS)
    file.create_dataset(CHANNEL, data=CHANNELS, dtype=_h5py().string_dtype())
    file[TIME].attrs["units"] = "s"
    for name in (RUN, TIME, CHANNEL):
        file[name].make_scale(name)


def _recordings(file: Any, journal: Journal, longest: int) -> None:
    runs, channels = file[RUN].size, len(CHANNELS)
    shape, chunk = (runs, longest, channels), (1, max(longest, 1), channels)
    recording = file.create_dataset("recording", shape, "f8", chunks=chunk, compression=LEVEL, fillvalue=np.nan)
    for axis, name in enumerate((RUN, TIME, CHANNEL)):
        recording.dims[axis].attach_scale(file[name])
    some = max(1, NUMBERS // (longest * channels)) if longest else runs
    arrays = _arrays(journal)
    for start in range(0, runs, some):
        block = np.full((min(some, runs - start), longest, channels), np.nan)
        for place, values in zip(range(len(block)), arrays, strict=False):
            if values is not None:
                block[place, : values.shape[1]] = values[1:].T
        recording[start : start + len(block)] = block


def _arrays(journal: Journal) -> Iterator[np.ndarray | None]:
    """Values of every run, shape (1 + channels, T), time first; None for a failed one."""
    for start, rows in journal.pages():
        with journal.spool(start).open("rb") as spool:
            for row in rows:
                yield np.load(spool, allow_pickle=False) if "sha256" in row else None


def _columns(file: Any, journal: Journal, campaign: Campaign) -> None:
    """One data set along the runs for every column of the table."""
    numbers = numeric(campaign)
    names = [name for name in columns(campaign) if name != RUN]
    for name in names:
        kind = "f8" if name in numbers else _h5py().string_dtype()
        column = file.create_dataset(name, (file[RUN].size,), kind)
        column.dims[0].attach_scale(file[RUN])
    rows = journal.rows()
    for start in range(0, file[RUN].size, BLOCK):
        block = list(islice(rows, BLOCK))
        for name in names:
            file[name][start : start + len(block)] = [_entry(row, name, name in numbers) for row in block]


def _entry(row: Row, name: str, number: bool) -> float | str:
    value = row.get(name)
    if number:
        return np.nan if value is None else float(value)
    return str(cell(value))


def _h5py() -> Any:
    try:
        import h5py
    except ImportError:
        raise InputError("HDF5 needs h5py: pip install 'vtank[h5]'") from None
    return h5py
