"""Campaign files, the runs they stand for, and what is true of them."""

from __future__ import annotations

import csv
import math
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from campaigns import SURGE, campaign_of, write_campaign
from scipy import stats

from vtank.errors import InputError
from vtank.experiment import simulate_surge
from vtank.experiment.plan import plan_run
from vtank.experiment.scenario import load_scenario
from vtank.record import read_dataset
from vtank.record.manifest import manifest_text, read_manifest
from vtank.resources import scenarios_dir
from vtank.studies.campaign import Threads, fly_campaign, load_campaign
from vtank.studies.campaign.axes import LAWS, Draw

GRID = """
repeats = 2
[grid]
scenario = ["paper-ds1", "paper-ds4"]
sonar = { noise_m = [0.0, 0.01, 0.02], resolution_m = 0.001 }
"effects.linear_drag.c_per_s" = { from = 0.0, to = 0.04, count = 5 }
"""


def table(out: Path) -> list[dict[str, str]]:
    with (out / "runs.csv").open() as file:
        return list(csv.DictReader(file))


def test_the_grid_is_the_product_of_its_axes(tmp_path: Path) -> None:
    campaign = campaign_of(tmp_path, GRID)
    expected = list(product(("paper-ds1", "paper-ds4"), (0.0, 0.01, 0.02), (0.0, 0.01, 0.02, 0.03, 0.04), range(2)))
    assert len(campaign) == len(expected)
    for number, (scenario, noise, drag, _) in enumerate(expected):
        choice = campaign.choice(number)
        assert choice["scenario"] == scenario and choice["sonar.noise_m"] == noise
        assert choice["effects.linear_drag.c_per_s"] == pytest.approx(drag, abs=1e-15)
        plan = campaign.plan(number, choice)
        assert (plan.scenario.name, plan.scenario.sonar.noise_m, plan.scenario.sonar.resolution_m) == (
            scenario,
            noise,
            0.001,
        )
        assert plan.parameters["linear_drag.c"] == choice["effects.linear_drag.c_per_s"]
        assert (plan.seed, plan.run, plan.name) == (0, number, f"run_{number:02d}")


@pytest.mark.parametrize(
    ("entry", "values"),
    [
        ("3.0", [3.0]),
        ("[1.0, 2.5]", [1.0, 2.5]),
        ("{ from = 0.5, to = 2.0, count = 4 }", [0.5, 1.0, 1.5, 2.0]),
        ('{ from = 0.01, to = 1.0, count = 3, spacing = "log" }', [0.01, 0.1, 1.0]),
    ],
)
def test_axes_are_values_lists_and_ranges(tmp_path: Path, entry: str, values: list[float]) -> None:
    campaign = campaign_of(tmp_path, f'[grid]\nscenario = "paper-ds1"\ntachometer.noise_rev_s = {entry}')
    assert campaign.grid[1].values == pytest.approx(values)


def test_a_range_of_whole_numbers_stays_whole(tmp_path: Path) -> None:
    campaign = campaign_of(tmp_path, '[grid]\nscenario = "paper-ds1"\nseed = { from = 5, to = 11, count = 4 }')
    assert campaign.grid[1].values == (5, 7, 9, 11)


def test_draws_follow_their_laws() -> None:
    """Kolmogorov-Smirnov against the stated distributions, and equal shares of the choices."""

    def drawn(law: str, numbers: tuple[object, ...]) -> np.ndarray:
        return np.array([Draw("sonar.noise_m", law, numbers).value(3, run) for run in range(2000)])

    assert stats.kstest(drawn("uniform", (2.0, 5.0)), stats.uniform(2.0, 3.0).cdf).pvalue > 0.01
    assert stats.kstest(drawn("normal", (2.0, 0.5)), stats.norm(2.0, 0.5).cdf).pvalue > 0.01
    logs = np.log(drawn("log_uniform", (1e-3, 1e-1)))
    assert stats.kstest(logs, stats.uniform(math.log(1e-3), math.log(100.0)).cdf).pvalue > 0.01
    negative = drawn("log_uniform", (-10.0, -0.1))
    assert -10.0 <= negative.min() < -9.0 and -0.11 < negative.max() <= -0.1
    shares = np.unique(drawn("choice", ("a", "b", "c", "d")), return_counts=True)[1]
    assert stats.chisquare(shares).pvalue > 0.01


