"""The verdict on simulated data whose cause is known: no gap, parameters, single effects, and one left out."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from vtank.diagnose.diagnosis import SCHEMA, diagnose
from vtank.diagnose.evidence import largest_input
from vtank.diagnose.prior import calibration
from vtank.diagnose.score import linearise
from vtank.effects.catalogue import CATALOGUE
from vtank.estimate.observed import observe
from vtank.experiment import simulate_surge
from vtank.experiment.plan import plan_run
from vtank.experiment.scenario import load_scenario
from vtank.plant.parameters import vector
from vtank.plant.truth import load_truth

NOMINAL = load_truth("paper-ii").vector()
SCENARIOS = ("paper-ds1", "paper-ds2", "paper-ds3", "paper-ds4")
OTHER = {"alpha": -2.1, "beta": 5.2e-4, "thrust_lag.tau": 0.8}  # the true vehicle where it is not the nominal


def flown(values=None, seed=7, settings=(), each=({}, {}, {}, {})):
    """The four experiments with parameters and effects of their own, and of each run's, as the diagnosis sees them."""
    plans = [plan_run(load_scenario(name, settings), run=k, seed=seed) for k, name in enumerate(SCENARIOS)]
    plans = [replace(plan, p=vector((values or {}) | own, plan.p)) for plan, own in zip(plans, each, strict=True)]
    return [observe(result.run) for result in simulate_surge(plans)]


@pytest.mark.parametrize(("turbulence_m_s2", "least"), [(0.001, 0.8), pytest.param(0.002, 0.6, marks=pytest.mark.slow)])
def test_no_gap(turbulence_m_s2, least):
    """The rest is for causes without a name; water twice as restless as still water speaks for one."""
    settings = [f"turbulence.acceleration_m_s2={turbulence_m_s2}", "turbulence.time_s=2.0"]
    found = diagnose(flown(settings=settings), NOMINAL)
    assert found.verdict.kind == "none"
    assert found.probabilities["none"] > least
    assert all(not free.components for free in found.selection.free)


@pytest.mark.slow
def test_a_limit_close_to_full_speed_is_found():
    """Where the propeller often runs at full speed, a limit at 0.97 of it costs thrust in many samples."""
    limit = 0.97 * largest_input(flown())
    found = diagnose(flown({**OTHER, "thrust_saturation.n_max": limit}), NOMINAL)
    assert found.verdict.effects == ("thrust_saturation",)
    assert found.verdict.fit.values["thrust_saturation.n_max"] == pytest.approx(limit, rel=0.01)


def test_parameters_only():
    found = diagnose(flown(OTHER), NOMINAL)
    assert found.verdict.kind == "parameters" and found.probabilities["none"] < 0.005
    odds = found.probabilities["unknown"] / found.probabilities["parameters"]  # of a cause that a refit takes up whole
    assert odds == pytest.approx(calibration().mimicry, rel=0.02)
    for name, value in OTHER.items():
        assert found.verdict.fit.values[name] == pytest.approx(value, rel=0.03)


@pytest.mark.parametrize(
    ("slot", "value"),
    [
        ("linear_drag.c", 0.08),
        ("ambient_current.U", 0.02),
        ("thrust_deadband.n0", 1.5),
        ("supply_sag.r", 0.002),
        ("clock_skew.s", 0.003),
    ],
)
@pytest.mark.slow
def test_a_single_effect_is_named_and_measured(slot, value):
    name, parameter = slot.split(".")
    found = diagnose(flown({**OTHER, slot: value}), NOMINAL)
    assert found.verdict.kind == "effect" and found.verdict.effects == (name,)
    estimate = found.summary()["estimates"][name][parameter]
    low, high = estimate["interval95"]
    assert estimate["value"] == pytest.approx(value, rel=0.15)
    assert low - 0.5 * (high - low) < value < high + 0.5 * (high - low)


@pytest.mark.slow
def test_a_cable_need_not_hang_straight_where_a_run_begins():
    """One that is made fast in the tank: a force of each run's own, which nothing else explains."""
    k, rest_m = 0.004, (0.4, -0.3, 0.7, -0.6)
    found = diagnose(flown({**OTHER, "tether.k": k}, each=[{"tether.rest": m} for m in rest_m]), NOMINAL)
    assert found.verdict.effects == ("tether",)
    fit = found.verdict.fit
    assert fit.values["tether.k"] == pytest.approx(k, rel=0.1)
    assert fit.start()["tether.rest"] == pytest.approx(rest_m, abs=0.1)


@pytest.mark.slow
def test_multipath_is_told_by_its_lone_ranges_on_a_coarse_sonar():
    found = diagnose(flown({"sonar_multipath.p": 0.03, "sonar_multipath.extra": 0.3}), NOMINAL)
    assert found.verdict.effects == ("sonar_multipath",)
    assert found.verdict.fit.extra["sonar_multipath.p"] == pytest.approx(0.03, abs=0.01)
    assert found.verdict.fit.extra["sonar_multipath.extra"] == pytest.approx(0.3, abs=0.02)


@pytest.mark.slow
def test_an_effect_left_out_of_the_catalogue_is_not_given_a_wrong_name_with_certainty():
    names = [effect.name for effect in CATALOGUE if effect.name != "seiche"]
    wave = {"seiche.amplitude": 0.015, "seiche.frequency": 0.9}
    found = diagnose(flown({**OTHER, **wave}), NOMINAL, names=names)
    assert found.verdict.kind in ("unknown", "undecided", "parameters", "none")
    assert "seiche" not in found.probabilities


def test_document_keeps_the_contract():
    found = diagnose(flown(OTHER), NOMINAL)
    document = found.summary()
    assert document["schema"] == SCHEMA
    assert set(document["verdict"]) == {"kind", "effects", "class", "varying", "doubt", "channel", "probability"}
    assert math.isclose(sum(document["probabilities"].values()), 1.0, rel_tol=1e-9)
    assert {"none", "parameters", "unknown", "linear_drag"} <= set(document["probabilities"])
    assert document["absorbed"] == ["sonar_scale", "sonar_offset"]
    assert ["command_delay", "sonar_latency"] in [sorted(pair) for pair in document["tied"]]
    for stated in document["baselines"].values():
        assert math.isclose(sum(stated.values()), 1.0, rel_tol=1e-9)
    assert max(document["baselines"]["BIC"], key=document["baselines"]["BIC"].get) == "parameters"


@pytest.mark.slow
def test_functions_that_the_parameters_take_up_explain_nothing_more():
    near = linearise(diagnose(flown(OTHER), NOMINAL).selection.refit)
    rest = near.remaining(near.jacobian)
    assert np.linalg.norm(rest, axis=0) == pytest.approx(0.0, abs=1e-3 * np.linalg.norm(near.jacobian, axis=0).max())
    stiff = near.jacobian @ np.random.default_rng(3).standard_normal((near.jacobian.shape[1], 4))
    assert abs(near.explain(stiff)[0]) < 0.1
