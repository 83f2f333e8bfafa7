"""One answer everywhere: what is printed, written as JSON, filed and predicts is one fit, whatever the input's kind."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from recorded import NOMINAL, record, sine

import vtank as vt
from vtank.diagnose.foreign import explained
from vtank.diagnose.holdout import Prediction, model_of, rms, target_of
from vtank.diagnose.simulator_file import read_simulator
from vtank.diagnose.thinning import straightened
from vtank.estimate.observed import observe
from vtank.plant.parameters import slot, vector
from vtank.plant.truth import load_truth
from vtank.present.words import number

NOISE_M = 0.003
MASS_KG = 80.0
HULL = vector({"thrust_lag.tau": 0.0}, NOMINAL)  # without a lag: Model I, and what a case adds
KINDS = {  # input -> largest value, what the vehicle has besides drag and thrust, where in the file, the key there
    "n_rev_s": (12.0, {"linear_drag.c": 0.2}, ("linear_drag", "c_per_s")),
    "command": (0.8, {"thrust_saturation.n_max": 0.5}, ("thrust_saturation", "n_max")),
    "thrust_N": (20.0, {"coulomb_friction.f": 0.02, "force_offset": -2.0}, ("coulomb_friction", "f_m_s2")),
}


def recorded(kind: str, linear: float) -> list[vt.Run]:
    """Three runs of a minute whose input is of this kind."""
    top, effect, _ = KINDS[kind]
    beta = 1.0 / MASS_KG if kind == "thrust_N" else 0.1 / top ** (2.0 - linear)
    p = vector({**effect, "beta": beta, "linear_input": linear}, HULL)
    runs = []
    for k, (w, share) in enumerate(((0.5, 1.0), (0.9, 0.7), (0.3, 0.5))):
        seen = record(f"run_{k}", sine(w, share * top, 60.0), p, NOISE_M, k)
        reading = seen.input + effect.get("force_offset", 0.0)  # which the hull does not feel
        runs.append(vt.Run(seen.name, seen.time_s, {kind: reading, "range_m": seen.value}))
    return runs


KINDS_AND_SHARES = [
    ("n_rev_s", 0.0),
    *(pytest.param(("command", k), marks=pytest.mark.slow) for k in (0.0, 1.0)),
    ("thrust_N", 1.0),
]


@pytest.fixture(scope="module", params=KINDS_AND_SHARES)
def found(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, float, list[vt.Run], vt.Diagnosis, Path]:
    """Kind of input, linear share, runs, their diagnosis and its model file."""
    kind, linear = request.param
    runs = recorded(kind, linear)
    names = {name.split(".")[0] for name in KINDS[kind][1] if "." in name} | {"command_delay"}
    d = vt.diagnose(runs, nominal="none", effects=sorted(names))
    path = tmp_path_factory.mktemp(kind) / "model.toml"
    d.save(path)
    return kind, linear, runs, d, path


def test_the_same_numbers_are_printed_written_and_filed(found) -> None:
    kind, linear, _, d, path = found
    _, effect, (name, key) = KINDS[kind]
    filed, fit = tomllib.loads(path.read_text()), d.verdict.fit
    assert d.verdict.effects == (name,)
    told = d.document["estimates"][name][next(iter(effect)).split(".")[1]]
    assert told["value"] == fit.values[next(iter(effect))]
    assert filed["effects"][name][key] == pytest.approx(told["value"], rel=1e-9)
    assert told["value"] == pytest.approx(effect[next(iter(effect))], rel=0.1)
    assert told["unit"] == {"n_rev_s": "1/s", "command": "-", "thrust_N": "m/s2"}[kind]
    assert f": {number(told['value'], 4)}" in str(d) and number(told["value"], 4) in d._repr_html_()
    own = d.document["parameters"]
    assert filed["lumped"]["alpha_per_m"] == pytest.approx(own["alpha"]["diagnosed"], rel=1e-9)
    if kind == "command":
        assert filed["lumped"]["linear_share"] == pytest.approx(own["linear_input"]["diagnosed"], abs=1e-9)
        assert own["linear_input"]["diagnosed"] == pytest.approx(linear, abs=0.15)
    if kind == "thrust_N":
        assert filed["lumped"]["force_offset_N"] == pytest.approx(effect["force_offset"], abs=0.1)
        assert own["force_offset"]["unit"] == "N" and "force offset" in str(d)
        assert own["beta"]["mass"]["value"] == pytest.approx(MASS_KG, rel=0.03)
        assert told["force"]["unit"] == "N"
        assert told["force"]["value"] == pytest.approx(MASS_KG * effect["coulomb_friction.f"], rel=0.1)
    assert "tachometer" not in path.read_text() + str(d)


def test_the_filed_model_predicts_as_the_diagnosis_does(found) -> None:
    """On the runs themselves, from the same start windows, to the digits of the noise that is filed."""
    _, _, runs, d, path = found
    for run in runs:
        seen = observe(run)
        seen = straightened(seen) if d.selection.setting.runs[0].straight else seen
        target = target_of(seen, d.selection.setting.noise)
        for name, fit in (("refit", d.selection.refit), ("diagnosed", d.verdict.fit)):
            own = rms([Prediction(model_of(fit), target).errors()])
            assert vt.predict(path, run)["rms"][name] == pytest.approx(own, rel=1e-3)


def test_the_filed_model_flies_in_the_tank_where_that_can_be_driven(found) -> None:
    kind, _, _, d, path = found
    if kind != "n_rev_s":
        with pytest.raises(vt.InputError, match="driven by propeller speed"):
            load_truth(path)
        return
    flown = load_truth(path).vector()
    for name, value in d.verdict.fit.values.items():
        assert flown[slot(name)] == pytest.approx(value, rel=1e-9)


def test_the_filed_model_is_a_nominal_of_its_own_input(found, tmp_path: Path) -> None:
    """Asked what is still wrong, it says: nothing. A simulator in a few lines is one; that of another input is not."""
    kind, _, runs, _, path = found
    again = vt.diagnose(runs, nominal=path, effects=["linear_drag", "coulomb_friction", "thrust_saturation"])
    assert again.verdict.kind in ("none", "parameters") and again.document["nominal"] == "diagnosed"
    if kind != "n_rev_s":
        own = tomllib.loads(path.read_text())["lumped"]
        lines = [f"{key} = {value!r}" for key, value in own.items() if value]
        mine = tmp_path / "mine.toml"
        mine.write_text("\n".join(['name = "mine"', f'input = "{kind}"', "[lumped]", *lines]))
        name, _ = KINDS[kind][2]
        assert vt.diagnose(runs, nominal=mine, effects=[name, "linear_drag"]).verdict.effects == (name,)
        with pytest.raises(vt.InputError, match=f'is driven by n_rev_s; expected one whose file says input = "{kind}"'):
            vt.diagnose(runs, nominal="paper-ii")


def test_without_a_nominal_nobody_speaks_of_one(found) -> None:
    *_, d, _ = found
    assert d.document["nominal"] == "none"
    for text in (str(d), d._repr_html_()):
        assert "as it is" not in text and "simulator's" not in text
    assert str(d).startswith("Without a simulator to compare with")


@pytest.mark.parametrize("straight", [False, True])
def test_whether_a_force_was_held_is_read_off_the_recordings(straight: bool) -> None:
    """The same vehicle, its force held for 0.5 s, or a record of a smooth one every 0.5 s."""
    p = vector({"beta": 1.0 / MASS_KG, "linear_input": 1.0}, HULL)
    stamps = 0.5 * np.arange(400)
    smooth = 20.0 * np.sin(0.45 * stamps)
    felt = 0.5 * (smooth + np.append(smooth[1:], smooth[-1])) if straight else smooth
    ranges = record("run", np.repeat(felt, 5), p, NOISE_M, 3).value[::5]  # at ticks of 0.1 s
    seen = vt.Run("run", stamps, {"thrust_N": smooth, "range_m": ranges})
    assert explained([observe(seen)], ()).setting.runs[0].straight == straight


@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        ("alpha_per_m = -1.3", "alpha_per_m = 1.3", r"mine.toml: .*drag must slow the vehicle"),
        ("beta_m_s2", "beta_m_per_rev2", r"mine.toml:5: lumped.beta_m_per_rev2: wrong unit: expected .beta_m_s2."),
        ('"command"', '"commands"', r"mine.toml:2: input: expected one of n_rev_s, command, thrust_N"),
    ],
)
def test_a_simulator_of_ones_own_that_is_none_is_refused(old: str, new: str, cause: str, tmp_path: Path) -> None:
    text = 'name = "mine"\ninput = "command"\n[lumped]\nalpha_per_m = -1.3\nbeta_m_s2 = 0.62\n'
    path = tmp_path / "mine.toml"
    path.write_text(text)
    assert read_simulator(path)[2].p[slot("beta")] == 0.62
    path.write_text(text.replace(old, new))
    with pytest.raises(vt.InputError, match=cause):
        read_simulator(path)