def test_draws_of_one_key_do_not_depend_on_the_others_nor_on_the_order(tmp_path: Path) -> None:
    one = 'seed = 4\nrepeats = 9\n[grid]\nscenario = "paper-ds1"\n[draw]\nsonar.noise_m = { uniform = [0.0, 0.1] }\n'
    more = one.replace("[draw]", "[draw]\nsonar.dropout = { uniform = [0.0, 0.1] }")
    first, second = campaign_of(tmp_path, one), campaign_of(tmp_path, more)
    noise = [first.choice(number)["sonar.noise_m"] for number in range(9)]
    assert [second.choice(number)["sonar.noise_m"] for number in reversed(range(9))] == noise[::-1]
    assert len(set(noise)) == 9
    assert all(second.choice(number)["sonar.dropout"] != noise[number] for number in range(9))


def test_runs_are_those_of_their_scenario_with_the_same_seed(tmp_path: Path) -> None:
    """The recordings are what the simulation gives for the scenario with these settings, to the bit."""
    grid = '[grid]\nscenario = "chirp"\ntruth = "paper-iii"\nseed = [5, 6]\nduration_s = 12.0'
    campaign = campaign_of(tmp_path, f'model = "surge"\n{grid}')
    fly_campaign(campaign, tmp_path / "out", Threads(1))
    scenario = load_scenario("chirp", ["duration_s=12.0"])
    for run, seed in zip(read_dataset(tmp_path / "out" / "data"), (5, 6), strict=True):
        alone = simulate_surge([plan_run(scenario, 0, seed, "paper-iii")])[0].run
        for name, values in alone.columns.items():
            np.testing.assert_allclose(run.columns[name], values, rtol=0.0, atol=0.5000001e-6)


def test_without_seeds_in_the_grid_every_run_has_noise_of_its_own(tmp_path: Path) -> None:
    text = 'model = "surge"\nseed = 2\nrepeats = 2\n[grid]\nscenario = "paper-ds1"\nduration_s = 12.0\n'
    fly_campaign(campaign_of(tmp_path, text), tmp_path / "own", Threads(1))
    first, second = read_dataset(tmp_path / "own" / "data")
    assert not np.array_equal(first.columns["range_m"], second.columns["range_m"])
    shared = text.replace("seed = 2\n", "").replace("[grid]", "[grid]\nseed = 2")
    fly_campaign(campaign_of(tmp_path, shared), tmp_path / "shared", Threads(1))
    first, second = read_dataset(tmp_path / "shared" / "data")
    assert np.array_equal(first.columns["range_m"], second.columns["range_m"])


@pytest.mark.filterwarnings("error")
def test_the_folder_is_a_data_set_beside_a_table_of_truth(tmp_path: Path) -> None:
    """The data set is as its manifest says, the table has all runs with the values that they were flown with."""
    campaign, out = campaign_of(tmp_path), tmp_path / "out"
    fly_campaign(campaign, out, Threads(2))
    data, rows = read_dataset(out / "data"), table(out)
    assert [row["run"] for row in rows] == [campaign.run_name(number) for number in range(18)]
    assert [run.name for run in data] == [row["run"] for row in rows if row["status"] == "done"]
    manifest = out / "data" / "manifest.json"
    assert manifest_text(read_manifest(manifest)) == manifest.read_text()
    for number, row in enumerate(rows):
        choice = campaign.choice(number)
        assert float(row["effects.linear_drag.c_per_s"]) == choice["effects.linear_drag.c_per_s"]
        if row["status"] == "done":
            plan = campaign.plan(number, choice)
            assert float(row["lumped.alpha_per_m"]) == plan.parameters["alpha"]
            assert float(row["effects.thrust_lag.tau_s"]) == plan.parameters["thrust_lag.tau"] > 0.0
            assert (row["truth"], row["seed"], row["run_number"]) == (plan.truth.name, "11", str(number))
    assert {path.name for path in out.iterdir()} == {"campaign.json", "data", "runs.csv"}


