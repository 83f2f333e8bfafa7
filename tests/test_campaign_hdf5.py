"""The HDF5 file of a campaign, as xarray reads it, against the CSV files of the same campaign."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from campaigns import SURGE, campaign_of

from vtank.errors import InputError
from vtank.record import read_dataset
from vtank.studies.campaign import Threads, fly_campaign

xarray = pytest.importorskip("xarray")
pytest.importorskip("h5netcdf")

LENGTHS = SURGE.replace("duration_s = 12.0", "duration_s = [6.0, 12.0]").replace("[0.2, 0.4, 4.0]", "[0.2, 4.0]")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One campaign in both forms; runs of two lengths."""
    folder = tmp_path_factory.mktemp("forms")
    for form in ("csv", "hdf5"):
        fly_campaign(campaign_of(folder, LENGTHS), folder / form, Threads(2), form)
    return folder


def test_recordings_are_those_of_the_csv_files(folder: Path) -> None:
    """To the bit, NaN after the end of short runs and throughout failed ones."""
    with xarray.open_dataset(folder / "hdf5" / "runs.h5", engine="h5netcdf") as data:
        assert data.recording.dims == ("run", "time_s", "channel")
        assert data.sizes == {"run": 24, "time_s": 121, "channel": 2}
        runs = read_dataset(folder / "csv" / "data").runs
        assert {run.time_s.size for run in runs} == {61, 121}
        for run in runs:
            for channel in ("n_rev_s", "range_m"):
                values = data.recording.sel(run=run.name, channel=channel)
                np.testing.assert_array_equal(values[: run.time_s.size], run.columns[channel])
                np.testing.assert_array_equal(values.time_s[: run.time_s.size], run.time_s)
                assert np.isnan(values[run.time_s.size :]).all()
        failed = data.run[data.status == "failed"]
        assert set(failed.values) == set(data.run.values) - {run.name for run in runs}
        assert np.isnan(data.recording.sel(run=failed)).all()


def test_the_truth_stands_beside_the_recordings(folder: Path) -> None:
    """The columns of runs.csv, along the runs."""
    with (folder / "csv" / "runs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert (folder / "csv" / "runs.csv").read_bytes() == (folder / "hdf5" / "runs.csv").read_bytes()
    with xarray.open_dataset(folder / "hdf5" / "runs.h5", engine="h5netcdf") as data:
        for name in rows[0]:
            column = data[name].values
            if column.dtype.kind == "f":
                written = [float(row[name]) if row[name] else np.nan for row in rows]
                np.testing.assert_array_equal(column, written)
            else:
                assert column.tolist() == [row[name] for row in rows]
        damped = data.recording.where(data["effects.linear_drag.c_per_s"] > 0.01, drop=True)
        assert 0 < damped.sizes["run"] < 24


def test_without_a_common_time_axis_csv_is_asked_for(tmp_path: Path) -> None:
    campaign = campaign_of(tmp_path, '[grid]\nscenario = "open-loop-sine"\nsonar.rate_hz = 5.0\nperiod_s = [0.1, 0.2]')
    with pytest.raises(InputError, match="expected one period_s, or write CSV"):
        fly_campaign(campaign, tmp_path / "out", Threads(1), "hdf5")
    assert not (tmp_path / "out").exists()
