"""Advice, estimators against the truth, design, scenario files, and the command."""

from __future__ import annotations

import itertools
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vtank.cli import main
from vtank.estimate.maximum_likelihood import identify
from vtank.estimate.observed import observe
from vtank.estimate.paper.estimate import estimate
from vtank.estimate.paper.regression import regression
from vtank.estimate.paper.settings import PaperSettings
from vtank.experiment import simulate_surge
from vtank.experiment.clearance import MARGIN_M, clearances
from vtank.experiment.plan import plan_run
from vtank.experiment.scenario import load_scenario, scenario_names
from vtank.experiment.written import as_toml
from vtank.plant.truth import load_truth
from vtank.studies.design.advice import options, remedies
from vtank.studies.design.candidates import AT_LIMIT, library
from vtank.studies.design.design import REST_MIN, confirmed, design, given, minutes, pool, scenario_texts
from vtank.studies.design.document import document
from vtank.studies.design.estimators import METHODS, _paper, likelihood
from vtank.studies.design.findings import Findings
from vtank.studies.design.flown import noise_of
from vtank.studies.design.search import Search
from vtank.studies.design.study import PAPER, study
from vtank.studies.design.trials import Trials, trials
from vtank.studies.design.verdicts import separation, slots_of
from vtank.studies.design.words import sentences
from vtank.studies.processes import processes
from vtank.waves import Waves

QUIET = ("tachometer.noise_rev_s=0",)
TRUTH = load_truth("paper-ii")


@pytest.fixture(scope="module")
def slow():
    """Data set 4 alone: 0.2 rad/s."""
    return study([load_scenario("paper-ds4")], TRUTH, "II")


@pytest.fixture(scope="module")
def paper():
    return study([load_scenario(name) for name in PAPER], TRUTH, "II")


@pytest.fixture(scope="module")
def advised(slow):
    some = options(slow)
    return some, remedies(slow, some)


def test_candidates_fit_the_tank(slow):
    for f in library(slow):
        x = np.cumsum(f.surge_m_s) * f.scenario.period_s  # the distance made good, roughly
        assert min(clearances(f.scenario, x.max(), x.min())) > MARGIN_M - 0.05
        assert np.mean(np.abs(f.run.input) > TRUTH.n_limit_rev_s + 0.2) <= AT_LIMIT


@pytest.mark.slow
def test_advice_says_what_one_run_more_does(slow, advised):
    some, found = advised
    assert {(r.verdict.effect.name, r.pair and r.pair.b.name) for r in found} >= {("sonar_latency", None)}
    for remedy in found:
        option = next(o for o in some if o.words == remedy.experiment)
        total = slow.information + option.information
        if remedy.pair is None:
            after = total.separation(slots_of(remedy.verdict.effect, slow.quantities), slow.free)
        else:
            after = separation(total, remedy.pair.a, remedy.pair.b, slow.free)
        assert remedy.after == pytest.approx(after)
        assert remedy.after >= remedy.before - 1e-6
        assert remedy.repeat == pytest.approx(np.sqrt(2.0) * remedy.before, rel=1e-3, abs=1e-3)  # the only run, twice


@pytest.mark.slow
def test_several_frequencies_make_latency_visible_and_no_run_of_a_sonar_tells_the_delays_apart(advised):
    _, found = advised
    latency = next(r for r in found if r.pair is None and r.verdict.effect.name == "sonar_latency")
    assert latency.before < 5.0 and latency.after > 4.0 * latency.before and not latency.sensor
    delays = next(r for r in found if r.pair and {r.pair.a.name, r.pair.b.name} == {"sonar_latency", "command_delay"})
    assert delays.before < 0.1 and delays.sensor and delays.after > 3.0


@pytest.mark.slow
def test_sentences_carry_the_computed_numbers(slow, advised):
    _, found = advised
    text = "\n".join(sentences(slow, found))
    latency = next(r for r in found if r.pair is None and r.verdict.effect.name == "sonar_latency")
    assert f"sonar latency of 0.1 s is hardly seen: {latency.before:.1f} of" in text
    assert f"{latency.before:.1f} -> {latency.after:.0f}" in text
    assert "sonar scale of 0.01 is not identifiable: refitting takes it for alpha +1 %, beta +1 %." in text


