"""Causes without a name: each is found as what it is, by its channel, run and window, and nothing where nothing is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from recorded import (
    DRIVES,
    NOISE,
    NOISE_M,
    NOMINAL,
    differing,
    find,
    misread,
    record,
    recordings,
    select,
    sine,
    turbulent,
)

from vtank.diagnose.evidence import evaluate
from vtank.diagnose.freeform import Component, Freeform, pursue
from vtank.diagnose.freeform.dictionary import CHANNELS, SWINGING, rounded_lines
from vtank.diagnose.freeform.pursuit import _Pursuit
from vtank.diagnose.hypothesis import Hypothesis, about_their_mean
from vtank.diagnose.lines import loudest
from vtank.diagnose.lone_speeds import with_lone_speeds
from vtank.diagnose.selection import prepare
from vtank.estimate.observed import SPEED, Observed
from vtank.estimate.problem import Noise
from vtank.plant.parameters import slot

OWN = {name: float(NOMINAL[slot(name)]) for name in ("alpha", "beta", "thrust_lag.tau")}
SPREAD = np.array([0.06, -0.06, 0.03, -0.03])  # of a parameter that differs by run, over itself
SEEN = 5.0  # log evidence
PHASES = (0.3, 1.7, 4.0, 5.1)  # [rad] of a line in the four runs


def beside(runs: list[Observed], noise: Noise = NOISE) -> Freeform:
    """What the refit lacks, at a known noise level."""
    return pursue(evaluate(prepare(runs, NOMINAL).with_noise(noise), Hypothesis()))


def first(runs: list[Observed]) -> Component:
    """What is found first: it has most of the gain."""
    found = beside(runs)
    assert found.components[0].gain > max(SEEN, 0.8 * found.gain)
    return found.components[0]


def own(about: str, spread: np.ndarray = SPREAD) -> list[Observed]:
    """Four runs whose own parameter differs."""
    return differing([{about: OWN[about] * (1.0 + share)} for share in spread])


# --- nothing ---------------------------------------------------------------------------------------------------------
def coloured(seed: int) -> Callable[[np.ndarray], np.ndarray]:
    """A coloured error of the sonar, 6 mm with a memory of 0.5 s, anew for every run."""
    rng, keep = np.random.default_rng((seed, 2)), np.exp(-0.1 / 0.5)

    def error(t: np.ndarray) -> np.ndarray:
        out = NOISE_M * rng.normal(size=t.size)
        for k in range(1, t.size):
            out[k] = keep * out[k - 1] + np.sqrt(1.0 - keep**2) * out[k]
        return out

    return error


@pytest.mark.parametrize(
    "water", ["still", *(pytest.param(w, marks=pytest.mark.slow) for w in ("turbulent", "coloured"))]
)
@pytest.mark.parametrize("seed", [110, *(pytest.param(s, marks=pytest.mark.slow) for s in (120, 130))])
def test_nothing_is_found_where_nothing_is_missing(water: str, seed: int) -> None:
    if water == "turbulent":
        found = beside(
            recordings(seed=seed, force=turbulent(2e-3, 2.0, seed)), replace(NOISE, sigma=2e-3, correlation_time=2.0)
        )
    elif water == "coloured":
        runs = [misread(run, coloured(seed + k)) for k, run in enumerate(recordings(seed=seed))]
        found = beside(runs, replace(NOISE, colour_sigma=NOISE_M, colour_time=0.5))
    else:
        found = beside(recordings(seed=seed))
    assert found.components == () and found.left < 0.0 and found.gain == found.left
    assert found.channels == {"none": 1.0}


@pytest.mark.slow
def test_nothing_is_found_beside_the_effect_that_was_there() -> None:
    selection = select(recordings({"linear_drag.c": 0.1}), ("linear_drag",))
    (free,) = (free for free in selection.free if free.fit is selection.best)
    assert free.fit.hypothesis.name == "linear_drag" and free.left < 0.0 and not free.components


# --- own parameters that differ by run -------------------------------------------------------------------------------
@pytest.mark.slow
@pytest.mark.parametrize("share", [0.5, 1.0, 2.0])
@pytest.mark.parametrize("about", OWN)
def test_an_own_parameter_that_differs_by_run_varies_and_no_other(about: str, share: float) -> None:
    found = find(own(about, share * SPREAD), "linear_drag", "thrust_loss")
    assert found.verdict.kind == "varying" and found.verdict.varying == (about,)
    assert found.verdict.probability > 0.7
    assert found.verdict.channel == ("hydrodynamics" if about == "alpha" else "actuator")


def test_the_spread_of_the_thrust_is_measured() -> None:
    component = first(own("beta"))
    assert (component.kind, component.about, component.own, component.repeats) == ("run", "thrust", True, False)
    spread = component.coefficients - np.mean(component.coefficients)
    np.testing.assert_allclose(spread, SPREAD, atol=0.01)


def test_an_own_parameter_that_is_off_in_all_runs_alike_does_not_vary() -> None:
    found = beside(own("beta", np.full(4, 0.06)))
    assert not found.components and about_their_mean(found.by_run()) == ()


def test_what_varies_and_a_force_are_not_called_varying_alone() -> None:
    """The gain of a force beside it belongs to what has no name."""

    def push(t: float, u: float, n: float) -> float:
        return 0.003 * float(np.exp(-((u / 0.03) ** 2)))

    found = beside(differing([{"beta": OWN["beta"] * (1.0 + share)} for share in SPREAD], force=push))
    assert {c.kind for c in found.components[:2]} == {"run", "function"}
    assert all(c.gain > SEEN for c in found.components[:2]) and not found.own
    ((name, mean, spread),) = about_their_mean(found.by_run())
    assert (name, mean) == ("beta", pytest.approx(OWN["beta"], rel=0.05))
    assert spread == pytest.approx(OWN["beta"] * np.std(SPREAD), rel=0.2)


# --- functions of the motion -----------------------------------------------------------------------------------------
def placed(force: Callable[[float], float]) -> Callable[[float, float, float], float]:
    """A force over the place [m]."""
    place = [0.0]

    def push(t: float, u: float, n: float) -> float:
        place[0] = place[0] + 0.1 * u if t > 0.0 else 0.0
        return force(place[0])

    return push


def test_a_force_over_place_is_a_function_of_it() -> None:
    component = first(recordings(force=placed(lambda x: 0.002 * float(np.sin(2.0 * np.pi * x / 0.8)))))
    assert (component.kind, component.channel, component.force) == ("function", "hydrodynamics", True)
    assert "place" in component.about and component.repeats


@pytest.mark.parametrize("size", [0.001, 0.003])
def test_a_force_over_speed_is_a_function_of_it_and_has_its_shape(size: float) -> None:
    def law(u: np.ndarray) -> np.ndarray:
        return size * np.exp(-((u / 0.04) ** 2))

    found = beside(recordings(force=lambda t, u, n: float(law(np.asarray(u)))))
    component = found.components[0]
    assert (component.kind, component.channel, component.about) == ("function", "hydrodynamics", "speed")
    runs, p = found.fit.problem.runs, found.fit.vector()
    assert len(runs) == 4 and p.size == NOMINAL.size
    force = np.concatenate(found.forces())
    assert np.max(force) == pytest.approx(size, rel=0.35)


def test_a_force_of_any_size_is_not_taken_for_thrust_that_wanders() -> None:
    """Whatever acts at speed could be called a thrust that comes and goes; what repeats is more probable."""
    for size in (0.003, 0.02):
        kinds = [c.kind for c in beside(recordings(force=lambda t, u, n, s=size: s * np.tanh(u / 0.05))).components]
        assert kinds[0] == "function" and "wander" not in kinds


def test_inertia_that_grows_with_speed_is_a_force() -> None:
    last = [0.0]

    def force(t: float, u: float, n: float) -> float:
        rate, last[0] = (u - last[0]) / 0.1 if t > 0.0 else 0.0, u
        return -16.0 * u * u * rate

    component = first(recordings(force=force))
    assert component.kind == "function" and component.force


@pytest.mark.slow
# --- what comes and goes ---------------------------------------------------------------------------------------------
def test_a_thrust_gain_that_wanders_is_found_as_one() -> None:
    component = first(recordings(force=lambda t, u, n: 0.15 * OWN["beta"] * n * abs(n) * np.sin(0.31 * t)))
    assert (component.kind, component.channel, component.about) == ("wander", "actuator", "thrust")
    assert component.windows and not component.own


@pytest.mark.slow
def test_drag_in_a_window_of_one_run_is_found_there() -> None:
    runs = recordings()
    runs[2] = record(
        "run_2", sine(*DRIVES[2]), NOMINAL, NOISE_M, 2, lambda t, u, n: -1.0 * u * abs(u) * (42.0 <= t < 75.0)
    )
    found = beside(runs)
    assert {(c.kind, c.channel, c.about) for c in found.components} == {("window", "hydrodynamics", "drag")}
    windows = [window for c in found.components for window in c.windows]
    assert {run for run, _, _ in windows} == {2}
    start, stop = min(w[1] for w in windows), max(w[2] for w in windows)
    assert (start, stop) == pytest.approx((42.0, 75.0), abs=3.1)  # a bin
    assert all(c.coefficients[0] == pytest.approx(-1.0, abs=0.3) for c in found.components)
    assert [np.any(force != 0.0) for force in found.forces()] == [False, False, True, False]


@pytest.mark.parametrize(("start", "stop"), [(41.3, 49.6), (70.8, 92.1)])
def test_a_window_begins_and_ends_where_it_does(start: float, stop: float) -> None:
    """A sonar that is off for a while: to within a few pings, however wide the bins of the search."""
    first, *rest = recordings()
    found = beside([misread(first, lambda t: 0.05 * ((t > start) & (t < stop))), *rest])
    [(run, begins, ends)] = found.components[0].windows
    assert run == 0 and abs(begins - start) < 0.4 and abs(ends - stop) < 0.4
    assert (found.components[0].kind, found.components[0].channel) == ("window", "sensor")


def lined(rad_s: float, sizes_m: tuple[float, ...] = (0.006,) * 4) -> list[Observed]:
    """Four runs whose sonar errs at one frequency, in phases of their own."""
    parts = zip(recordings(), PHASES, sizes_m, strict=True)
    return [misread(run, partial(_wave, rad_s, phase, size)) for run, phase, size in parts]


def _wave(rad_s: float, phase: float, size_m: float, t: np.ndarray) -> np.ndarray:
    return np.asarray(size_m * np.sin(rad_s * t + phase))


@pytest.mark.parametrize("rad_s", [0.9, 2.0, 3.1])
def test_an_error_of_the_sonar_at_one_frequency_is_a_line_of_the_sensor(rad_s: float) -> None:
    found = beside(lined(rad_s))
    lines = [c for c in found.components if (c.kind, c.channel, c.force) == ("line", "sensor", False)]
    assert lines[0] is found.components[0] and lines[0].frequency == pytest.approx(rad_s, abs=0.03)
    assert sum(c.gain for c in lines) > 0.95 * found.gain > SEEN


@pytest.mark.parametrize(("rad_s", "sizes_m"), [(3.1, (0.006,) * 4), (0.9, (0.012, 0.002, 0.008, 0.004))])
def test_an_error_of_the_sonar_that_no_water_makes_is_no_seiche(rad_s: float, sizes_m: tuple[float, ...]) -> None:
    """Faster than any standing wave of a tank, or of another size in every run; else the two are one motion."""
    found = find(lined(rad_s, sizes_m), "seiche", "linear_drag")
    assert found.verdict.kind == "unknown" and found.verdict.channel == "sensor"


def test_a_force_that_goes_by_posts_is_periodic_in_place() -> None:
    """Too fast over the way for a smooth function."""
    component = first(recordings(force=placed(lambda x: 0.001 * float(np.sin(2.0 * np.pi * x / 0.3)))))
    assert (component.channel, component.about, component.repeats) == ("hydrodynamics", "place, periodic", True)


@pytest.mark.parametrize("period_s", [3.5, 11.0])
def test_a_delay_that_two_clocks_beat_is_a_line_of_the_latency(period_s: float) -> None:
    """A sonar that is polled by another clock is late by a sawtooth; the range is off by that times the speed."""

    def late(run: Observed, phase: float) -> Observed:
        speed = np.gradient(run.value, run.time_s)
        smooth = np.convolve(speed, np.ones(15) / 15.0, mode="same")
        return misread(run, lambda t: -0.15 * smooth * (np.mod(t / period_s + phase, 1.0) - 0.5))

    found = beside([late(run, phase) for run, phase in zip(recordings(), PHASES, strict=True)])
    assert (found.components[0].kind, found.components[0].about) == ("line", "latency, periodic")
    assert found.components[0].frequency == pytest.approx(2.0 * np.pi / period_s, rel=0.02)
    assert found.channel == "sensor" and found.gain > SEEN


def ringing(rad_s: float, damping: float, seed: int, t: np.ndarray) -> np.ndarray:
    """A resonance that white noise drives, as large as the sonar's noise; damping [1/s]."""
    step, rng = float(np.median(np.diff(t))), np.random.default_rng((seed, 7))
    keep, out = np.exp((-damping + 1j * rad_s) * step), np.zeros(t.size, complex)
    driven = rng.normal(size=(2, t.size)) * np.sqrt(1.0 - abs(keep) ** 2) * NOISE_M
    for k in range(1, t.size):
        out[k] = keep * out[k - 1] + driven[0, k] + 1j * driven[1, k]
    return out.real


