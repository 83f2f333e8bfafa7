"""The surge equation against closed forms, an independent integrator, and its own claims about effects."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from synthetic import advance

from vtank.effects import sonar_multipath, tachometer_spikes
from vtank.effects.catalogue import BY_NAME, CATALOGUE
from vtank.estimate.innovations import Noise, innovations, no_gain
from vtank.estimate.observed import Observed
from vtank.plant.parameters import slot, vector
from vtank.plant.surge import surge_acceleration, thrust_now, thrust_rate, thrust_target, wake_rate

ALPHA, BETA, GAMMA, TAU = -2.5, 5e-4, -0.01, 0.7
PLAIN = {"alpha": ALPHA, "beta": BETA, "thrust_loss.gamma": GAMMA, "thrust_lag.tau": TAU}


def run(p, n, h=0.1, state=(0.0, 0.0, 0.0, 0.0), disturbance=None, start=0.0):
    """States (x, u, z, wake) at the ends of the steps, the first one before them, shape (K + 1, 4)."""
    states = [state]
    for k, speed in enumerate(np.asarray(n, dtype=float)):
        push = 0.0 if disturbance is None else disturbance[k]
        states.append(advance(start + k * h, h, *states[-1], speed, push, p))
    return np.array(states)


# --- closed forms ----------------------------------------------------------------------------------------------------


def test_free_decay():
    u0, t = 0.8, 0.05 * np.arange(1201)
    states = run(vector({"alpha": ALPHA}), np.zeros(1200), 0.05, state=(0.0, u0, 0.0, 0.0))
    np.testing.assert_allclose(states[:, 1], u0 / (1 - ALPHA * u0 * t), rtol=1e-6)
    np.testing.assert_allclose(states[:, 0], np.log(1 - ALPHA * u0 * t) / -ALPHA, atol=1e-6)


@pytest.mark.parametrize("n", [15.0, -15.0])
def test_rise_to_the_terminal_speed(n):
    terminal, t = math.sqrt(BETA / -ALPHA) * n, 0.1 * np.arange(601)
    states = run(vector({"alpha": ALPHA, "beta": BETA}), np.full(600, n))
    np.testing.assert_allclose(states[:, 1], terminal * np.tanh(math.sqrt(-ALPHA * BETA) * abs(n) * t), atol=2e-6)
    assert states[-1, 1] == pytest.approx(terminal, rel=1e-9)


def test_thrust_loss_lowers_the_terminal_speed_to_the_root_of_a_quadratic():
    n = 15.0
    states = run(vector({"alpha": ALPHA, "beta": BETA, "thrust_loss.gamma": GAMMA}), np.full(900, n))
    assert states[-1, 1] == pytest.approx(np.roots([ALPHA, GAMMA * n, BETA * n * n]).max(), rel=1e-9)


def test_step_response_of_the_lag():
    n, t = 12.0, 0.1 * np.arange(101)
    target = BETA * n * n
    states = run(vector({"beta": BETA, "thrust_lag.tau": TAU}), np.full(100, n))
    settled = 1 - np.exp(-t / TAU)
    np.testing.assert_allclose(states[:, 2], target * settled, rtol=1e-12)
    np.testing.assert_allclose(states[:, 1], target * (t - TAU * settled), atol=1e-7)
    np.testing.assert_allclose(states[:, 0], target * (t**2 / 2 - TAU * t + TAU**2 * settled), atol=1e-6)


def test_without_lag_the_thrust_acts_at_once():
    p = vector({"beta": BETA})
    target = thrust_target(0.0, -12.0, p)
    assert target == -BETA * 144.0 and thrust_now(99.0, target, p) == target and thrust_rate(99.0, target, p) == 0.0


def test_linear_drag_and_dry_friction_and_tether():
    t = 0.1 * np.arange(101)
    slowed = run(vector({"linear_drag.c": 0.4}), np.zeros(100), state=(0.0, 0.5, 0.0, 0.0))
    np.testing.assert_allclose(slowed[:, 1], 0.5 * np.exp(-0.4 * t), rtol=1e-6)
    rubbed = run(vector({"coulomb_friction.f": 0.02}), np.zeros(100), state=(0.0, 0.5, 0.0, 0.0))
    np.testing.assert_allclose(rubbed[:, 1], 0.5 - 0.02 * t, atol=1e-12)
    pulled = run(vector({"tether.k": 0.25}), np.zeros(100), state=(0.3, 0.0, 0.0, 0.0))
    np.testing.assert_allclose(pulled[:, 0], 0.3 * np.cos(0.5 * t), atol=1e-6)


def test_dry_friction_turns_round_with_the_motion():
    p = vector({"coulomb_friction.f": 0.02})
    force = [surge_acceleration(0.0, 0.0, u, 0.0, 0.0, 0.0, 3.0, 0.0, p) for u in (-1.0, 0.0, 1.0)]
    assert force == [0.02, 0.0, -0.02]


def test_the_hull_follows_a_seiche_and_a_current():
    wave = {"alpha": ALPHA, "seiche.amplitude": 0.05, "seiche.frequency": 0.9, "seiche.phase": 0.4}
    t = 0.1 * np.arange(301)
    carried = run(vector(wave), np.zeros(300), state=(0.0, 0.05 * math.sin(0.4), 0.0, 0.0))
    np.testing.assert_allclose(carried[:, 1], 0.05 * np.sin(0.9 * t + 0.4), atol=1e-7)
    drifting = run(vector({"linear_drag.c": 0.5, "ambient_current.U": -0.04}), np.zeros(600))
    assert drifting[-1, 1] == pytest.approx(-0.04, rel=1e-9)


def test_energy_is_kept_as_the_moving_mass_grows_towards_the_wall():
    """Kinetic energy (1 + mass g(gap)) u^2 / 2 is all there is in ideal water."""
    states = run(vector({"wall_proximity.mass": 0.4, "standoff": 3.0}), np.zeros(400), 0.01, (0.0, 0.5, 0.0, 0.0))
    growth = (3.0 / (3.0 - states[:, 0])) ** 3
    energy = (1 + 0.4 * growth) * states[:, 1] ** 2
    assert states[-1, 0] > 1.5 and states[-1, 1] < 0.3
    np.testing.assert_allclose(energy, energy[0], rtol=1e-7)


def test_a_steady_hull_drags_its_wake_along():
    p = vector({"wake_memory.k": 0.3, "wake_memory.T": 4.0})
    assert wake_rate(0.5, 0.15, p) == pytest.approx(0.0, abs=1e-15)
    assert wake_rate(0.5, 0.0, p) == pytest.approx(0.3 * 0.5 / 4.0)


def test_the_disturbance_is_an_acceleration():
    states = run(vector({}), np.zeros(10), disturbance=np.full(10, 0.3))
    assert states[-1, 1] == pytest.approx(0.3) and states[-1, 0] == pytest.approx(0.15)


# --- integrator ------------------------------------------------------------------------------------------------------

MIX = {
    **PLAIN,
    "linear_drag.c": 0.05,
    "ambient_current.U": 0.02,
    "seiche.amplitude": 0.02,
    "seiche.frequency": 0.8,
    "seiche.phase": 0.3,
    "wall_proximity.drag": 0.4,
    "wall_proximity.mass": 0.2,
    "tether.k": 0.01,
    "drag_asymmetry.e": 0.2,
    "wake_memory.k": 0.2,
    "wake_memory.T": 4.0,
    "thrust_asymmetry.e": 0.1,
    "thrust_deadband.n0": 1.0,
    "thrust_saturation.n_max": 14.0,
}


def test_order_of_convergence():
    """Fourth order in x and u while the hull keeps its direction (u|u| has a kink in its curvature at u = 0)."""
    p, state = vector(MIX), (0.0, 0.35, 0.02, 0.0)
    end = [run(p, np.full(round(4.8 / h), 12.0), h, state)[-1] for h in (0.4, 0.2, 0.1, 0.0125)]
    error = np.abs(np.array(end[:3]) - end[3])[:, [0, 1, 3]]
    order = np.log2(error[:-1] / error[1:])
    assert order.min() > 3.9


def equation(t, s, n, p):
    """The surge equation once more, written from its documentation alone."""
    x, u, z, wake = s
    amplitude, w, phase = p["seiche.amplitude"], p["seiche.frequency"], p["seiche.phase"]
    ur = u - p["ambient_current.U"] - amplitude * math.sin(w * t + phase) - wake
    ne = math.copysign(max(min(abs(n), p["thrust_saturation.n_max"]) - p["thrust_deadband.n0"], 0.0), n)
    gap = 3.048 - x
    g = (3.0 / gap) ** 3
    mass, e = p["wall_proximity.mass"], p["drag_asymmetry.e"]
    du = (
        (1 + p["wall_proximity.drag"] * g) * p["alpha"] * (1 + e * math.copysign(1, ur)) * abs(ur) * ur
        + z
        + p["thrust_loss.gamma"] * abs(ne) * ur
        - p["linear_drag.c"] * ur
        - p.get("coulomb_friction.f", 0.0) * math.tanh(u / 0.005)
        - p["tether.k"] * x
        - 1.5 * mass * g / gap * u * u
    ) / (1 + mass * g) + amplitude * w * math.cos(w * t + phase)
    thrust = p["beta"] * (1 + p["thrust_asymmetry.e"] * math.copysign(1, ne)) * ne * abs(ne)
    thrust *= math.exp(-p.get("supply_sag.r", 0.0) * t)
    return [u, du, (thrust - z) / p["thrust_lag.tau"], (p["wake_memory.k"] * u - wake) / p["wake_memory.T"]]


@pytest.mark.parametrize(
    "more", [{}, {"coulomb_friction.f": 0.01}, {"supply_sag.r": 0.004}], ids=["smooth", "dry", "sag"]
)
def test_agrees_with_an_independent_integrator(more):
    p = MIX | more
    n = 16.0 * np.cos(0.5 * np.arange(0.0, 40.0, 0.1))
    ours, state = run(vector(p), n), np.zeros(4)
    theirs = [state]
    for k, speed in enumerate(n):
        solved = solve_ivp(equation, (0.1 * k, 0.1 * (k + 1)), state, "DOP853", args=(speed, p), rtol=1e-10, atol=1e-12)
        state = solved.y[:, -1]
        theirs.append(state)
    np.testing.assert_allclose(ours, np.array(theirs), atol=2e-5 if "coulomb_friction.f" in more else 2e-6)
    assert np.ptp(ours[:, 0]) > 0.3


# --- effects at null -------------------------------------------------------------------------------------------------


def plain_acceleration(u, z, n, disturbance):
    return ALPHA * (u * abs(u)) + z + GAMMA * abs(n) * u + disturbance


def test_with_all_effects_at_null_the_law_is_the_papers_bit_for_bit():
    rng = np.random.default_rng(1)
    p = vector(PLAIN)
    for t, x, u, z, n, disturbance in rng.uniform(-1, 1, (200, 6)) * [60, 1, 1, 0.3, 20, 0.01]:
        law = surge_acceleration(t, x, u, z, 0.0, n, 3.048 - x, disturbance, p)
        assert law == plain_acceleration(u, z, n, disturbance)
        assert thrust_target(t, n, p) == BETA * (n * abs(n)) and wake_rate(u, 0.0, p) == 0.0


def recording(p, rng_seed=2):
    """Ranges of a minute of wild motion through the compiled predictor, shape (600,)."""
    t = 0.1 * np.arange(600)
    rng = np.random.default_rng(rng_seed)
    n = 14.0 * np.cos(0.6 * t) + 3.0 * np.cos(1.7 * t) + rng.normal(0.0, 0.3, t.size)
    return simulated_range(p, t, n)


def simulated_range(p, t, n):
    """Ranges at the input's own stamps, from rest, shape of t."""
    run = Observed("run", "n_rev_s", t, n, t, np.zeros(t.size), np.zeros(t.size, dtype=np.int64))
    return -innovations(run, p, np.zeros(4), Noise(), no_gain(run))


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.name)
def test_an_effect_of_no_size_changes_nothing_bit_for_bit(effect):
    """Whatever its frequencies and time constants are."""
    if effect.name in ("thrust_loss", "thrust_lag"):
        base = vector({"alpha": ALPHA, "beta": BETA})  # these two are on in the plain case
    else:
        base = vector(PLAIN)
    shapes = {f"{effect.name}.{q.name}": q.null + 0.7 * q.scale for q in effect.parameters if q.shape}
    nulls = {f"{effect.name}.{q.name}": q.null for q in effect.parameters if not q.shape}
    np.testing.assert_array_equal(recording(vector(shapes | nulls, base)), recording(base))


