"""The public library: light to import, typed, documented, and the same as the command line."""

from __future__ import annotations

import ast
import inspect
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from recorded import NOMINAL, record, sine

import vtank as vt
from vtank.cli import main
from vtank.effects.catalogue import BY_NAME
from vtank.plant.parameters import vector

HEAVY = {"numpy", "scipy", "numba", "mujoco", "matplotlib"}


def loaded(code: str, **environment: str) -> list[str]:
    """What a fresh interpreter prints."""
    clean = {key: value for key, value in os.environ.items() if not key.endswith("_NUM_THREADS")}
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=True, env=clean | environment).stdout.split()


def test_importing_loads_nothing_heavy() -> None:
    assert not HEAVY & set(loaded("import sys, vtank; dir(vtank); print(*sys.modules)"))


def test_looking_at_recordings_needs_numpy_alone() -> None:
    assert HEAVY & set(loaded("import sys, vtank; vtank.Run, vtank.load; print(*sys.modules)")) == {"numpy"}


def test_a_diagnosis_needs_no_tank_nor_what_is_slow_to_load() -> None:
    there = loaded("import sys; from vtank.diagnose import diagnosis; print(*sys.modules)")
    assert not {"mujoco", "scipy.stats", "scipy.signal"} & set(there)


@pytest.mark.parametrize(
    ("given", "expected"),
    [({}, "1 None"), ({"OPENBLAS_NUM_THREADS": "3"}, "3 None"), ({"OMP_NUM_THREADS": "2"}, "None 2")],
)
def test_one_blas_thread_unless_the_user_has_chosen(given: dict[str, str], expected: str) -> None:
    code = "import os, vtank; print(*(os.environ.get(f'{name}_NUM_THREADS') for name in ('OPENBLAS', 'OMP')))"
    assert loaded(code, **given) == expected.split()


@pytest.mark.parametrize("name", vt.__all__)
def test_every_public_name_is_there_and_documented(name: str) -> None:
    public = getattr(vt, name)
    assert name in dir(vt)
    assert public.__doc__ and not public.__doc__.startswith(f"{name}("), name  # as a dataclass without words would have
    members = vars(public).items() if inspect.isclass(public) else ()
    for member, value in members:
        value = getattr(value, "func", getattr(value, "fget", value))
        if not member.startswith("_") and inspect.isfunction(value):
            assert value.__doc__, f"{name}.{member}"


def test_a_function_is_not_hidden_by_the_package_of_its_name() -> None:
    code = "import vtank, vtank.diagnose.selection, vtank.effects.catalogue; from vtank import diagnose"
    assert loaded(f"{code}; print(callable(vtank.diagnose), callable(diagnose), len(vtank.effects()))") == [
        "True", "True", str(len(BY_NAME)),
    ]  # fmt: skip


def test_a_name_that_is_not_there_is_told() -> None:
    with pytest.raises(AttributeError, match="'vtank' has no attribute 'lood'; did you mean 'load'?"):
        getattr(vt, "lood")  # noqa: B009
    with pytest.raises(AttributeError, match="'vtank' has no attribute 'simulate'"):
        _ = vt.simulate