@pytest.mark.parametrize("rad_s", [2.2, 5.0])
def test_a_broad_peak_of_noise_is_no_line(rad_s: float) -> None:
    """As loud as a line at its top, and nearly so beside it: a resonance that white noise drives, shape after shape."""
    damping = 0.08 * rad_s
    found = beside([misread(run, partial(ringing, rad_s, damping, k)) for k, run in enumerate(recordings())])
    lines = loudest(found.fit)
    assert lines.level[0] > 3.0 and abs(lines.rad_s[0] - rad_s) < 2.0 * damping
    assert not any(c.kind == "line" for c in found.components)


@pytest.mark.parametrize("rad_s", [0.9, 1.3])
def test_a_sonar_that_swings_with_no_phase_for_long_is_no_seiche(rad_s: float) -> None:
    """A boom or a bracket in waves: a band of frequencies, where a standing wave has one."""
    runs = [misread(run, partial(ringing, rad_s, 0.05, k)) for k, run in enumerate(recordings())]
    found = find(runs, "seiche", "linear_drag")
    assert (found.verdict.kind, found.verdict.channel) == ("unknown", "sensor")
    assert found.selection.beyond.components[0].about == SWINGING
    assert found.verdict.probability < 0.9  # noise to another


def test_a_sonar_that_errs_while_the_motor_works_goes_with_the_input() -> None:
    """Of a supply that gives way: with how hard, whichever way, which neither place nor speed tell."""
    runs = [misread(run, lambda t, run=run: 0.03 * np.abs(run.input / 8.0) ** 3) for run in recordings()]  # type: ignore[misc]
    found = beside(runs)
    assert found.channel == "sensor" and found.components[0].about == "input"