# --- Monte Carlo ---------------------------------------------------------------------------------------------------
@pytest.fixture(scope="module")
def quiet_trials():
    looked = study([load_scenario(name, QUIET) for name in PAPER[:2]], TRUTH, "II")
    return looked, trials([f.scenario for f in looked.flown], TRUTH, "II", looked.bound, 24, seed=3)


@pytest.mark.slow
def test_the_likelihood_scatters_as_the_bound_says(quiet_trials):
    """Errors over the bound's covariance: chi-square of 24 x 3 degrees, deviation 12; within four of it."""
    looked, found = quiet_trials
    error = (found.found["likelihood"] - found.true) / np.abs(found.true)
    squares = np.einsum("ni,ij,nj->", error, np.linalg.inv(looked.covariance), error)
    assert 72.0 - 48.0 < squares < 72.0 + 48.0
    assert found.coverage("likelihood").min() > 0.7


@pytest.mark.slow
def test_least_squares_is_biased_where_the_likelihood_is_not(quiet_trials):
    _, found = quiet_trials
    tau = found.names.index("thrust_lag.tau")
    (likelihood, _), (squares, doubt) = found.bias("likelihood"), found.bias("least_squares")
    assert abs(likelihood[tau]) < 0.05
    assert squares[tau] < -0.3 and abs(squares[tau]) > 10.0 * doubt[tau]


def test_the_likelihood_of_the_trials_is_that_of_the_command():
    scenarios = [load_scenario(name) for name in PAPER]
    plans = [plan_run(scenario, i, 4, TRUTH) for i, scenario in enumerate(scenarios)]
    runs = [result.run for result in simulate_surge(plans)]
    noise = noise_of(scenarios[0], plans[0].p, runs[0].columns["n_rev_s"])
    quick, slow = likelihood(runs, "II", {}, noise), identify([observe(run) for run in runs], "II")
    assert not slow.problem.noise.quiet
    sd = np.array(list(slow.sd.values()))
    assert (quick.value - list(slow.values.values())) / sd == pytest.approx(0.0, abs=0.1)
    assert quick.sd == pytest.approx(sd, rel=0.1)


@pytest.mark.slow
def test_the_same_seed_gives_the_same_bytes_on_one_process_and_two():
    scenarios = [load_scenario("paper-ds3", ("duration_s=40",))]
    one = trials(scenarios, TRUTH, "II", np.ones(3), 4, seed=7)
    with processes(2) as over:
        two = trials(scenarios, TRUTH, "II", np.ones(3), 4, seed=7, over=over)
    other = trials(scenarios, TRUTH, "II", np.ones(3), 2, seed=8)
    for method in METHODS:
        assert one.found[method].tobytes() == two.found[method].tobytes()
        assert one.claimed[method].tobytes() == two.claimed[method].tobytes()
        assert not np.array_equal(one.found[method][:2], other.found[method])


def test_statistics_of_normal_estimates_are_those_of_their_distribution():
    drawn = np.random.default_rng(5).normal(2.0, 0.1, (4000, 1))
    made = {method: drawn for method in METHODS}
    found = Trials(("tau",), np.array([1.9]), np.array([0.05]), made, {m: np.full_like(drawn, 0.1) for m in METHODS})
    bias, doubt = found.bias("kalman")
    assert bias[0] == pytest.approx(0.1 / 1.9, abs=4.0 * doubt[0])
    assert found.spread_over_bound("kalman")[0] == pytest.approx(2.0, rel=0.05)
    assert found.coverage("kalman")[0] == pytest.approx(0.83, abs=0.03)  # P(|N(1, 1)| < 1.96)


def test_an_estimate_that_failed_covers_nothing():
    found = Trials(("tau",), np.ones(1), np.ones(1), {m: np.array([[np.nan], [1.0]]) for m in METHODS},
                   {m: np.ones((2, 1)) for m in METHODS})  # fmt: skip
    assert found.coverage("kalman")[0] == 0.5


