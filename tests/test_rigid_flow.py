"""Forces of the flow beyond drag along each axis, and thrusters' curves set free."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_rigid_motion import flown

import vtank as vt
from vtank.diagnose.whole import plant_fit
from vtank.diagnose.whole.curves import KNOTS, Bend, corrected
from vtank.diagnose.whole.flow_fit import bounded, centred, termwise
from vtank.diagnose.whole.model import blank
from vtank.diagnose.whole.own import own_unknowns
from vtank.diagnose.whole.score import based
from vtank.diagnose.whole.simulator import shared, usual
from vtank.rigid.fit import Fit
from vtank.rigid.flow import CREEP, FACTORS, OBLIQUE, ONE, SHARP, SLENDER, STILL, Flow, V, W, pushed, terms, values
from vtank.rigid.layout import masses
from vtank.rigid.noise import first_noise
from vtank.rigid.recorded import relaid
from vtank.rigid.recordings import record

PLANAR = (0, 1, 5)


def wrench(nu, flow: Flow):
    """Of the water at a velocity, 6 numbers."""
    return pushed(tuple(nu), flow, np.empty(FACTORS))


@pytest.fixture
def flow() -> Flow:
    """Every planar term at a size of its own."""
    found = terms(PLANAR)
    sizes = np.random.default_rng(1).normal(size=(6, found.shape[0]))
    usual, most = np.array([0.5, 0.5, 1.0, 1.0, 1.0, 0.2]), np.array([2.0, 2.0, 0.0, 0.0, 0.0, 3.0])
    return Flow(found, sizes, usual, most, np.array([1.0, 4.0, 1.0]), np.array([-0.1, 0.05, 0.02]))


def test_no_flow_pushes_nothing():
    assert wrench((1.0, -2.0, 0.3, 0.1, 0.2, -0.5), STILL) == (0.0,) * 6


def test_the_wrench_is_the_sum_of_its_terms(flow):
    nu = np.random.default_rng(2).normal(size=(20, 6))
    along = np.empty((20, flow.terms.shape[0]))
    values(nu, flow, along)
    np.testing.assert_allclose([wrench(v, flow) for v in nu], along @ flow.sizes.T, rtol=1e-12)


def test_forces_along_an_axis_are_as_many_times_as_large(flow):
    nu, factors = (0.3, -0.2, 0.0, 0.0, 0.0, 0.1), np.array([1.1, 0.5, 1.0, 1.0, 1.0, 2.0])
    np.testing.assert_allclose(wrench(nu, flow.times(factors)), factors * wrench(nu, flow), rtol=1e-12)
    assert STILL.times(factors) is STILL


def test_what_the_water_does_beyond_drag_is_off_as_drag_is():
    run = flown("bluerov2", 10.0)
    found = terms(PLANAR)
    sizes = np.zeros((6, found.shape[0]))
    sizes[1] = np.random.default_rng(1).normal(size=found.shape[0])
    flow = Flow(found, sizes, np.full(6, 0.5), np.full(6, 3.0), np.ones(3), np.zeros(3))
    layout, seen = relaid(run.layout, (run,), flow=flow)
    (unknown,) = (u for u in own_unknowns(layout, seen) if u.name.startswith("flow@"))
    assert unknown.name == "flow@sway"
    fit = Fit(seen, first_noise(seen))
    p, more, there = layout.null, layout.null.copy(), fit.filter(layout.null)
    more[unknown.slots] += 0.01
    sides = fit.residuals([p, more], there)
    exact, linear = sides[:, 1] - sides[:, 0], fit.answers(fit.paths(p, there), [more])[:, 0]
    np.testing.assert_allclose(linear, exact, atol=0.05 * np.abs(exact).max())
    np.testing.assert_allclose(seen[0].hull(more).flow.sizes[1], 1.01 * sizes[1])


def test_terms_are_what_they_say(flow):
    along = np.empty((1, flow.terms.shape[0]))
    values(np.array([[0.3 + 0.1 * 0.05, -0.2 + 0.1 * 0.1, 9.0, 0.0, 0.0, 0.1]]), flow, along)  # at its centre
    u, v, speed = 0.6, -0.4, np.hypot(0.6, 0.4) + CREEP
    told = {tuple(term): value for term, value in zip(flow.terms.tolist(), along[0], strict=True)}
    assert told[OBLIQUE, 0, 0, 1] == pytest.approx(u * u * v / speed)
    assert told[V, 5, ONE, ONE] == pytest.approx(speed * 0.5)
    assert told[W, 5, ONE, ONE] == pytest.approx(0.5 * 0.5)
    slowly = np.hypot(u, 4.0 * v) + CREEP
    assert told[SLENDER, 0, 0, 1] == pytest.approx(u * u * v / slowly)
    assert told[SHARP, 0, 1, 1] == pytest.approx(speed * u * v * v / slowly**2)


def test_moving_the_centre_of_a_hull_does_what_its_slope_says(flow):
    """A hull ahead of the origin meets the water with what turning adds to the sway; to first order, in a plane."""
    run = flown("kingfisher", 20.0)
    layout, (seen,) = relaid(run.layout, (run,), flow=flow.sized(0.3 * flow.sizes).about(np.zeros(3)))
    fit, p = Fit((seen,), first_noise([run])), layout.null
    found = fit.filter(p)
    _, (moved,) = relaid(layout, (seen,), flow=layout.flow.about(np.array([0.002, 0.0, 0.0])))
    exact = (replace(fit, runs=(moved,)).residuals([p], found) - fit.residuals([p], found))[:, 0]
    slope = centred(based(blank(fit, layout, (), own_unknowns(layout, [seen])), found), layout.flow)
    assert np.linalg.norm(0.002 * slope[:, 0] - exact) < 0.1 * np.linalg.norm(exact)  # terms have kinks
    assert np.linalg.norm(slope[:, 1]) > 0.1 * np.linalg.norm(slope[:, 0])  # and to the side by what turns ahead


def test_a_term_of_the_flow_does_what_its_slope_says():
    """To first order, and as a force amid each step."""
    run = flown("kingfisher", 20.0)
    did, noise = usual(run.layout, (run,), first_noise([run]))
    layout, seen = relaid(run.layout, (run,), flow=did.flow)
    fit, p, asked = Fit(seen, noise), layout.null, np.array([0, 1, 5])
    found = fit.filter(p)
    slope, unit = termwise(based(blank(fit, layout, (), own_unknowns(layout, seen)), found), did, asked, layout.flow)
    count = layout.flow.terms.shape[0]
    for n in (0, 33, count, count + 11, 2 * count + 11, 3 * count - 63):  # of each axis, by what moves much
        sizes = np.zeros((6, count))
        sizes[asked[n // count], n % count] = 1e-3 * unit[n]
        _, moved = relaid(layout, seen, flow=layout.flow.sized(sizes))
        exact = (replace(fit, runs=moved).residuals([p], found) - fit.residuals([p], found))[:, 0]
        assert np.linalg.norm(1e-3 * slope[:, n] - exact) < 0.35 * np.linalg.norm(exact)


def test_the_least_within_bounds_has_no_slope_but_against_them():
    """Karush, Kuhn and Tucker's conditions, where some numbers have bounds and others none."""
    random = np.random.default_rng(3)
    K, high = random.normal(size=(200, 12)), np.full(4, 0.05)
    H, b = K.T @ K + np.eye(12), 5.0 * K.T @ random.normal(size=200)
    x = bounded(H, b, -high, high)
    slope, held = H @ x - b, np.r_[np.abs(x[:4]) >= high, np.zeros(8, bool)]
    assert held.any(), "the bounds matter"
    np.testing.assert_allclose(slope[~held], 0.0, atol=1e-9)
    assert np.all(slope[held] * x[held] < 0.0)


