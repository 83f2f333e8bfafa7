"""Vehicle files and truth presets: their physics, and what is said about bad ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigvals

from vtank.errors import InputError
from vtank.plant.parameters import slot
from vtank.plant.truth import load_truth, truth_names
from vtank.plant.vehicle import load_vehicle
from vtank.resources import models_dir
from vtank.units import SLUG_KG

PHOENIX = (models_dir() / "phoenix.toml").read_text(encoding="utf-8")
TRUTH = """
name = "mine"
source = "bench test"
n_limit_rev_s = 12.0
[lumped]
alpha_per_m = -2.0
beta_m_per_rev2 = 5e-4
gamma_per_rev = 0.0
tau_s = 0.5
"""
BLUEROV = """
name = "bluerov2"
mjcf = "bluerov2.xml"
[body]
mass_kg = 11.5
centre_of_buoyancy_m = [0.0, 0.0, -0.02]
buoyancy_N = 114.8
[added_mass]
surge_kg = 5.5
sway_kg = 12.7
heave_kg = 14.57
roll_kg_m2 = 0.12
pitch_kg_m2 = 0.12
yaw_kg_m2 = 0.12
[quadratic_drag]
surge_N_s2_per_m2 = 18.18
sway_N_s2_per_m2 = 21.66
heave_N_s2_per_m2 = 36.99
roll_N_m_s2_per_rad2 = 1.55
pitch_N_m_s2_per_rad2 = 1.55
yaw_N_m_s2_per_rad2 = 1.55
[propeller]
sites = ["thruster_1", "thruster_2", "thruster_3", "thruster_4"]
diameter_m = 0.076
[[thruster]]
site = "thruster_5"
direction = [0.0, 0.0, 2.0]
limit_N = 40.0
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "numbers.toml"
    path.write_text(text, encoding="utf-8")
    return path