def test_alpha_and_beta_stand_in_for_the_presets(tmp_path: Path) -> None:
    text = '[grid]\nscenario = "paper-ds1"\n[draw]\nlumped.alpha_per_m = { log_uniform = [-2.0, -0.5] }\n'
    campaign = campaign_of(tmp_path, "repeats = 3\n" + text)
    plans = [campaign.plan(number, campaign.choice(number)) for number in range(3)]
    assert all(-2.0 <= plan.parameters["alpha"] <= -0.5 for plan in plans)
    assert len({plan.parameters["alpha"] for plan in plans}) == 3
    assert {plan.parameters["beta"] for plan in plans} == {plan_run(load_scenario("paper-ds1")).parameters["beta"]}


def test_effects_may_be_exchanged_as_a_whole(tmp_path: Path) -> None:
    effects = "[{}, { linear_drag = { c_per_s = 0.02 } }, { sonar_latency = { d_s = 0.2 } }]"
    campaign = campaign_of(tmp_path, f'[grid]\nscenario = "paper-ds1"\neffects = {effects}')
    plans = [campaign.plan(number, campaign.choice(number)).parameters for number in range(3)]
    assert [plan["linear_drag.c"] for plan in plans] == [0.0, 0.02, 0.0]
    assert [plan["sonar_latency.d"] for plan in plans] == [0.0, 0.0, 0.2]