def test_beyond_what_is_known_a_term_stays_as_it_is(flow):
    np.testing.assert_array_equal(
        wrench((1.0, 0.0, 0.0, 0.0, 0.0, 0.0), flow), wrench((7.0, 0.0, 0.0, 0.0, 0.0, 0.0), flow)
    )


def test_a_corrected_curve_goes_through_its_corrections():
    vehicle = vt.load_vehicle("kingfisher")
    knots = tuple(n for n in range(-KNOTS, KNOTS + 1) if n)
    sizes = {Bend(("port",), 0.1, knots, n): 0.3 * n for n in knots}
    port, starboard = corrected(vehicle, sizes).thrusters
    asked = 0.1 * np.array([-8.0, -3.0, 0.0, 1.0, 5.0, 8.0])
    np.testing.assert_allclose(port.force_N(asked), vehicle.thrusters[0].force_N(asked) + 3.0 * asked, atol=1e-6)
    assert port.force_N(np.array([1.6])) == pytest.approx(vehicle.thrusters[0].force_N(np.array([1.6])) + 2.4)
    assert starboard == vehicle.thrusters[1]


def test_a_delay_shorter_than_a_step_takes_no_more_than_itself():
    """An input that begins with the run is felt from its delay on, within the first step."""
    time = 0.1 * np.arange(100.0)
    still = {"surge_m_s": np.zeros(100), "yaw_rate_rad_s": np.zeros(100)}
    run = vt.Run("begun", time, {"port_command": np.full(100, 0.5), "starboard_command": np.full(100, 0.5)} | still)
    layout, (seen,), _ = record([run], vt.load_vehicle("kingfisher"), ("surge", "yaw"))

    def impulse(delay_s: float) -> float:
        delayed = {f"delay@{name}": delay_s for name in ("port", "starboard")}
        p = layout.vector(delayed | {f"lag@{name}": 0.0 for name in ("port", "starboard")})
        return float(seen.steps.length @ seen.drive(p).thrust[:, 0])

    force = impulse(0.0) / 9.9
    assert impulse(0.0) - impulse(0.03) == pytest.approx(0.03 * force)
    assert impulse(0.0) - impulse(0.15) == pytest.approx(0.15 * force)