def test_what_type_checkers_see_is_what_is_loaded() -> None:
    tree = ast.parse(Path(vt.__file__).read_text(encoding="utf-8"))
    lazy = next(node for node in tree.body if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING")
    seen = {alias.name for node in lazy.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert seen | {"InputError"} == set(vt.__all__)


def test_runs_are_simulated_written_and_loaded(tmp_path: Path) -> None:
    short = {"settings": ["duration_s=6"], "simulator": "surge", "seed": 3}
    runs = vt.run("open-loop-sine", "step-coast", out=tmp_path / "data", **short)
    assert [run.name for run in runs] == ["open-loop-sine", "step-coast"] and runs[0].duration_s == 6.0
    assert (tmp_path / "data" / "truth.json").exists()
    again = vt.load(tmp_path / "data")
    np.testing.assert_allclose(again[1].columns["range_m"], runs[1].columns["range_m"], atol=1e-6)
    assert vt.run("step-coast", **short)[0].name == "step-coast"


def test_a_model_is_identified() -> None:
    runs = vt.run("open-loop-sine", seed=1, simulator="surge", settings=["duration_s=60"])
    fit = vt.identify(runs, model="II")
    truth = vt.load_truth("paper-ii")
    assert list(fit.values) == list(fit.sd) == ["alpha", "beta", "thrust_lag.tau"]
    assert abs(fit.values["alpha"] - truth.alpha_per_m) < 4.0 * fit.sd["alpha"]
    with pytest.raises(vt.InputError, match="no model 'IV'; .*there are: I, II, III"):
        vt.identify(runs, model="IV")


@pytest.fixture(scope="module")
def diagnosis() -> vt.Diagnosis:
    """Of three runs with linear drag, among three effects."""
    runs, p = [], vector({"linear_drag.c": 0.15}, NOMINAL)
    for k, drive in enumerate(((0.5, 12.0), (0.35, 10.0), (0.8, 14.0))):
        seen = record(f"run_{k}", sine(*drive, duration_s=60.0), p, 0.004, k)
        runs.append(vt.Run(seen.name, seen.time_s, {"n_rev_s": seen.input, "range_m": seen.value}))
    told: list[str] = []
    names = ("linear_drag", "ambient_current", "thrust_deadband")
    found = vt.diagnose(runs, nominal=NOMINAL, effects=names, progress=told.append)
    assert "where the gap lies" not in told  # only when it is asked for
    assert found.where is found.where
    assert told.count("where the gap lies") == 1
    return found


def test_a_diagnosis_tells_what_was_found(diagnosis: vt.Diagnosis) -> None:
    assert diagnosis.verdict.effects == ("linear_drag",)
    assert diagnosis.probabilities["linear_drag"] > 0.8
    best = max(diagnosis.log_evidence, key=lambda name: diagnosis.log_evidence[name])
    assert {"none", "parameters", best} <= set(diagnosis.log_evidence) and "linear_drag" in best
    assert diagnosis.held_out["fraction_closed"] > 0.9
    assert diagnosis.next_experiment["minutes"] > 0.0
    assert diagnosis.budget.nominal == pytest.approx(diagnosis.held_out["nominal"])  # on the same parts left out
    assert diagnosis.left_out is diagnosis.left_out
    assert diagnosis.document["where"] == diagnosis.where.document()
    assert repr(diagnosis).startswith("Diagnosis(effect: linear_drag, 0.") and len(repr(diagnosis)) < 80


def test_a_choice_of_effects_is_told(diagnosis: vt.Diagnosis) -> None:
    told = " ".join(str(diagnosis).split())
    assert "No other effects were considered than linear drag, ambient current and thrust deadband." in told


def test_a_diagnosis_is_printed_shown_and_kept(diagnosis: vt.Diagnosis, tmp_path: Path) -> None:
    assert str(diagnosis).startswith("Compared with given parameters. The gap is caused by linear drag.\n")
    assert diagnosis._repr_html_().startswith("<iframe ")
    diagnosis.report(tmp_path / "gap.html")
    assert (tmp_path / "gap.html").read_text(encoding="utf-8").startswith("<!doctype html>")
    diagnosis.write_json(tmp_path / "gap.json")
    assert json.loads((tmp_path / "gap.json").read_text(encoding="utf-8")) == diagnosis.document


def test_a_saved_model_predicts_a_run(diagnosis: vt.Diagnosis, tmp_path: Path) -> None:
    diagnosis.save(tmp_path / "gap.toml")
    seen = record("unseen", sine(0.3, 10.0, 60.0), vector({"linear_drag.c": 0.15}, NOMINAL), 0.004, 9)
    unseen = vt.Run("unseen", seen.time_s, {"n_rev_s": seen.input, "range_m": seen.value})
    found = vt.predict(tmp_path / "gap.toml", unseen)
    assert found["rms"]["diagnosed"] < 0.5 * found["rms"]["nominal"]
    assert vt.load_truth(tmp_path / "gap.toml").effects["linear_drag.c"] == pytest.approx(0.15, rel=0.1)


def test_a_nominal_is_a_name_a_preset_a_vector_or_none() -> None:
    from vtank.diagnose.given import nominal_of, observed

    run = observed(vt.run("open-loop-sine", seed=1, simulator="surge", settings=["duration_s=20"]))[0]
    truth = vt.load_truth("paper-ii")
    for nominal in ("paper-ii", truth, truth.vector()):
        np.testing.assert_array_equal(nominal_of(nominal, run).p, truth.vector())
    assert nominal_of("none", run).p is None
    with pytest.raises(vt.InputError, match=r"shape \(3,\), expected"):
        nominal_of(np.zeros(3), run)
    with pytest.raises(vt.InputError, match="no runs"):
        vt.diagnose([])


def test_runs_may_be_given_by_where_they_lie_and_nothing_else_is_taken_for_one(tmp_path: Path) -> None:
    vt.run("paper-ds1", seed=1, out=tmp_path / "data")
    (run,) = vt.load(tmp_path / "data")
    (file,) = (tmp_path / "data").glob("*.csv")
    given = (tmp_path / "data", str(tmp_path / "data"), run, [run], [file], [str(file)])
    values = [vt.identify(some).values for some in given]
    assert all(np.array_equal(list(v.values()), list(values[0].values())) for v in values)
    with pytest.raises(vt.InputError, match="nowhere.csv: cannot be read"):
        vt.diagnose([tmp_path / "nowhere.csv"])
    for wrong in ([0.0, 1.0], [None]):
        with pytest.raises(vt.InputError, match="expected runs, as vt.load gives them"):
            vt.diagnose(wrong)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"simulator": "foo"}, "simulator 'foo': expected tank or surge"),
        ({"seed": -1}, "seed -1: expected a whole number of at least 0"),
        ({"seed": 0.5}, "seed 0.5: expected a whole number"),
        ({"threads": 0}, "threads 0: expected a whole number of at least 1"),
        ({"settings": "duration_s=4"}, "settings 'duration_s=4': found a text, expected a list"),
    ],
)
def test_what_a_simulation_cannot_be_told_is_refused(arguments: dict, said: str) -> None:
    with pytest.raises(vt.InputError, match=said):
        vt.run("paper-ds1", **arguments)


@pytest.mark.parametrize("times", [(0.0, 2.0, 1.0), (0.0, 1.0, 1.0), (0.0, 1.0, np.nan)])
def test_runs_whose_times_do_not_rise_are_refused(times: tuple[float, ...]) -> None:
    run = vt.Run("bent", np.array(times), {"n_rev_s": np.ones(3), "range_m": np.ones(3)})
    for command in (vt.identify, vt.diagnose, lambda run: vt.predict("model.toml", run)):
        with pytest.raises(vt.InputError, match="run bent: time_s: expected finite times, each later"):
            command(run)
    with pytest.raises(vt.InputError, match="seed -1"):
        vt.diagnose(run, seed=-1)


def test_axes_are_not_passed_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of a run along one axis there is nothing that they could choose."""
    path = tmp_path / "run.csv"
    path.write_text("time_s,n_rev_s,range_m\n" + "".join(f"{0.1 * k:g},{k % 7},3\n" for k in range(99)))
    assert main(["identify", str(path), "--axes", "surge"]) == 2
    assert "--axes: goes with --nominal" in capsys.readouterr().err