WRONG = {
    "no scenario": ("[grid]\nsonar.noise_m = 0.01", "grid.scenario: missing"),
    "unknown scenario": (
        '[grid]\nscenario = "paper-ds9"',
        "small.toml:2: grid.scenario: no scenario named 'paper-ds9'",
    ),
    "unknown truth": ('[grid]\nscenario = "chirp"\ntruth = ["x"]', "small.toml:3: grid.truth: no truth preset named"),
    "unknown key": (
        '[grid]\nscenario = "chirp"\nsonar.nose_m = 0.1',
        "small.toml:3: grid.sonar.nose_m: 0.1: chirp.toml: sonar.nose_m: unknown key; did you mean 'noise_m'?",
    ),
    "wrong unit": (
        '[grid]\nscenario = "chirp"\n[grid.sonar]\nnoise_mm = [3.0]',
        "small.toml:4: grid.sonar.noise_mm: 3.0: chirp.toml: sonar.noise_mm: wrong unit: expected 'noise_m' [m]",
    ),
    "value out of bounds": (
        '[grid]\nscenario = "chirp"\nsonar.noise_m = [0.1, -0.2]',
        "small.toml:3: grid.sonar.noise_m: -0.2: chirp.toml: sonar.noise_m: expected a number from 0 to 10",
    ),
    "draw out of bounds": (
        '[grid]\nscenario = "chirp"\n[draw]\neffects.sonar_latency.d_s = { uniform = [0.0, 50.0] }',
        "small.toml:4: draw.effects.sonar_latency.d_s: 50.0: chirp.toml",
    ),
    "drawn seed": ('[grid]\nscenario = "chirp"\n[draw]\nseed = { choice = [1, 2] }', "draw.seed: cannot be drawn"),
    "seed of 1.5": ('[grid]\nscenario = "chirp"\nseed = [1.5]', "grid.seed: expected whole numbers"),
    "positive alpha": ('[grid]\nscenario = "chirp"\nlumped.alpha_per_m = 1.0', "expected numbers below 0, found 1.0"),
    "no such lumped": ('[grid]\nscenario = "chirp"\nlumped.tau_s = 1.0', "tau are effects.thrust_loss.gamma_per_rev"),
    "grid and draw": (
        '[grid]\nscenario = "chirp"\nsonar.noise_m = 0.1\n[draw]\nsonar.noise_m = { uniform = [0.1, 0.2] }',
        "draw.sonar.noise_m: stands in [grid] too",
    ),
    "no law": ('[draw]\nscenario = "chirp"', "draw.scenario: expected one of uniform, log_uniform, normal, choice"),
    "wrong way round": ("[draw]\nsonar.noise_m = { uniform = [0.2, 0.1] }", "uniform: expected [low, high]"),
    "log through zero": ("[draw]\nsonar.noise_m = { log_uniform = [0.0, 0.1] }", "log_uniform: expected [low, high]"),
    "range of one": ("[grid]\nsonar.noise_m = { from = 0.1, to = 0.2, count = 1 }", "at least two values"),
    "empty list": ("[grid]\nsonar.noise_m = []", "grid.sonar.noise_m: expected at least one value"),
    "unknown model": ('model = "pool"', "model: expected one of tank, surge; found 'pool'"),
    "unknown table": ('[grit]\nscenario = "chirp"', "grit: unknown key; did you mean 'grid'?"),
    "no repeats": ("repeats = 0", "repeats: expected a whole number of at least 1, found 0"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_told_with_file_line_and_key(tmp_path: Path, case: str) -> None:
    text, message = WRONG[case]
    path = write_campaign(tmp_path, text)
    with pytest.raises(InputError) as error:
        load_campaign(path)
    assert str(error.value).startswith(str(path)) and message in str(error.value)


@pytest.mark.parametrize("path", sorted((scenarios_dir() / "campaigns").glob("*.toml")), ids=lambda path: path.stem)
def test_the_campaigns_that_come_with_vtank_can_be_planned(path: Path) -> None:
    """By name; first and last run keep clear of the walls."""
    campaign = load_campaign(path.stem)
    for number in (0, len(campaign) - 1):
        assert simulate_surge([campaign.plan(number, campaign.choice(number))])[0].check_clearance() is None


def test_the_reference_of_all_keys_is_a_campaign(tmp_path: Path) -> None:
    """The block in the README, to the letter; and its table has every campaign that comes with vtank."""
    text = (scenarios_dir() / "campaigns" / "README.md").read_text()
    campaign = campaign_of(tmp_path, text.split("```toml\n")[1].split("```")[0])
    assert len(campaign) == 3 * 2**4 * 3 * 2
    assert {draw.law for draw in campaign.draws} == set(LAWS)
    for path in (scenarios_dir() / "campaigns").glob("*.toml"):
        assert f"| {path.stem} | {load_campaign(path).model} |" in text


def test_a_scenario_of_ones_own_is_found_beside_the_campaign(tmp_path: Path) -> None:
    own = (scenarios_dir() / "chirp.toml").read_text().replace("noise_m = ", "noise_m = 0.001 # ")
    (tmp_path / "own.toml").write_text(own)
    campaign = campaign_of(tmp_path, '[grid]\nscenario = ["own.toml", "chirp"]')
    noise = [campaign.plan(number, campaign.choice(number)).scenario.sonar.noise_m for number in range(2)]
    assert noise == [0.001, load_scenario("chirp").sonar.noise_m]


def test_a_failed_run_is_told_and_leaves_the_others_as_they_are(tmp_path: Path) -> None:
    """4 m lead into the wall, whatever the noise; the other runs are those of a campaign without them."""
    fly_campaign(campaign_of(tmp_path), tmp_path / "all", Threads(2))
    rows = table(tmp_path / "all")
    failed = [row for row in rows if row["status"] == "failed"]
    assert len(failed) == 6 and all(float(row["excitation.amplitude_m"]) == 4.0 for row in failed)
    assert all("hits the wall" in row["message"] and str(tmp_path) not in row["message"] for row in failed)
    assert not any((tmp_path / "all" / "data" / f"{row['run']}.csv").exists() for row in failed)
    good = next(row for row in rows if row["status"] == "done")
    campaign = campaign_of(tmp_path, SURGE)
    number = int(good["run"].removeprefix("run_"))
    alone = simulate_surge([campaign.plan(number, campaign.choice(number))])[0].run
    kept = read_dataset(tmp_path / "all" / "data" / f"{good['run']}.csv").runs[0]
    np.testing.assert_allclose(kept.columns["range_m"], alone.columns["range_m"], atol=0.5000001e-6)


def test_a_run_that_diverges_in_the_tank_spoils_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of runs stepped together one has a drag that no time step can follow; the others are as without it."""
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log of what diverges where it runs
    text = (
        'model = "tank"\n[grid]\nscenario = "open-loop-sine"\nduration_s = 3.0\nlumped.alpha_per_m = [-1.0, {}, -2.0]'
    )
    fly_campaign(campaign_of(tmp_path, text.format("-1e12")), tmp_path / "out", Threads(1), chunk=3)
    status = [(row["status"], row["message"]) for row in table(tmp_path / "out")]
    assert [word for word, _ in status] == ["done", "failed", "done"]
    assert "diverged" in status[1][1]
    fly_campaign(campaign_of(tmp_path, text.format("-1.5")), tmp_path / "calm", Threads(1), chunk=3)
    for name in ("run_0.csv", "run_2.csv"):
        assert (tmp_path / "out/data" / name).read_bytes() == (tmp_path / "calm/data" / name).read_bytes()