def test_a_seiche_is_no_line_of_the_sensor() -> None:
    found = find(recordings({"seiche.amplitude": 0.01, "seiche.frequency": 0.9}), "seiche", "linear_drag")
    assert found.verdict.effects == ("seiche",) and found.verdict.channel == "hydrodynamics"


# --- what is found in the input --------------------------------------------------------------------------------------
@pytest.mark.parametrize("spiked", [True, False])
def test_readings_that_the_hull_did_not_follow_are_noticed(spiked: bool) -> None:
    """The same jumps on record: in the tachometer alone, or of the propeller itself."""
    rng = np.random.default_rng(12)
    runs = recordings()
    jumps = [5.0 * rng.choice([-1.0, 0.0, 1.0], run.input.size, p=[0.02, 0.96, 0.02]) for run in runs]
    if spiked:
        found = beside([replace(run, input=run.input + jump) for run, jump in zip(runs, jumps, strict=True)])
    else:
        drives = [sine(*drive) + jump for drive, jump in zip(DRIVES, jumps, strict=True)]
        true = [record(f"run_{k}", drive, NOMINAL, NOISE_M, k) for k, drive in enumerate(drives)]
        assert all(np.mean(run.lone != 0.0) > 0.02 for run in with_lone_speeds(true))
        found = beside(true)
    assert (found.gain > SEEN) == spiked
    assert not spiked or found.components[0].channel == "actuator"


