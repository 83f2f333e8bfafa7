"""Excitations: rates against differences, peaks, repetition, and the loop that the unit chooses."""

from __future__ import annotations

import numpy as np
import pytest

from vtank.experiment.clearance import LENGTHS_M, clearances
from vtank.experiment.excitation import Excitation, fade_in
from vtank.experiment.scenario import load_scenario
from vtank.plant.truth import load_truth
from vtank.plant.vehicle import load_vehicle
from vtank.tank import Tank, load_model

SMOOTH = {
    "sine": Excitation("position_sine", "position", (0.5,), (0.7,), offset=0.1, ramp_s=5.0, phase_rad=0.4),
    "multisine": Excitation("multisine", "position", (0.3, 0.2, 0.1), (0.2, 0.5, 1.3), ramp_s=3.0),
    "chirp": Excitation("chirp", "position", (0.3,), (0.1, 1.5), offset=-0.1),
}


@pytest.mark.parametrize("name", SMOOTH)
def test_rate_is_the_derivative_of_the_command(name: str) -> None:
    t, h = np.linspace(0.3, 40.0, 97), 1e-4
    value, rate = SMOOTH[name].command(t, 40.0)
    later, earlier = (SMOOTH[name].command(t + d, 40.0)[0] for d in (h, -h))
    np.testing.assert_allclose(rate, (later - earlier) / (2.0 * h), atol=1e-7)
    assert np.ptp(value) > 0.3


def test_the_fade_starts_and_ends_at_rest() -> None:
    value, rate = fade_in(np.array([0.0, 2.5, 5.0, 9.0]), 5.0)
    np.testing.assert_allclose(value, [0.0, 0.5, 1.0, 1.0])
    np.testing.assert_allclose(rate[[0, 2, 3]], 0.0, atol=1e-15)


def test_chirp_sweeps_from_the_first_frequency_to_the_second() -> None:
    t = np.linspace(0.0, 100.0, 100_001)
    value = Excitation("chirp", "speed", (1.0,), (0.2, 2.0)).command(t, 100.0)[0]
    crossings = t[1:][np.diff(np.sign(value)) != 0]
    assert np.pi / np.diff(crossings)[0] == pytest.approx(0.2, rel=0.5)
    assert np.pi / np.diff(crossings)[-1] == pytest.approx(2.0, rel=0.02)


def test_schroeder_phases_keep_the_peak_below_that_of_sines_in_phase() -> None:
    t, w = np.linspace(0.0, 2.0 * np.pi / 0.1, 5001), tuple(0.1 * (i + 1) for i in range(8))
    value = Excitation("multisine", "speed", (1.0,) * 8, w).command(t, 1.0)[0]
    assert np.abs(value).max() < 0.75 * np.abs(np.sum(np.sin(np.outer(w, t)), axis=0)).max()


def test_square_and_pulses_change_at_their_ticks() -> None:
    t = np.arange(0.0, 61.0, 0.1)
    value, rate = Excitation("square", "position", (0.3,), (2.0 * np.pi / 30.0,)).command(t, 60.0)
    assert value[0] == 0.3 and value[149] == 0.3 and value[150] == -0.3 and value[300] == 0.3 and not rate.any()
    pulses = Excitation("step_coast", "speed", (9.0,), push_s=3.0, coast_s=12.0).command(t, 60.0)[0]
    assert [pulses[k] for k in (0, 29, 30, 149, 150, 300, 450, 600)] == [9.0, 9.0, 0.0, 0.0, -9.0, -9.0, 9.0, 9.0]


def test_the_unit_of_the_amplitude_chooses_the_loop() -> None:
    assert load_scenario("paper-ds1").excitation.loop == "position"
    assert load_scenario("open-loop-sine").excitation.loop == "speed"
    chirp = load_scenario("chirp").excitation
    assert chirp.loop == "position" and chirp.amplitudes == (0.3048,)


def test_clearances_are_those_of_the_models() -> None:
    model = load_model()
    bow, stern, sonar = (model.site(name).pos[0] for name in ("hull_bow", "propeller_port", "sonar_st1000"))
    tank = Tank(model, load_vehicle(), load_truth("paper-ii").vector())
    to_ahead, to_astern = tank.ray(tank.qpos[:, None, :3], np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]))[0]
    assert LENGTHS_M["basin"] == pytest.approx(to_ahead + to_astern)
    assert load_vehicle().ends_m == pytest.approx((bow, stern)) and load_vehicle().sonar_x_m == pytest.approx(sonar)
    assert clearances(load_scenario("paper-ds1"), 0.0, 0.0) == pytest.approx((to_ahead - bow, to_astern + stern))