DRAWN = {"sonar_multipath.p", "sonar_multipath.extra", "tachometer_spikes.p", "tachometer_spikes.size"}
MOVING = [name for effect in CATALOGUE for name in effect.slots() if name not in DRAWN]


@pytest.mark.parametrize("name", MOVING)
def test_no_parameter_is_dead(name):
    effect, _, short = name.partition(".")
    sizes = {f"{effect}.{q.name}": _typical(q) for q in BY_NAME[effect].parameters}
    on = vector(sizes, vector(PLAIN))
    moved = on.copy()
    moved[slot(name)] *= 0.8
    change = np.abs(recording(moved) - recording(on)).max()
    assert change > 1e-4


def _typical(q):
    return 8.0 if q.null == math.inf else q.null + q.scale if q.null + q.scale <= q.bounds[1] else q.null - q.scale


def test_the_drawn_effects_shift_single_readings():
    assert sonar_multipath.reading(3.0, 0.1, 0.4, 0.05) == 3.4 and sonar_multipath.reading(3.0, 0.1, 0.4, 0.1) == 3.0
    readings = [tachometer_spikes.reading(10.0, 0.2, 4.0, uniform) for uniform in (0.05, 0.15, 0.25)]
    assert readings == [14.0, 6.0, 10.0]
    assert tachometer_spikes.repaired(14.0, 3.8, 4.0) == 10.0
    assert tachometer_spikes.repaired(6.0, -4.3, 4.0) == 10.0
    assert tachometer_spikes.repaired(14.0, 2.3, 4.0) == 14.0
    assert tachometer_spikes.repaired(14.0, 9.0, 4.0) == 14.0
    assert tachometer_spikes.repaired(14.0, 3.8, 0.0) == 14.0