def test_claimed_deviations_are_those_of_the_coefficients():
    """alpha = C1 / T in feet, so that its deviation is that of C1 over T; beta = C4 / (T C2) to first order."""
    rng = np.random.default_rng(2)
    n = 10.0 * np.sin(0.25 * np.arange(200))
    u = 0.1 * np.sin(0.25 * np.arange(200) - 1.0) + 0.002 * rng.normal(size=200)
    rows = regression(u, n, 0.5, "II")
    answer = _paper(rows, "II", "least_squares")
    found = estimate(rows, PaperSettings(estimator="least_squares", compiled=True))
    c, P = found.final, found.covariance
    assert answer.sd[0] == pytest.approx(np.sqrt(P[0, 0]) / 0.5 / 0.3048, rel=1e-5)
    relative = P[3, 3] / c[3] ** 2 + P[1, 1] / c[1] ** 2 - 2.0 * P[1, 3] / (c[1] * c[3])
    assert answer.sd[1] / abs(answer.value[1]) == pytest.approx(np.sqrt(relative), rel=1e-5)


# --- design --------------------------------------------------------------------------------------------------------
def test_the_search_finds_what_trying_all_plans_finds():
    rng = np.random.default_rng(11)
    factors = rng.normal(size=(7, 3, 3)) * rng.choice([1.0, 5.0], size=(7, 1, 1))
    matrix = factors @ factors.transpose(0, 2, 1)
    search, budget = Search(matrix, np.array([2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 2.0])), 9.0
    plans = itertools.chain.from_iterable(itertools.combinations_with_replacement(range(7), k) for k in range(1, 5))
    best = min(search.cost(plan) for plan in plans if search.minutes[list(plan)].sum() <= budget)
    starts = [search.exchanged(search.filled(start, budget), budget) for start in ([], *([k] for k in range(7)))]
    assert min(map(search.cost, starts)) == pytest.approx(best)
    assert all(search.minutes[plan].sum() <= budget for plan in starts)


def test_cost_is_the_trace_of_the_inverse_and_infinite_without_information():
    matrix = np.array([[[4.0, 0.0], [0.0, 0.0]], [[0.0, 0.0], [0.0, 2.0]]])
    search = Search(matrix, np.ones(2))
    assert search.cost([0, 1]) == pytest.approx(0.25 + 0.5)
    assert search.cost([0]) == np.inf


@pytest.mark.slow
def test_the_design_is_better_in_no_more_time_and_never_worse_than_the_plan(paper):
    found = design(paper, pool(paper))
    assert minutes(found.items) <= minutes(found.given) == 4.0 * (2.0 + REST_MIN)
    assert np.sum(found.relative(found.items) ** 2) < 0.6 * np.sum(found.relative(found.given) ** 2)
    bare = design(paper, given(paper))
    assert np.sum(bare.relative(bare.items) ** 2) <= np.sum(bare.relative(bare.given) ** 2) * (1.0 + 1e-12)


def test_a_run_of_the_plan_that_is_no_choice_any_more_is_left_out(paper):
    """As one is that hits a wall in the tank."""
    own = given(paper)
    found = design(paper, own[1:])
    assert own[0].words not in [item.words for item in found.items]
    assert 0.0 < minutes(found.items) <= minutes(own)


@pytest.mark.slow
def test_designed_runs_fly_in_the_tank_from_their_files(slow, tmp_path, capsys):
    found = confirmed(slow, pool(slow))
    texts = scenario_texts(found)
    for (name, text), item in zip(texts.items(), found.items, strict=True):
        (tmp_path / name).write_text(text, encoding="utf-8")
        wanted, again = item.flown.scenario, load_scenario(tmp_path / name)
        assert replace(again, path=wanted.path, name=wanted.name) == wanted
    paths = [str(path) for path in sorted(tmp_path.glob("*.toml"))]
    assert main(["run", *paths, "--model", "surge", "--out", str(tmp_path / "data")]) == 0
    assert len(list((tmp_path / "data").glob("*.csv"))) == len(found.items)


STILL = [name for name in scenario_names() if load_scenario(name).waves == Waves()]


