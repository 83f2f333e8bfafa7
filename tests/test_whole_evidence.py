"""Free-form groups by pursuit, and how far the numbers of a vehicle file are trusted: against what was put in."""

from __future__ import annotations

import importlib
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import vtank as vt
from vtank.diagnose.freeform.functions import functions_of
from vtank.diagnose.whole.diagnosis import coarse
from vtank.diagnose.whole.model import Model
from vtank.diagnose.whole.own import Unknown
from vtank.diagnose.whole.pursuit import SIZES, evidence, pursue
from vtank.diagnose.whole.trust import CLEARLY, WIDTHS, trusted
from vtank.experiment import fly_vehicle


def grams(cause: float, seed: int = 3) -> tuple[np.ndarray, list[slice]]:
    """Innovations of unit deviation that follow a function of the third of five variables, and columns of all."""
    rng, rows = np.random.default_rng(seed), 2000
    variables = rng.uniform(size=(5, rows))
    blocks = [30.0 / np.sqrt(rows) * functions_of(v) for v in variables]
    e = rng.normal(size=rows) + cause * 30.0 / np.sqrt(rows) * np.sin(5.0 * variables[2])
    columns = np.column_stack([e, *blocks])
    width = blocks[0].shape[1]
    return columns.T @ columns, [slice(1 + width * n, 1 + width * (n + 1)) for n in range(5)]


def test_a_function_is_found_where_it_was_put_in():
    gram, groups = grams(0.5)
    gain, seen, chosen, coefficients = pursue(gram, groups)
    assert chosen[0] == 2 and seen > gain > 10.0
    left = gram[0, 0] + 2.0 * coefficients @ gram[1:, 0] + coefficients @ gram[1:, 1:] @ coefficients
    assert seen == pytest.approx(0.5 * (gram[0, 0] - left))
    assert np.abs(coefficients[groups[2].start - 1 : groups[2].stop - 1]).max() > 0.1
    assert len(chosen) == 1 or np.abs(coefficients[groups[0].start - 1 : groups[0].stop - 1]).max() < 0.1


@pytest.mark.parametrize("seed", range(5))
def test_noise_gains_nothing(seed):
    gram, groups = grams(0.0, seed)
    assert pursue(gram, groups)[0] < 0.0


def test_the_evidence_is_that_of_the_marginal_density():
    """At one size against the normal density of innovations whose covariance the group adds to."""
    rng = np.random.default_rng(5)
    e, A = rng.normal(size=40), rng.normal(size=(40, 3))
    columns = np.column_stack([e, A])

    def density(S: np.ndarray) -> float:
        return -0.5 * float(e @ np.linalg.solve(S, e)) - 0.5 * float(np.linalg.slogdet(S)[1])

    exact = [density(np.eye(40) + s**2 * A @ A.T) - density(np.eye(40)) for s in SIZES]
    gain, size = evidence(columns.T @ columns, slice(1, 4))
    assert gain == pytest.approx(np.log(np.mean(np.exp(exact))), abs=1e-9)
    assert size == SIZES[int(np.argmax(exact))]


def own(count: int) -> list[Unknown]:
    return [Unknown(f"drag@{n}", np.array([n]), np.ones(1), 0.3, -0.9, 20.0, 1e-3) for n in range(count)]


@pytest.mark.parametrize(("off", "width"), [(0.0, WIDTHS[-1]), (0.3, WIDTHS[0]), (0.03, 0.1)])
def test_the_priors_of_own_parameters_are_as_wide_as_the_file_is_wrong(off, width):
    """Twenty numbers measured to 1e-4 that are off by `off` of themselves, either way."""
    unknowns = own(20)
    data = np.eye(20) / 1e-4**2
    prior = np.diag(np.full(20, 0.3**-2.0))
    told = off * np.where(np.arange(20) % 2, 1.0, -1.0) + 1e-4 * np.random.default_rng(1).normal(size=20)
    theta = np.linalg.solve(data + prior, data @ told)
    model = Model(None, (), tuple(unknowns), theta, np.zeros(20), information=data + prior)  # type: ignore[arg-type]
    assert trusted(model, unknowns)[0].scale == pytest.approx(0.3 * width)


def fitted_to(unknowns: list[Unknown], off: np.ndarray, sd: float) -> Model:
    """A model whose own parameters are measured to `sd`, and are off by `off`, (U,)."""
    data, prior = np.eye(off.size) / sd**2, np.diag([u.scale**-2.0 for u in unknowns])
    theta = np.linalg.solve(data + prior, data @ off)
    return Model(None, (), tuple(unknowns), theta, np.zeros(off.size), information=data + prior)  # type: ignore[arg-type]