# --- direction of every effect ---------------------------------------------------------------------------------------


def acceleration(more, u=0.1, n=10.0, x=0.5, wake=0.0, t=2.0):
    """du/dt of a hull that gathers way [m/s2], thrust settled."""
    p = vector(PLAIN | more)
    return surge_acceleration(t, x, u, thrust_target(t, n, p), wake, n, 3.048 - x, 0.0, p)


SLOWER_AHEAD = {
    "linear_drag.c": 0.1,
    "coulomb_friction.f": 0.01,
    "ambient_current.U": -0.03,
    "wall_proximity.drag": 0.3,
    "wall_proximity.mass": 0.1,
    "tether.k": 0.01,
    "drag_asymmetry.e": 0.2,
    "thrust_deadband.n0": 1.0,
    "thrust_asymmetry.e": -0.1,
    "thrust_loss.gamma": 2 * GAMMA,
    "thrust_saturation.n_max": 8.0,
    "supply_sag.r": 0.01,
}


@pytest.mark.parametrize("name", SLOWER_AHEAD)
def test_direction_ahead(name):
    assert acceleration({name: SLOWER_AHEAD[name]}) < acceleration({}) - 1e-4


@pytest.mark.parametrize("name", SLOWER_AHEAD)
def test_direction_astern(name):
    """Resistances turn round with the motion; what favours one side favours it still."""
    one_sided = {"ambient_current.U", "drag_asymmetry.e", "thrust_asymmetry.e"}
    change = acceleration({name: SLOWER_AHEAD[name]}, -0.1, -10.0, -0.5) - acceleration({}, -0.1, -10.0, -0.5)
    assert change < -1e-5 if name in one_sided else change > 1e-5


def test_a_wake_that_follows_eases_the_hull():
    assert acceleration({"wake_memory.k": 0.3}, wake=0.05) > acceleration({})


def test_sensors_and_delays_act_the_way_they_say():
    """On a hull that goes ahead faster and faster from x = 0 at t = 0: the true range falls."""
    t = 0.1 * np.arange(50)

    def ranges(more):
        return simulated_range(vector(PLAIN | more), t, np.full(50, 10.0))[5:]

    true = ranges({})
    assert np.all(np.diff(true) < 0)
    assert np.all(ranges({"thrust_lag.tau": 1.5}) > true)
    assert np.all(ranges({"sonar_scale.s": 0.01}) == pytest.approx(1.01 * true))
    assert np.all(ranges({"sonar_offset.o": 0.05}) == pytest.approx(true + 0.05))
    assert np.all(ranges({"tachometer_bias.b": 0.5}) > true)
    assert np.all(ranges({"clock_skew.s": 0.01}) < true)