def test_a_quick_error_of_the_sonar_is_a_line_and_no_noise() -> None:
    """Well above what a hull can do, where only the loudest frequencies of the innovations are looked at."""
    runs = [replace(r, value=r.value + 0.01 * np.sin(7.3 * r.time_s + k)) for k, r in enumerate(recordings())]
    found = find(runs, "linear_drag", "seiche")
    assert found.verdict.kind == "unknown" and found.verdict.channel == "sensor"
    lines = [c for c in found.selection.beyond.components if c.kind == "line"]
    assert lines and abs(lines[0].frequency - 7.3) < 0.06


@pytest.mark.parametrize("noise_step", [0.0, 0.2, 0.4])
def test_rounding_makes_lines_of_evenly_moving_readings_as_foretold(noise_step: float) -> None:
    """Against the spectrum of rounded readings; those that move faster than a step in a period make none."""
    step, speed, t = 0.02, 0.031, np.arange(0.0, 400.0, 0.02)
    readings = speed * t + noise_step * step * np.random.default_rng(3).normal(size=t.size)
    error, w = step * np.round(readings / step) - readings, 2.0 * np.pi * speed / step
    line = 2.0 * abs(np.mean(error * np.exp(-1j * w * t)))
    variance = (noise_step * step) ** 2 + step**2 / 12.0
    most, slower = rounded_lines(np.array([1.001 * w, 0.9 * w]), step, variance, np.full(3, speed), np.zeros(3))
    assert most == pytest.approx(line, abs=0.01 * step)
    assert slower == 0.0