def test_what_is_lent_of_a_hull_is_still_the_hulls():
    """Counted in the numbers of the water's mass, it moves with the centre of gravity and is no Coriolis of water."""
    layout = flown("bluerov2", 2.0).layout
    lent = layout.vector(shared(layout))
    every = np.ones(6, bool)
    for theirs, ours in zip(masses(lent, every), masses(layout.null, every), strict=True):
        np.testing.assert_allclose(theirs, ours, rtol=1e-12, atol=1e-12)
    assert lent[0] < 0.5 * layout.null[0]
    more = lent.copy()
    more[layout.slot("lent@hull")] += 0.5
    body, water, inverse = masses(more, every)
    assert body[0, 0] == pytest.approx(layout.null[0] + 0.5)
    assert (body + water)[0, 0] == pytest.approx(layout.null[0] + layout.null[layout.slot("added_mass@surge")])


@pytest.mark.parametrize(
    ("evidence", "kept"),
    [
        ((1.0, 5.0, 4.0, 4.5), 5.0),  # neither at a part of the disturbance nor at all of it
        ((3.0, 2.0, 9.0, 8.0, 7.0), 9.0),  # at all of it alone
        ((1.0, 3.0, 7.0, 7.5, 7.9), 7.0),  # by too little
        ((1.0, 3.0, 5.0, 7.0, 9.0, 11.0, 13.0), 11.0),  # no more turns than that
    ],
)
def test_a_plant_is_kept_when_another_turn_makes_it_less_likely(monkeypatch, evidence, kept):
    """A step of the flow at a noise may lead to where both together are hundreds of log-likelihoods worse."""
    made = iter(evidence)
    monkeypatch.setattr(plant_fit, "turned", lambda *_: SimpleNamespace(log_evidence=next(made)))
    assert plant_fit.fitted(SimpleNamespace(model=None)).log_evidence == kept


def test_a_flow_is_sought_at_less_than_the_disturbance_that_hides_it(monkeypatch):
    """And what that disturbance stood for is found anew beside the flow."""
    sought = []

    def flowing(model, did):
        sought.append(model.fit.noise.sigma.copy())
        return model

    seen = flown("kingfisher")
    noise = replace(first_noise((seen,)), sigma=np.array([0.1, 0.2, 0.0, 0.0, 0.0, 0.3]))
    model = blank(Fit((seen,), noise), seen.layout, (), [])
    monkeypatch.setattr(plant_fit, "flowing", flowing)
    found = plant_fit.turned(model, plant_fit.Begun(model, None, []), plant_fit.QUIET)
    np.testing.assert_allclose(sought[0], plant_fit.QUIET * noise.sigma)
    assert found.fit.noise.sigma is not sought[0]
