"""Recordings that contradict themselves or the simulator: a verdict, or one line that names the data, no traceback.

No warning of NumPy or SciPy leaks, and no NaN gets into the findings.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from vtank.cli import main
from vtank.diagnose import evidence, selection
from vtank.effects.catalogue import BY_NAME
from vtank.errors import InputError
from vtank.estimate.observed import observe
from vtank.estimate.problem import Problem
from vtank.library import identify
from vtank.record import Run, write_run

T = 0.1 * np.arange(300)
DRIVE, RANGE = 10.0 * np.cos(T), 3.0 - 0.4 * np.sin(T)  # a hull that goes with its propeller and knows no inertia
ONCE = np.where(T == 0.0, 10.0, np.nan)

VERDICTS = {  # recordings that end in a verdict
    "propeller reversed": {"n_rev_s": -DRIVE, "range_m": RANGE},
    "position, propeller reversed": {"n_rev_s": -DRIVE, "position_m": 3.0 - RANGE},
    "range against speed": {"n_rev_s": DRIVE, "range_m": RANGE, "surge_m_s": -0.4 * np.cos(T)},
    "range all zero": {"n_rev_s": DRIVE, "range_m": 0.0 * T},
    "huge thrust": {"n_rev_s": 19.9 * DRIVE, "range_m": RANGE},
    "hardly any thrust": {"n_rev_s": 1e-7 * DRIVE, "range_m": RANGE},
    "constant input": {"n_rev_s": 0.0 * T + 10.0, "range_m": RANGE},
    "round the world": {"n_rev_s": DRIVE, "range_m": 3e7 - 1e7 * np.sin(T)},
    "no noise at all": {"n_rev_s": DRIVE, "range_m": RANGE},
}
IDENTIFIED = {
    "propeller reversed": VERDICTS["propeller reversed"],
    "range all zero": VERDICTS["range all zero"],
    "hardly any motion": {"n_rev_s": DRIVE, "range_m": 3.0 - 1e-9 * np.sin(T)},
    "huge force": {"thrust_N": 1e7 * DRIVE, "range_m": RANGE},
    "weak force": {"thrust_N": 1e-10 * DRIVE, "range_m": RANGE},
}
Columns = dict[str, np.ndarray]


@pytest.fixture
def recording(tmp_path: Path) -> Callable[[Columns], Path]:
    def written(columns: Columns) -> Path:
        write_run(tmp_path / "run.csv", Run("run", T, columns))
        return tmp_path / "run.csv"

    return written


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two effects instead of the whole catalogue, for speed."""
    chosen = [BY_NAME[name] for name in ("linear_drag", "wall_proximity")]
    monkeypatch.setattr(selection, "candidates", lambda nominal, runs, names: chosen)


def finite(content: object) -> bool:
    """Whether JSON text says so; it raises on NaN."""
    return bool(json.dumps(content, allow_nan=False))


@pytest.mark.slow
@pytest.mark.parametrize("name", VERDICTS)
def test_the_diagnosis_ends_in_a_verdict(
    name: str, recording: Callable[[Columns], Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, model = tmp_path / "d.json", tmp_path / "d.toml"
    assert main(["diagnose", str(recording(VERDICTS[name])), "--json", str(out), "--model", str(model)]) == 0
    captured = capsys.readouterr()
    assert "RuntimeWarning" not in captured.err and " nan" not in captured.out
    assert finite(json.loads(out.read_text())) and "nan" not in model.read_text()


def test_an_input_in_one_row_is_refused(
    recording: Callable[[Columns], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["diagnose", str(recording({"n_rev_s": ONCE, "range_m": RANGE}))]) == 2
    assert capsys.readouterr().err.startswith("vtank: error: run run: one value of n_rev_s, expected")


def test_recordings_that_no_simulator_follows_are_refused(
    recording: Callable[[Columns], Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(evidence, "LOST", 0.0)  # so that every filter counts as lost
    assert main(["diagnose", str(recording(VERDICTS["no noise at all"]))]) == 2
    assert "vtank: error: run run: no simulator follows these recordings" in capsys.readouterr().err


@pytest.mark.parametrize("name", IDENTIFIED)
def test_the_likelihood_ends_in_estimates(
    name: str, recording: Callable[[Columns], Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "found.json"
    arguments = ["--model", "II", "--method", "ml", "--json", str(out)]
    assert main(["identify", str(recording(IDENTIFIED[name])), *arguments]) == 0
    assert "RuntimeWarning" not in capsys.readouterr().err
    assert finite(json.loads(out.read_text()))


def test_the_likelihood_of_a_run_round_the_world_ends_in_estimates_or_in_a_reason(
    recording: Callable[[Columns], Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = recording(VERDICTS["round the world"]), tmp_path / "found.json"
    failed = main(["identify", str(path), "--model", "II", "--method", "ml", "--json", str(out)])
    told = capsys.readouterr().err
    assert "RuntimeWarning" not in told  # which of the two it is, rounding decides
    assert "do not tell the model's parameters apart" in told if failed else finite(json.loads(out.read_text()))


def test_numbers_beyond_any_vehicle_are_refused() -> None:
    for name in ("n_rev_s", "range_m"):
        columns = {"n_rev_s": DRIVE, "range_m": RANGE}
        columns[name] = np.where(T == 0.0, 1e300, columns[name])
        with pytest.raises(InputError, match=rf"run 'run': {name} reaches 1e\+300"):
            observe(Run("run", T, columns))


def test_an_optimum_that_is_no_number_gives_no_estimates(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a search ends among simulations that run away, as some corrupt ranges in mm have made it."""
    monkeypatch.setattr(Problem, "log_likelihood", lambda problem, filtered: np.nan)
    with pytest.raises(InputError, match="the model runs away on these recordings, and its likelihood is no number"):
        identify([Run("run", T, {"n_rev_s": DRIVE, "range_m": RANGE})], "II")


def bursts(steps_s: np.ndarray) -> str:
    """A recording of 300 rows at these stamps."""
    rng = np.random.default_rng(0)
    rows = [(t, 10.0 * np.cos(t), 3.0 - 0.4 * np.sin(t) + 0.004 * rng.standard_normal()) for t in steps_s]
    return "time_s,n_rev_s,range_m\n" + "".join(f"{t:.12g},{n:.4f},{r:.4f}\n" for t, n, r in rows)


@pytest.mark.parametrize("apart_s", [1e-6, 1e-4])
@pytest.mark.parametrize("many", [2, 5])
def test_rows_in_bursts_are_diagnosed(many: int, apart_s: float, tmp_path: Path) -> None:
    """The usual step is then that within a burst, by which the rest was thinned to nothing."""
    times = np.sort(np.concatenate([0.1 * many * np.arange(300 // many) + apart_s * k for k in range(many)]))
    (tmp_path / "run.csv").write_text(bursts(times))
    assert main(["diagnose", str(tmp_path / "run.csv")]) == 0


@pytest.mark.parametrize("step_s", [1e-10, 1e-7, 1e-5, 1e-4])
def test_times_in_another_unit_are_told(step_s: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "run.csv").write_text(bursts(step_s * np.arange(300)))
    assert main(["diagnose", str(tmp_path / "run.csv")]) == 2
    assert "is time_s in another unit?" in capsys.readouterr().err
