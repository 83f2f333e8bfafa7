"""The place of the gap: floors, windows, lines and bins against what was put in, and silence where nothing was."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from recorded import DRIVES, NOISE, NOISE_M, NOMINAL, Found, find, record, recordings, select, sine
from scipy.signal import lfilter

from vtank.diagnose.evidence import evaluate
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.localise.gap import noise_floors, run_gaps
from vtank.diagnose.localise.region import bin_edges, missing_force, motion
from vtank.diagnose.localise.time import pointwise, with_discrepancy
from vtank.diagnose.localise.where import locate
from vtank.diagnose.selection import prepare
from vtank.estimate.problem import Noise


@pytest.fixture(scope="module")
def friction() -> Found:
    return find(recordings({"coulomb_friction.f": 0.006}), "coulomb_friction", "linear_drag")


@pytest.fixture(scope="module")
def wave() -> Found:
    """A force of 0.9 rad/s that comes and goes about 40 s, in the second run alone."""

    def burst(t: float, u: float, n: float) -> float:
        return 0.01 * float(np.sin(0.9 * t) * np.exp(-(((t - 40.0) / 15.0) ** 2)))

    runs = recordings()
    runs[1] = record("run_1", sine(*DRIVES[1]), NOMINAL, NOISE_M, 1, burst)
    return find(runs, "linear_drag")


@pytest.fixture(scope="module")
def nothing() -> Found:
    return find(recordings(seed=50), "linear_drag")


def test_the_channel_of_a_force(friction: Found) -> None:
    channel = friction.place.channel
    assert sum(channel.probability.values()) == pytest.approx(1.0)
    assert channel.probability["hydrodynamics"] > 0.9
    gains = channel.document()["log_evidence_gain"]
    assert gains["refit"]["force"] > 100.0 and gains["refit"]["sensor"] < 0.05 * gains["refit"]["force"]
    assert gains["best"]["force"] < 3.0


def test_the_gap_closes_down_to_the_floor(friction: Found) -> None:
    for gap in friction.place.gaps:
        assert gap.rms("refit") > 2.0 * gap.rms("diagnosed")
        assert gap.floor == pytest.approx(NOISE_M, rel=0.1)
        assert gap.rms("diagnosed") == pytest.approx(gap.floor, rel=0.05)
    assert sum(gap.share for gap in friction.place.gaps) == pytest.approx(1.0)


def test_the_floor_is_what_noise_and_disturbance_make_of_the_motion(nothing: Found) -> None:
    """Against the spread of simulations pushed by an Ornstein-Uhlenbeck acceleration."""
    rng, noise = np.random.default_rng(3), Noise((NOISE_M**2,) * 3, 0.001, 1.5)
    fit, keep = nothing.selection.nominal, np.exp(-0.1 / 1.5)
    problem = fit.problem.with_noise(noise)
    expected = np.concatenate(noise_floors(replace(fit, problem=problem)))
    still = problem.with_noise(replace(noise, sigma=0.0))
    base = still.filter(fit.optimum.theta)
    squares = []
    for _ in range(150):
        kicks = rng.normal(size=(len(DRIVES), 1200)) * noise.sigma
        kicks[:, 1:] *= np.sqrt(1.0 - keep**2)
        pushed = replace(still, forcing=tuple(lfilter([1.0], [1.0, -keep], kicks))).filter(fit.optimum.theta)
        squares += [(a.innovation - b.innovation) ** 2 for a, b in zip(pushed, base, strict=True)]
    assert np.mean(expected**2) == pytest.approx(np.mean(squares) + NOISE_M**2, rel=0.15)


def test_flagged_ranges_count_only_where_the_diagnosis_explains_them(friction: Found) -> None:
    selection, verdict = friction.selection, friction.verdict
    flags = tuple(np.arange(f.size) % 50 == 7 for f in selection.setting.flags)
    flagged = replace(selection, setting=replace(selection.setting, flags=flags))
    gap = run_gaps(flagged, verdict, [0.25] * 4)[0]
    assert not gap.counts["refit"][7] and not gap.counts["diagnosed"][7]


def test_the_likelihoods_of_all_measurements_sum_to_the_fit_s(friction: Found) -> None:
    selection = friction.selection
    for fit in (selection.refit, friction.verdict.fit):
        assert sum(np.sum(part) for part in pointwise(selection, fit)) == pytest.approx(fit.log_likelihood)


def test_windows_of_all_runs_sum_to_the_gain(friction: Found) -> None:
    selection, windows = friction.selection, friction.place.windows
    gain = friction.verdict.fit.log_likelihood - selection.refit.log_likelihood
    assert sum(np.sum(w.gain) for w in windows) == pytest.approx(gain)
    assert all(np.allclose(np.diff(w.edges_s), 10.0, atol=0.05) for w in windows)


def test_windows_find_the_time_of_the_unknown_force(wave: Found) -> None:
    assert wave.verdict.kind == "unknown"
    spans = wave.place.document()["time_s"]
    assert {span["run"] for span in spans} == {"run_1"}
    assert 9.0 < min(span["from"] for span in spans) < 35.0
    assert 40.0 < max(span["to"] for span in spans) < 75.0  # its middle is held, its tail is too weak to tell


def test_the_unknown_force_is_taken_out_as_its_evidence_says(wave: Found) -> None:
    free = wave.selection.beyond
    before = sum(np.sum(f.innovation**2 / f.variance) for f in free.fit.filtered)
    after = sum(np.sum(f.innovation**2 / f.variance) for f in with_discrepancy(free))
    assert 0.5 * (before - after) > free.gain > 0.0  # the evidence pays for the size that was not known


def test_the_line_of_the_unknown_force(wave: Found) -> None:
    lines = wave.place.document()["frequency_rad_s"]
    assert {line["run"] for line in lines} == {"run_1"}
    line = min(lines, key=lambda line: abs(line["frequency"] - 0.9))
    assert line["frequency"] == pytest.approx(0.9, abs=0.06)
    assert line["multiple_of_drive"] is None
    assert line["false_alarm"] < 0.01


def test_friction_speaks_at_odd_multiples_of_the_drive(friction: Found) -> None:
    multiples = {line.multiple for spectrum in friction.place.spectra for line in spectrum.lines}
    assert multiples and multiples <= {1, 3, 5, 7}


def test_nothing_is_found_where_nothing_is(nothing: Found) -> None:
    document = nothing.place.document()
    assert nothing.verdict.kind == "none"
    assert document["time_s"] == [] and document["frequency_rad_s"] == []
    assert all(over["bins"] == [] for over in document["region"].values())
    assert all(run["share"] == 0.0 for run in document["runs"])
    assert document["channel"]["probability"]["none"] > 0.8


def test_a_force_is_recovered_bin_by_bin_and_under_its_own_variable() -> None:
    """Dry friction that the simulator does not have: of one size at every speed, and nothing over the others."""
    selection = select(recordings({"coulomb_friction.f": 0.002}, seed=20), ("coulomb_friction",))
    moved = motion(selection.named[0])
    edges = {name: bin_edges(np.concatenate(values)) for name, values in moved.items()}
    edges["surge_m_s"] = np.array([-0.3, -0.1, -0.05, -0.02, 0.0, 0.02, 0.05, 0.1, 0.3])
    force = missing_force(selection.nominal, moved, edges)
    mean, sd, gain = force["surge_m_s"]
    error = mean - np.repeat([0.002, -0.002], 4)
    assert np.all(np.abs(error) < 4.0 * sd + 5e-5)
    assert np.all(sd[[1, 6]] < 3e-4)
    for other in ("n_rev_s", "distance_m"):
        other_mean, other_sd, other_gain = force[other]
        assert gain > 10.0 * other_gain
        assert np.all(np.abs(other_mean) < 4.0 * other_sd + 5e-5)


@pytest.mark.slow
def test_bands_cover_a_known_force_of_each_bin() -> None:
    """Bins of propeller speed, a constant force in each: errors over deviations are at most standard normal."""
    edges = {"n_rev_s": np.array([-14.0, -7.0, 0.0, 7.0, 14.0])}
    truth = np.array([2e-4, -1e-4, 3e-4, -2e-4])
    deviations = []
    for seed in range(8):
        runs = recordings(seed=100 + 10 * seed, force=lambda t, u, n: truth[np.clip(int(n // 7.0) + 2, 0, 3)])
        fit = evaluate(prepare(runs, NOMINAL).with_noise(NOISE), Hypothesis(refit=False))
        mean, sd, _ = missing_force(fit, {"n_rev_s": [run.input for run in runs]}, edges)["n_rev_s"]
        deviations.append((mean - truth) / sd)
    assert np.abs(np.mean(deviations)) < 0.6
    assert 0.4 < np.std(deviations) < 1.4


def test_the_profile_of_the_diagnosed_simulator_is_flat(friction: Found) -> None:
    speed, *others = friction.place.profiles
    assert speed.significant.sum() >= 5
    assert speed.gain > 2.0 * max(other.gain for other in others)
    assert np.all(np.abs(speed.left) < speed.half_width)


def test_a_wave_does_not_pass_for_many_forces() -> None:
    """A water motion of its own rhythm is no function of speed, input or place: blocks differ, bands are wide."""
    runs = recordings({"seiche.amplitude": 0.01, "seiche.frequency": 0.9})
    profiles = find(runs, "seiche").place.profiles
    assert sum(int(p.significant.sum()) for p in profiles) <= 0.15 * sum(p.force.size for p in profiles)


def test_bins_have_zero_between_them_and_are_well_filled() -> None:
    values = np.concatenate([np.random.default_rng(0).normal(size=5000), [9.0, -0.5]])
    edges = bin_edges(values)
    counts = np.histogram(values, edges)[0]
    assert 0.0 in edges
    assert np.all(np.diff(edges) > 0.0)
    assert counts.sum() == values.size and counts.min() >= 0.02 * values.size


def test_bins_of_a_constant() -> None:
    assert np.histogram(np.full(10, 3.0), bin_edges(np.full(10, 3.0)))[0].sum() == 10


def test_the_summary_is_plain_data(friction: Found) -> None:
    document = locate(friction.selection, friction.verdict).document()
    assert json.loads(json.dumps(document, allow_nan=False)) == document == friction.place.document()
    assert set(document) == {"channel", "runs", "time_s", "frequency_rad_s", "region"}
    assert set(document["region"]) == {"surge_m_s", "n_rev_s", "distance_m"}
    assert document["region"]["surge_m_s"]["share"] > 0.3