@pytest.mark.parametrize("drive_rad_s", [0.3, 0.7])
@pytest.mark.parametrize("noise_step", [0.0, 0.3])
def test_rounding_makes_lines_of_a_motion_that_repeats_itself_no_larger_than_foretold(
    noise_step: float, drive_rad_s: float
) -> None:
    """At the drive and its multiples, where the readings turn round; several times what their usual speed foretells."""
    step, t, largest = 0.025, np.arange(0.0, 40.0 * np.pi / drive_rad_s, 0.02), np.zeros(8)
    speeds, rates = (0.3 * drive_rad_s**k * np.cos(drive_rad_s * t + 0.5 * np.pi * (k - 1)) for k in (1, 2))
    lines = drive_rad_s * np.arange(1, 9)
    for seed in range(12):
        rng = np.random.default_rng(seed)
        readings = 0.3 * np.sin(drive_rad_s * t) + step * (rng.uniform() + noise_step * rng.normal(size=t.size))
        error = step * np.round(readings / step) - readings
        made = 2.0 * np.abs(np.exp(-1j * np.outer(lines, t)) @ error) / t.size
        largest = np.maximum(largest, made)
    variance = (noise_step * step) ** 2 + step**2 / 12.0
    most = rounded_lines(lines, step, variance, speeds, rates)
    scatter = 4.0 * step * np.sqrt(2.0 / (12.0 * t.size))  # of what noise spreads over all frequencies
    assert np.all(largest < most + scatter) and np.all(most < 4.0 * largest.max())
    evenly = rounded_lines(lines, step, variance, speeds, np.zeros(t.size))
    assert largest[0] > 2.0 * evenly[0] or noise_step


