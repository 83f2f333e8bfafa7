"""The noise of a vehicle's recordings: what is coloured within a few samples is an instrument's error, not motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_rigid_motion import multisine

import vtank as vt
from vtank.diagnose.whole.model import blank, own_unknowns
from vtank.diagnose.whole.settling import settled
from vtank.experiment import fly_vehicle
from vtank.rigid import noise
from vtank.rigid.fit import Fit, log_likelihood
from vtank.rigid.recordings import record

COLUMN, MEMORY_S, SIZE_RAD_S, DURATION_S = "imu.yaw_rate_rad_s", 0.2, 0.02, 40.0


def coloured(run: vt.Run) -> vt.Run:
    values, random = run.columns[COLUMN].copy(), np.random.default_rng(5)
    read = np.flatnonzero(np.isfinite(values))
    keep = np.exp(-float(np.median(np.diff(run.time_s[read]))) / MEMORY_S)
    error = 0.0
    for k, z in zip(read, random.standard_normal(read.size), strict=True):
        error = keep * error + np.sqrt(1.0 - keep**2) * SIZE_RAD_S * z
        values[k] += error
    return replace(run, columns={**run.columns, COLUMN: values})


def test_sought_from_white_errors_as_well(monkeypatch: pytest.MonkeyPatch) -> None:
    vehicle = vt.load_vehicle("bluerov2")
    flights = [
        fly_vehicle(vehicle, multisine(vehicle, DURATION_S, seed), DURATION_S, seed, depth_m=5.0) for seed in (1, 2)
    ]
    layout, runs, _ = record([coloured(flight) for flight in flights], vehicle)
    begin = noise.first_noise(runs)
    model = blank(Fit(tuple(runs), begin), layout, (), own_unknowns(layout, runs[0].moves))

    def likelihood() -> float:
        return sum(map(log_likelihood, settled(model, begin.variance)[1]))

    fitted, found = settled(model, begin.variance)
    here, c = fitted.fit.noise, layout.columns.index(COLUMN)
    assert here.slow[c] == pytest.approx(SIZE_RAD_S, rel=0.3) and 0.1 <= here.slow_s[c] <= 0.5
    monkeypatch.setattr(noise, "_all_white", lambda fit, p: fit.noise)
    assert sum(map(log_likelihood, found)) > likelihood() + 20.0
