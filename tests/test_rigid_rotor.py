"""A rotor whose speed lags, and not its force."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator, interp1d

import vtank as vt
from vtank.diagnose.whole.own import own_unknowns
from vtank.experiment import fly_vehicle
from vtank.rigid import recorded
from vtank.rigid.filtered import filtered, innovations
from vtank.rigid.layout import (
    DELAY,
    DIRECTION,
    FIN,
    GAIN,
    HULL,
    LAG,
    LATE,
    PATH,
    ROTOR,
    SAG,
    SATURATION,
    SWEPT,
    THRUSTER,
    Layout,
)
from vtank.rigid.noise import first_noise
from vtank.rigid.push import pushes
from vtank.rigid.recordings import record
from vtank.rigid.steps import held, thrust_of

LAG_S, REACH, STEP_S = 0.3, 20.0, 0.1


def forces(share: float, first: int = 0, resting: bool = True, delay_s: float = 0.0) -> tuple[np.ndarray, ...]:
    """Mean and half the change of n|n| over steps of 0.1 s, of speeds held for two of them each.

    first: step with which it begins.
    """
    p = np.zeros(HULL + THRUSTER)
    own = p[HULL:]
    own[DIRECTION], own[GAIN], own[SATURATION], own[LAG], own[ROTOR], own[SAG] = 1.0, 1.0, np.inf, LAG_S, share, 0.0
    own[DELAY] = delay_s
    asked = np.linspace(-REACH, REACH, 4001)
    now = STEP_S * np.arange(200)
    stamps, speeds = now[::2].copy(), np.random.default_rng(3).uniform(-REACH, REACH, (100, 1))
    table, now = asked * np.abs(asked), now[first:]
    force, swing, _ = thrust_of(0, now, np.full(now.size, STEP_S), stamps, speeds, table, REACH, p, resting)
    return force, swing, speeds[:, 0]


def test_speed_lags_as_in_closed_form() -> None:
    force, swing, speeds = forces(1.0)
    n = 0.0
    for k, mean in enumerate(force):
        goal, begin = speeds[k // 2], n

        def thrust(t: float, goal: float = goal, begin: float = begin) -> float:
            turning = goal + (begin - goal) * np.exp(-t / LAG_S)
            return float(turning * abs(turning))

        assert mean == pytest.approx(
            quad(thrust, 0.0, STEP_S)[0] / STEP_S, abs=0.6
        )  # of 400, where a speed turns round amid a step
        assert swing[k] == pytest.approx(0.5 * (thrust(STEP_S) - thrust(0.0)), abs=0.02)
        n = goal + (begin - goal) * np.exp(-STEP_S / LAG_S)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("resting", [True, False])
@pytest.mark.parametrize("delay_s", [0.0, 0.2])
@pytest.mark.parametrize("first", [1, 5])
def test_what_was_asked_for_before_the_first_step_has_acted(share: float, resting: bool, delay_s: float, first: int):
    """An instrument that is late, or begins late, sees thrusters that have long been told where to go."""
    whole, tail = (forces(share, k, resting, delay_s) for k in (0, first))
    for every, later in zip(whole[:2], tail[:2], strict=True):
        np.testing.assert_allclose(later, every[first:], rtol=0.0, atol=1e-9)
    if first == 5 and not delay_s:
        assert abs(tail[0][0]) > 1.0  # neither nothing nor where the input of this step goes
        assert abs(tail[0][0] - tail[2][first // 2] * abs(tail[2][first // 2])) > 1.0


def test_a_share_lies_between_both() -> None:
    force, rotor, half = forces(0.0)[0], forces(1.0)[0], forces(0.5)[0]
    assert np.abs(rotor - force).max() > 10.0
    np.testing.assert_allclose(half, 0.5 * (force + rotor), atol=1e-9)


@pytest.mark.parametrize("delay_s", [-0.07, 0.0, 0.2])
@pytest.mark.parametrize("rotor", [0.0, 1.0])
@pytest.mark.parametrize(("path", "between"), [(1.0, interp1d), (2.0, PchipInterpolator)])
def test_inputs_that_go_on_a_path_to_the_next_are_many_that_are_held(path, between, rotor, delay_s) -> None:
    p, times = np.zeros(HULL + THRUSTER + FIN), 200
    stamps = 0.2 * np.arange(30) + 0.05 * np.sin(np.arange(30.0))
    own, fin = p[HULL:], p[HULL + THRUSTER :]
    own[DIRECTION], own[GAIN], own[SATURATION], own[LAG], own[ROTOR], own[DELAY] = 1.0, 1.0, np.inf, 0.3, rotor, delay_s
    fin[LATE] = delay_s
    speeds = 5.0 + 4.0 * np.sin(1.7 * stamps)[:, None]
    fine = 0.2 / times * np.arange(29 * times + 1)
    amid = between(stamps, speeds[:, 0])(np.clip(fine + 0.1 / times, stamps[0], stamps[-1]))[:, None]
    now, asked = 1.5 + 0.05 * np.arange(70), np.linspace(-REACH, REACH, 40001)
    table, length = asked * np.abs(asked), np.full(now.size, 0.05)

    def of(stamps: np.ndarray, speeds: np.ndarray, path: float) -> list[np.ndarray]:
        own[PATH] = fin[SWEPT] = path
        pushed = thrust_of(0, now, length, stamps, speeds, table, REACH, p, False)
        return [*pushed, held(now, length, stamps, speeds, p, HULL + THRUSTER)[0][:, 0]]

    true, gone = of(fine, amid, 0.0), of(stamps, speeds, path)
    for ours, exact, within in zip(gone, true, (0.2, 0.1, 1e-3, 1e-3), strict=True):
        np.testing.assert_allclose(ours, exact, rtol=0.0, atol=within)
    apart = [np.abs(ours - exact).max() for ours, exact in zip(of(stamps, speeds, 0.0), true, strict=True)]
    assert apart[0] > 1.0 and apart[2] > 0.5 and apart[3] > 0.5


def own_of(columns: list[str], vehicle: vt.Vehicle | None = None) -> list[str]:
    vehicle = vehicle or vt.load_vehicle("bluerov2")
    layout = Layout(vehicle, pushes(vehicle, columns), (), ())
    return [u.name for u in own_unknowns(layout, [SimpleNamespace(moves=np.ones(6, bool), tick_s=0.1)])]


def test_measured_speeds_and_commands_are_told_of_in_their_own_way() -> None:
    vehicle = vt.load_vehicle("bluerov2")
    level, upright = vehicle.thrusters[:4], vehicle.thrusters[4:]
    turning = replace(vehicle, thrusters=(*(replace(thruster, input="rev_s") for thruster in level), *upright))
    own = own_of([f"{t.name}_{'rev_s' if t in level else 'command'}" for t in vehicle.thrusters], turning)
    each = ["/".join(thruster.name for thruster in group) for group in (level, upright)]
    assert [name for name in own if name.startswith("path")] == [f"path@{names}" for names in each]
    assert [name for name in own if name.startswith("delay")] == [f"delay@{names}" for names in each]


def test_thrusters_have_a_gain_of_their_own_and_a_recorded_wrench_has_none() -> None:
    thrusters = own_of([f"thruster_{k}_command" for k in range(1, 9)])
    assert [f"own_gain@thruster_{k}" for k in range(1, 9)] == [
        name for name in thrusters if name.startswith("own_gain")
    ]
    assert {"rotor@thrusters", "delay@thrusters", "path@thrusters"} < set(thrusters)
    wrench = own_of(["surge_N", "sway_N", "yaw_Nm"])
    assert not any(name.startswith(("own_gain", "rotor", "delay", "path")) for name in wrench)


def test_fins_that_turn_within_a_step_turn_the_hull_as_in_many(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measured angles go straight from row to row: taken for their mean over a step, what they do comes out late."""
    remus, time_s = vt.load_vehicle("remus100"), np.arange(0.0, 20.0, 0.2)
    asked = {fin.column: 0.25 * np.sin(4.0 * time_s + k) for k, fin in enumerate(remus.fins) if fin.limit_rad}
    flight = fly_vehicle(remus, {"time_s": time_s, "propeller_rev_s": np.full(100, 20.0), **asked}, 20.0, 1)

    def simulated(longest_s: float, turning: float = 1.0) -> np.ndarray:
        monkeypatch.setattr(recorded, "STEPS_S", (longest_s, longest_s))
        layout, (run,), _ = record([flight], remus)
        p = layout.null.copy()
        p[layout.starts[1] + SWEPT : layout.starts[2] : FIN] = 1.0
        f = filtered(run, p, first_noise([run]))
        run.drive(p).turn[:] *= turning
        e = innovations(run, p, f.gains._replace(of=np.zeros_like(f.gains.of)))
        return e[run.column == layout.columns.index("imu.yaw_rate_rad_s")]

    true = simulated(0.005)
    wide, half, mean = (np.abs(simulated(*how) - true).max() for how in ((0.06,), (0.03,), (0.06, 0.0)))
    assert wide < 5e-6 and half < wide / 3.0
    assert mean > 20.0 * wide