def test_masses_are_not_trusted_for_what_drags_are():
    """Ten masses within 1 % of the file, ten drags 20 % off it."""
    unknowns = [replace(u, name=f"{('added_mass', 'quadratic_drag')[n // 10]}@{n}") for n, u in enumerate(own(20))]
    signs = np.where(np.arange(20) % 2, 1.0, -1.0)
    found = trusted(fitted_to(unknowns, signs * np.repeat([0.01, 0.2], 10), 1e-3), unknowns)
    masses, drags = (np.array([u.scale for u in some]) for some in (found[:10], found[10:]))
    assert 0.008 < masses.min() == masses.max() < 0.031 and 0.08 < drags.min() == drags.max()


def test_one_number_that_agrees_is_not_taken_for_exact():
    """Measured to 4 %, and where the file has it: its interval stays that of the data."""
    (alone,) = trusted(fitted_to(own(1), np.zeros(1), 0.04), own(1))
    assert alone.scale > 0.08


def test_widths_together_are_not_clearly_less_likely():
    """Four kinds of one number each, where the file has them: all of them wide would cost more than any alone."""
    unknowns = [replace(u, name=f"{kind}@0") for u, kind in zip(own(4), ("gain", "lag", "lift", "drag"), strict=True)]
    found = trusted(fitted_to(unknowns, np.zeros(4), 0.1), unknowns)
    scale = np.array([u.scale for u in found])
    cost = 0.5 * np.sum(np.log1p((scale / 0.1) ** 2))  # log evidence below that of priors of no width
    assert cost < CLEARLY + 0.01 and scale.max() == 0.3


@pytest.mark.slow
def test_an_error_of_a_compass_is_no_smaller_for_the_turns_that_were_made():
    """Deviation by soft iron, of a tenth of a radian, in a recording of several turns."""
    time = np.arange(0.0, 100.0, 5.0)
    port = 0.5 + 0.4 * np.sin(0.3 * time)
    run = fly_vehicle(
        "kingfisher", {"time_s": time, "port_command": port, "starboard_command": 0.1 + 0.0 * time}, 100.0, 2
    )
    heading = run.columns["compass.heading_rad"]
    assert np.ptp(np.unwrap(heading[np.isfinite(heading)])) > 4.0 * np.pi
    off = run.columns | {"compass.heading_rad": heading + 0.12 * np.sin(2.0 * heading)}
    few = ("magnetometer_bias", "gyro_bias", "sensor_latency")
    verdict = vt.diagnose([replace(run, columns=off)], nominal="kingfisher", effects=few).verdict
    assert (verdict.kind, verdict.places) == ("unknown", ("compass",))


def test_of_a_short_run_one_half_is_left_out_and_the_other_tells():
    """With one part alone nothing was left to tell of an effect, which passed for too small to be seen."""
    budget = importlib.import_module("vtank.diagnose.whole.budget")
    for span_s, many in ((18.0, 2), (20.0, 2), (60.0, 4)):
        parts = budget._stretches(np.linspace(0.0, span_s, 500))
        assert set(parts) == set(range(many)) and np.all(np.diff(parts) >= 0)


def test_a_run_without_a_column_adds_nothing_to_the_functions_of_it():
    """Of two runs one lacks the column: its functions have no rows there, its windows are of the other run alone."""
    unnamed = importlib.import_module("vtank.diagnose.whole.unnamed")
    times = [np.linspace(0.0, 9.0, 40), np.empty(0)]
    values = {"reading": [np.sin(times[0]), np.empty(0)], "speed": [np.cos(times[0]), np.empty(0)]}
    groups = unnamed._groups(values, [("reading", "speed")], times)
    first, lacking = groups.made(0), groups.made(1)
    assert len(first) == len(lacking) == len(groups.names) + len(times)
    assert first[-2].sum(axis=1).tolist() == [1.0] * 40 and not first[-1].any()
    assert [part.shape[1] for part in first] == [part.shape[1] for part in lacking]
    assert all(part.shape[0] == 0 for part in lacking)


@pytest.mark.parametrize(("step", "notes"), [(0.0, 0), (0.002, 0), (0.02, 1), (0.2, 1)])
def test_steps_as_large_as_the_noise_are_told_of(step: float, notes: int) -> None:
    """Of a speed to 0.5 m/s with noise of 10 mm/s; what is noiseless and has six decimals comes in no steps."""
    time_s = np.arange(0.0, 100.0, 0.1)
    speed = 0.5 * np.sin(0.3 * time_s) + 0.01 * np.random.default_rng(1).normal(size=time_s.size)
    read = np.round(speed / step) * step if step else speed
    columns = {"surge_m_s": read, "sway_m_s": np.round(0.5 * np.cos(0.3 * time_s), 6)}
    said = coarse([vt.Run("one", time_s, columns)], SimpleNamespace(columns=("surge_m_s", "sway_m_s", "heave_m_s")))
    assert len(said) == notes and all(f"surge_m_s comes in steps of {step:g}," in note for note in said)