def rigid_mass(mass: float, inertia: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Mass matrix of a rigid body about the origin, shape (6, 6)."""
    x, y, z = centre
    across = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.block(
        [[mass * np.eye(3), -mass * across], [mass * across, np.diag(inertia) - mass * across @ across]]
    )  # fmt: skip


def test_righting_gives_the_published_natural_frequencies() -> None:
    """Small motions: (M_RB + M_A) q'' + W zG q = 0 in roll and pitch; phoenix sources: 2.3 and 0.48 rad/s."""
    vehicle, zg, inertia = load_vehicle(), 0.027178, np.array([3.66, 56.9, 60.5])
    stiffness = vehicle.buoyancy_N * zg
    assert stiffness == pytest.approx(52.6, abs=0.05)
    roll, pitch = np.sqrt(stiffness / (inertia[:2] + np.diag(vehicle.added_mass)[3:5]))
    assert roll == pytest.approx(2.3, abs=0.05)
    assert pitch == pytest.approx(0.48, abs=0.005)
    # coupled to sway, heave and surge the frequencies shift by a few per cent only
    mass = rigid_mass(vehicle.mass_kg, inertia, np.array([0.003175, 0.0, zg])) + vehicle.added_mass
    restoring = np.diag([0.0, 0.0, 0.0, stiffness, stiffness, 0.0])
    squares = np.sort(eigvals(restoring, mass).real)
    assert np.sqrt(squares[-2:]) == pytest.approx([pitch, roll], rel=0.02)


def test_the_phoenix_is_neutral_and_trimmed() -> None:
    vehicle = load_vehicle()
    assert vehicle.buoyancy_N == pytest.approx(vehicle.mass_kg * 9.80665, rel=1e-12)
    assert vehicle.moving_mass_kg / SLUG_KG == pytest.approx(14.585, abs=1e-3)


def test_added_mass_follows_from_the_published_coefficients() -> None:
    """Element = rho/2 L^k C with L = 7.302 ft, rho = 1.94 slug/ft3, as non-dimensionalised in S1."""
    coefficients = {(0, 0): 2.82e-3, (1, 1): 3.43e-2, (2, 2): 9.34e-2, (3, 3): 2.4e-4, (4, 4): 6.25e-3, (5, 5): 4.7e-4}
    coefficients |= {(1, 5): 1.78e-3, (2, 4): 2.53e-3}
    added = load_vehicle().added_mass
    for (row, column), coefficient in coefficients.items():
        power = 3 + (row > 2) + (column > 2)
        expected = 0.97 * 7.302**power * coefficient * SLUG_KG * 0.3048 ** (power - 3)
        assert added[row, column] == pytest.approx(expected, rel=5e-4), (row, column)
        assert added[column, row] == added[row, column]
    assert np.count_nonzero(added) == 10


def test_drag_of_all_axes() -> None:
    vehicle = load_vehicle()
    assert vehicle.quadratic_drag == pytest.approx([19.3, 123, 267, 552, 191, 150], rel=5e-3)
    assert vehicle.linear_drag == pytest.approx([0, 0, 0, 9.6, 3.3, 2.6], rel=2e-2)


def test_another_vehicle_needs_no_code(tmp_path: Path) -> None:
    vehicle = load_vehicle(written(tmp_path, BLUEROV))
    assert vehicle.moving_mass_kg == 17.0
    assert vehicle.mjcf == tmp_path / "bluerov2.xml"
    assert len(vehicle.propeller_sites) == 4
    assert vehicle.thrusters[0].direction == (0.0, 0.0, 1.0)
    assert not vehicle.linear_drag.any()


def test_a_sensor_needs_no_more_than_its_channels(tmp_path: Path) -> None:
    """A recording tells its rate itself; only who flies the vehicle goes by that of the file."""
    sensor = '[sensor.dvl]\nchannels = ["surge_m_s", "sway_m_s"]\n'
    (dvl,) = load_vehicle(written(tmp_path, BLUEROV + sensor)).sensors
    assert dvl.rate_hz == 10.0
    assert dvl.noise == (0.0, 0.0)


@pytest.mark.parametrize(
    ("buoyancy_N", "cause"),
    [
        ("11.5", "is it in kilograms?"),
        ("1148.0", "has its decimal point slipped"),
        ("25.4", "has its decimal point slipped"),
    ],
)
def test_a_buoyancy_that_no_vehicle_has_is_refused(tmp_path: Path, buoyancy_N: str, cause: str) -> None:
    path = written(tmp_path, BLUEROV.replace("114.8", buoyancy_N))
    with pytest.raises(InputError) as caught:
        load_vehicle(path)
    told = f"{path}:7: body.buoyancy_N: found {buoyancy_N.removesuffix('.0')} N, but 11.5 kg weigh 112.8 N; expected"
    assert told in str(caught.value) and cause in str(caught.value)


@pytest.mark.parametrize("buoyancy_N", ["80.0", "140.0"])
def test_a_heavy_crawler_and_a_light_float_are_believed(tmp_path: Path, buoyancy_N: str) -> None:
    assert load_vehicle(written(tmp_path, BLUEROV.replace("114.8", buoyancy_N))).buoyancy_N == float(buoyancy_N)


DIRECTION = "direction = { value = [0.0, "


@pytest.mark.parametrize(
    ("find", "replacement", "said"),
    [
        ("mass_kg = {", "mass_lb = {", "body.mass_lb: unknown key"),
        ("surge_kg = {", "# {", "added_mass.surge_kg: missing"),
        ("value = 189.0", 'value = "much"', "added_mass.sway_kg: expected a number"),
        ("value = 122.6", "value = -122.6", "quadratic_drag.sway_N_s2_per_m2: drag coefficients are given as positive"),
        ("value = 12.83", "value = -300.0", "added_mass: the matrix has a negative eigenvalue"),
        ("value = 12.83", "value = nan", "added_mass.yaw_kg_m2: expected a number"),
        (
            "direction = { value = [0.0, 0.0, 1.0]",
            "direction = { value = [0.0, 0.0]",
            "thruster[0].direction: expected three numbers",
        ),
        (
            "direction = { value = [0.0, 0.0, 1.0]",
            "direction = { value = [0, 0, 0]",
            "thruster[0].direction: expected a direction",
        ),
        ("limit_N = { value = 8.9", "limit_N = { value = 0.0", "thruster[0].limit_N: expected a number above 0"),
        ("[body]", "[body", "not valid TOML"),
        ('source = "S1"', 'from = "S1"', "body.mass_kg.from: unknown key"),
        ('sites = ["propeller_port", "propeller_starboard"]', "sites = []", "propeller.sites: expected a list"),
    ],
)
def test_a_bad_vehicle_file_is_told_apart(tmp_path: Path, find: str, replacement: str, said: str) -> None:
    assert find in PHOENIX
    path = written(tmp_path, PHOENIX.replace(find, replacement, 1))
    with pytest.raises(InputError) as caught:
        load_vehicle(path)
    assert str(path) in str(caught.value)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("find", "replacement", "said"),
    [
        ("alpha_per_m = -2.0", "alpha_per_m = 2.0", "drag must slow"),
        ("5e-4", "0.0", "thrust must push"),
        ("gamma_per_rev = 0.0", "gamma_per_rev = 0.1", "thrust falls with speed"),
        ("tau_s = 0.5", "tau_s = -0.5", "tau must not be negative"),
        ("tau_s = 0.5", "tau_ms = 500", "lumped.tau_ms: wrong unit: expected 'tau_s' [s]"),
        ("n_limit_rev_s = 12.0", "n_limit_rpm = 700", "n_limit_rpm: wrong unit: expected 'n_limit_rev_s' [rev/s]"),
        ("alpha_per_m", "a_per_ft", "lumped.beta_m_per_rev2: unknown key"),
    ],
)
def test_a_bad_truth_is_told_apart(tmp_path: Path, find: str, replacement: str, said: str) -> None:
    assert find in TRUTH
    path = written(tmp_path, TRUTH.replace(find, replacement, 1))
    with pytest.raises(InputError) as caught:
        load_truth(path)
    assert str(path) in str(caught.value)
    assert said in str(caught.value)


def test_unknown_names_list_the_known_ones() -> None:
    with pytest.raises(InputError, match="paper-ii, paper-iii, physical"):
        load_truth("paper-iv")
    with pytest.raises(InputError, match="phoenix"):
        load_vehicle("nautilus")
    with pytest.raises(InputError, match="cannot be read"):
        load_vehicle("/nowhere/at-all.toml")


@pytest.mark.parametrize("name", truth_names())
def test_a_truth_fills_its_slots_of_the_parameter_vector(name: str) -> None:
    truth = load_truth(name)
    p = truth.vector()
    assert p[slot("alpha")] == truth.alpha_per_m
    assert p[slot("beta")] == truth.beta_m_per_rev2
    assert p[slot("thrust_loss.gamma")] == truth.gamma_per_rev
    assert p[slot("thrust_lag.tau")] == truth.tau_s


def test_a_truth_in_si_is_taken_as_it_is(tmp_path: Path) -> None:
    truth = load_truth(written(tmp_path, TRUTH))
    assert (truth.alpha_per_m, truth.beta_m_per_rev2, truth.gamma_per_rev, truth.tau_s) == (-2.0, 5e-4, 0.0, 0.5)