@pytest.mark.parametrize("name", STILL)
def test_a_scenario_that_was_written_is_read_as_it_was(name, tmp_path):
    settings = ("effects.wake_memory.k=0.2", "effects.wake_memory.T_s=7.5", "sonar.dropout=0.01", "n_limit_rev_s=19")
    scenario = load_scenario(name, settings)
    path = tmp_path / f"{name}.toml"
    path.write_text(as_toml(scenario, "a comment"), encoding="utf-8")
    assert replace(load_scenario(path), path=scenario.path) == scenario


def test_waves_are_not_written():
    with pytest.raises(ValueError, match="waves"):
        as_toml(load_scenario("station-keeping"))


# --- command -------------------------------------------------------------------------------------------------------
@pytest.mark.slow
def test_the_command_prints_verdicts_and_writes_page_tables_and_json(tmp_path, capsys, fits):
    out = tmp_path / "page"
    code = main(["identifiability", "paper-ds4", "--set", "duration_s=60", "--seeds", "2", "--processes", "1",
                 "--out", str(out), "--json", str(tmp_path / "all.json")])  # fmt: skip
    printed = capsys.readouterr().out
    assert code == 0
    assert printed.startswith("- This run can tell alpha to")
    assert "Four estimators on the same recordings, 2 seeds" in printed
    names = {"bounds.csv", "effects.csv", "estimators.csv", "identifiability.html", "identifiability.json"}
    assert {path.name for path in out.iterdir()} == names | {"identifiability.png"}
    content = json.loads((tmp_path / "all.json").read_text())
    assert content | {"files": sorted(names - {"identifiability.json"} | {"identifiability.png"})} == json.loads(
        (out / "identifiability.json").read_text()
    )
    assert set(content["effects"]) >= {"sonar_scale", "tachometer_spikes"}
    assert np.shape(content["bias"]["median_error"]["likelihood"])[::2] == (3, 3)
    page = (out / "identifiability.html").read_text()
    assert '<img src="data:image/png;base64,' in page
    assert page.count("src=") == 1 and page.count("href=") == 1 and 'href="data:,"' in page  # complete in itself
    assert fits(out / "identifiability.html")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--seeds", "1"], "--seeds"),
        (["--write-plan", "plan"], "--design"),
        (["no-such-scenario"], "no-such-scenario"),
        (["--model", "III"], "thrust_loss.gamma"),
        (["paper-ds1", "bluerov2-surge"], "--truth"),
        (["station-keeping"], "waves"),
    ],
)
def test_bad_arguments_are_refused_in_one_line_and_leave_nothing(arguments, words, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["identifiability", *arguments, "--out", str(tmp_path / "out"), "--json", "all.json"]) == 2
    error = capsys.readouterr().err.strip().splitlines()
    assert error[-1].startswith("vtank: error:") and words in error[-1]
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("option", ["--out", "--json", "--write-plan"])
def test_what_cannot_be_written_is_refused_before_any_work(option, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("vtank.studies.design.examined.study", lambda *_: pytest.fail("work was done"))
    taken = tmp_path / "taken"
    taken.write_text("")
    target = taken / "all.json" if option == "--json" else taken
    assert main(["identifiability", "paper-ds1", "--seeds", "0", "--design", option, str(target)]) == 2
    assert "taken" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


def test_help_loads_nothing_heavy():
    code = (
        "import sys\n"
        "try: from vtank.cli import main; main(['identifiability', '--help'])\n"
        "except SystemExit: print(*sys.modules)"
    )
    environment = {"PYTHONPATH": str(Path(sys.modules["vtank"].__file__).parents[1]), "PATH": "/usr/bin:/bin"}
    text = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment)
    assert "--design" in text.stdout
    assert not {"numba", "mujoco", "scipy", "filterpy", "matplotlib", "numpy"} & set(text.stdout.split())


def test_a_plan_without_seeds_has_a_document_without_estimators(slow):
    content = document(Findings(slow, (), ()))
    assert "estimators" not in content and "bias" not in content and "design" not in content
    assert content["parameters"]["alpha"]["truth"] == pytest.approx(TRUTH.alpha_per_m)