def test_an_error_of_a_speed_log_is_told_in_its_unit() -> None:
    """It warms up by 2 cm/s in every run; own parameters take up some of that."""
    runs = []
    for k, drive in enumerate(DRIVES):
        run = record(f"run_{k}", sine(*drive), NOMINAL, 0.0, k)
        speed = np.gradient(-run.value, run.time_s) + 0.02 * (1.0 - np.exp(-run.time_s / 30.0))
        speed += 0.003 * np.random.default_rng(k).normal(size=speed.size)
        runs.append(replace(run, value=speed, kind=np.full(speed.size, SPEED)))
    found = beside(runs, Noise((0.003**2,) * 3, 1e-4, 1.0))
    assert found.gain > SEEN and found.channel == "sensor"
    assert np.ptp(np.concatenate(found.errors())) == pytest.approx(0.02, rel=0.5)


def test_lags_that_differ_much_are_fitted_where_they_are() -> None:
    """To first order about their mean they are far off."""
    true = OWN["thrust_lag.tau"] * np.array([0.7, 1.0, 1.6, 2.3])
    runs = differing([{"thrust_lag.tau": tau} for tau in true])
    varying = next(f.fit for f in select(runs, ("linear_drag",)).free if f.fit.hypothesis.varying)
    assert varying.start()["thrust_lag.tau"] == pytest.approx(true, rel=0.03)
    ((mean, spread),) = [(m, sd) for name, m, sd in varying.hypothesis.varying if name == "thrust_lag.tau"]
    assert (mean, spread) == pytest.approx((true.mean(), true.std()), rel=0.1)


def test_readings_of_two_sensors_at_the_same_instants_are_pursued() -> None:
    """Their stamps come in pairs, so that half of the steps between readings are none."""
    runs = []
    for run in recordings()[:2]:
        both, order = np.concatenate([run.time_s, run.time_s]), np.argsort([*run.time_s, *run.time_s], kind="stable")
        speed = np.gradient(-run.value, run.time_s)
        value, kind = np.concatenate([run.value, speed]), np.concatenate([run.kind, np.full(run.kind.size, SPEED)])
        runs.append(replace(run, time_s=both[order], value=value[order], kind=kind[order]))
    assert np.isfinite(find(runs, "linear_drag").selection.beyond.left)


@pytest.mark.parametrize(("pitched_m", "gap"), [(0.5e-3, False), (8e-3, True)])
def test_a_hull_that_pitches_a_little_is_no_gap(pitched_m: float, gap: bool) -> None:
    """A sonar off the axis reads what accelerates the hull; a fine sonar, many pings, and each run likewise."""

    def pitched(run: Observed) -> Observed:
        rate = np.gradient(np.gradient(run.value, run.time_s), run.time_s)
        smooth = np.convolve(rate, np.hanning(41) / np.hanning(41).sum(), mode="same")
        return replace(run, value=run.value + pitched_m * smooth / np.sqrt(np.mean(smooth**2)))

    clean = [record(f"run_{k}", sine(*drive), NOMINAL, 0.0, k) for k, drive in enumerate(DRIVES)]
    rng = np.random.default_rng(3)
    runs = [replace(run, value=run.value + 1e-3 * rng.normal(size=run.time_s.size)) for run in map(pitched, clean)]
    found = beside(runs, replace(NOISE, variance=(1e-6, 1e-6, 1e-6)))
    assert found.components
    assert (found.pitching > 0.0) is gap


def test_the_channel_is_that_which_could_hold_all_of_it() -> None:
    """Whatever it was found as piece by piece, a hump of the drag is held by the force of the water."""
    found = beside(
        recordings(force=lambda t, u, n: -0.006 * float(np.sign(u) * np.exp(-(((abs(u) - 0.08) / 0.02) ** 2))))
    )
    start = _Pursuit(found.fit)
    alone = {channel: start.followed(wandering=False, channels=[channel]) for channel in CHANNELS}
    assert all(c.channel == channel for channel, free in alone.items() for c in free.components)
    assert max(alone, key=lambda channel: alone[channel].gain) == found.channel == "hydrodynamics"
    mixed = replace(found, components=tuple(free.components[0] for free in alone.values())).channels
    assert sum(mixed.values()) == pytest.approx(1.0)
    odds = mixed["actuator"] / mixed["hydrodynamics"]
    assert odds == pytest.approx(np.exp(alone["actuator"].gain - alone["hydrodynamics"].gain))
