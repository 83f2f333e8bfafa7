"""The three-state Kalman filter of the sonar range (position, velocity, acceleration), as in the paper's section IV.

State s = (position, velocity, acceleration) of whatever is measured, driven by white jerk of spectral density q:

    s_{k+1} = F(T) s_k + w_k,    cov w_k = q J(T)        measured = position + v_k,    var v_k = r

Only q / r enters the gain, so the filter may be applied to a range in metres or feet, or, as the paper does, to the
propeller speed (its position channel). A missed ping is NaN: the filter predicts and goes on.

A range to the wall ahead falls when the vehicle moves ahead, so the surge speed is u = -(velocity channel).

The paper gives r = 0.01 (ft^2, "the same value used by the sonar filter") and neither q nor the ping period.
"""

from __future__ import annotations

import numpy as np
from filterpy.kalman import KalmanFilter
from numpy.typing import NDArray

from ...compiled import law
from ...experiment.sonar_filter import filter_step, steady_state, transition, white_jerk

Array = NDArray[np.float64]


def sonar_filter(measured: Array, period_s: float, q: float, r: float) -> Array:
    """Filter a record, shape (T,), NaN where no sample came; returns position, velocity, acceleration, shape (T, 3).

    Row k uses the samples up to and including k. The filter starts at rest on the first sample with the steady-state
    covariance, so its gain is the steady one until a sample is missed; rows before the first sample are NaN.
    """
    measured = np.asarray(measured, dtype=float)
    estimate = np.full((measured.size, 3), np.nan)
    if not np.isfinite(measured).any():
        return estimate
    first = int(np.argmax(np.isfinite(measured)))
    kalman = KalmanFilter(dim_x=3, dim_z=1)
    kalman.x = np.array([[measured[first]], [0.0], [0.0]])
    kalman.P = steady_state(period_s, q, r)[1]
    kalman.F, kalman.Q = transition(period_s), q * white_jerk(period_s)
    kalman.H, kalman.R = np.array([[1.0, 0.0, 0.0]]), np.array([[r]])
    estimate[first] = kalman.x[:, 0]
    for k in range(first + 1, measured.size):
        kalman.predict()
        kalman.update(None if np.isnan(measured[k]) else measured[k])
        estimate[k] = kalman.x[:, 0]
    return estimate


@law
def _filter_record(measured, state, covariance, period_s, q, r):  # type: ignore[no-untyped-def]
    estimate = np.empty((measured.size, 3))
    estimate[0] = state
    for k in range(1, measured.size):
        filter_step(state, covariance, measured[k], period_s, q, r)
        estimate[k] = state
    return estimate


def sonar_filter_compiled(measured: Array, period_s: float, q: float, r: float) -> Array:
    """`sonar_filter` by the pilot's compiled step, for Monte Carlo studies; equal to it within rounding."""
    measured = np.asarray(measured, dtype=float)
    estimate = np.full((measured.size, 3), np.nan)
    if not np.isfinite(measured).any():
        return estimate
    first = int(np.argmax(np.isfinite(measured)))
    start = np.array([measured[first], 0.0, 0.0])
    covariance = steady_state(period_s, q, r)[1]
    estimate[first:] = _filter_record(measured[first:], start, covariance, float(period_s), float(q), float(r))
    return estimate
