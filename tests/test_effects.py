"""The catalogue of effects: complete, well formed, honest about what is tied or absorbed, and named nowhere else."""

from __future__ import annotations

import ast
import re
from dataclasses import replace
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from vtank.effects import catalogue
from vtank.effects import effect as effect_module
from vtank.effects.catalogue import BY_NAME, CATALOGUE
from vtank.effects.effect import Effect, Need, Parameter, unit_suffix
from vtank.effects.loaded import effects_in
from vtank.errors import InputError
from vtank.plant.hooks import added
from vtank.plant.parameters import NAMES, PLAIN, SIZE, null_vector, slot, vector
from vtank.plant.surge import SYMBOLS

PARAMETERS = [pytest.param(effect, q, id=f"{effect.name}.{q.name}") for effect in CATALOGUE for q in effect.parameters]

# Names that users script on; they may be added to and never changed.
FIXED = {
    "hydrodynamics": "linear_drag coulomb_friction ambient_current seiche wall_proximity tether"
    " drag_asymmetry wake_memory",
    "actuator": "thrust_deadband thrust_asymmetry thrust_loss thrust_lag thrust_saturation supply_sag",
    "sensor": "sonar_latency sonar_multipath tachometer_bias tachometer_spikes clock_skew",
}


@pytest.mark.parametrize("channel", FIXED)
def test_the_names_that_users_script_on_are_there(channel):
    for name in FIXED[channel].split():
        assert BY_NAME[name].channel == channel


EFFECTS = pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.name)


@EFFECTS
def test_an_effect_says_what_it_is(effect):
    assert effect.sentence.endswith(".") and effect.law and effect.source and effect.parameters
    assert effect.name not in effect.confused_with
    assert set(effect.confused_with) <= set(BY_NAME)
    names = [q.name for q in effect.parameters]
    assert len(set(names)) == len(names)
    assert not all(q.shape for q in effect.parameters)  # something must say how large it is


@pytest.mark.parametrize(("effect", "q"), PARAMETERS)
def test_a_parameter_is_well_formed(effect, q):
    low, high = q.bounds
    assert q.key == q.name + unit_suffix(q.unit)
    assert low <= q.null <= high and low < high
    assert q.scale > 0 and q.meaning
    assert q.null + q.scale <= high or q.null - q.scale >= low  # a typical size is admissible
    assert q.starts or not q.limit  # nothing is near infinity
    assert all((0.0 < start < 1.0) if q.limit else (low <= start <= high) for start in q.starts)


def test_units_are_told_by_rule_and_an_unknown_one_is_refused_where_it_is_written():
    known = {"-": "", "s": "_s", "1/s2": "_per_s2", "m/s2": "_m_s2", "rad/s": "_rad_s", "1/rev": "_per_rev"}
    assert {unit: unit_suffix(unit) for unit in known} == known
    for unit in ("furlong", "m/s/s", "1", "m s", ""):
        with pytest.raises(ValueError, match=f"unit '{unit}' is not known; expected '-' or such as"):
            Parameter("c", unit, "", 0.0, (0.0, 1.0), 1.0)


def test_every_module_of_the_folder_is_in_the_catalogue_under_its_own_name():
    folder = Path(catalogue.__file__).parent
    files = {path.stem for path in folder.glob("*.py")} - {"__init__", "effect", "catalogue", "loaded"}
    assert files == set(BY_NAME) and len(BY_NAME) == len(CATALOGUE)
    orders = [(effect.channel, effect.order) for effect in CATALOGUE]
    assert len(set(orders)) == len(orders)


@EFFECTS
def test_an_effect_says_where_it_acts_and_what_it_needs(effect):
    places = {"hydrodynamics": {"surge"}, "actuator": {"thruster"}, "sensor": {"range_m", "n_rev_s"}}
    assert effect.place in places[effect.channel]
    assert set(effect.needs) <= set(get_args(Need)) and (effect.place != "range_m" or "sonar" in effect.needs)
    if effect.same_as:
        assert BY_NAME[effect.same_as].standing == effect.standing == "tied"
    hooks = (effect.reads, effect.instant, effect.acts, effect.true_input)
    assert effect.channel != "sensor" or effect.outliers or any(hooks)


@EFFECTS
def test_what_stands_between_hull_and_recording_does_nothing_at_the_null(effect):
    null = [q.null for q in effect.parameters]
    for hook in (effect.reads, effect.instant, effect.acts):
        assert hook is None or hook(1.7, *null) == 1.7
    if effect.true_input:
        assert effect.true_input(1.7, 0.9, *null) == 1.7
        if effect.reads:
            assert effect.true_input(effect.reads(1.7, 0.3), 0.0, 0.3) == pytest.approx(1.7)


def test_an_effect_that_nothing_obeys_is_refused_where_it_is_written():
    assert all(effect.does for effect in CATALOGUE)
    assert not Effect("new", "hydrodynamics", "surge", "It.", "", (BARE,), "a guess").does


BARE = Parameter("c", "1/s", "", 0.0, (0.0, 1.0), 1.0)
FORCES = {  # law of a force -> what is said of it, "" where it is right
    "right": (lambda u_r, c: -c * u_r, ""),
    "unknown": (lambda speed, c: -c * speed, "asks for speed, c; expected any of t, x"),
    "short": (lambda: 0.0, "expected any of"),
    "place": (lambda x, c: -c * x, "depends on place; expected depends_on=.'place',."),
    "time": (lambda t, u, c: -c * u * t, "depends on time"),
}


@pytest.mark.parametrize("name", FORCES)
def test_a_force_asks_for_what_the_equation_has_and_says_what_it_depends_on(name):
    law, said = FORCES[name]
    effect = replace(BY_NAME["linear_drag"], force=law)
    if said:
        with pytest.raises(ValueError, match=said):
            added([effect], SYMBOLS, {})
        line = law.__code__.co_firstlineno
        with pytest.raises(InputError, match=f"^own.py:{line}: effect 'linear_drag': .*{said}"):
            catalogue.checked("own.py", effect)
    else:
        p = vector({"linear_drag.c": 0.5})
        add = added([effect], {"u_r": "u_r"}, {}).py_func
        assert add(1.0, 2.0, p) == 0.0 and add(1.0, 2.0, null_vector()) == 1.0


def test_what_a_force_may_ask_for_is_what_the_equation_of_motion_has():
    assert set(SYMBOLS) == set(effect_module.SYMBOLS)


def test_tied_effects_name_each_other():
    tied = [effect for effect in CATALOGUE if effect.standing == "tied"]
    assert tied
    for effect in tied:
        partners = [other.name for other in tied if effect.name in other.confused_with and other.name != effect.name]
        assert partners and set(partners) <= set(effect.confused_with)


def test_the_parameter_vector_has_a_slot_for_everything_and_nothing_else():
    assert (
        NAMES == (*PLAIN, *(f"{effect.name}.{q.name}" for effect in CATALOGUE for q in effect.parameters))
        and len(set(NAMES)) == SIZE == null_vector().size
    )
    assert all(NAMES[slot(name)] == name for name in NAMES)
    for effect in CATALOGUE:
        for name, q in zip(effect.slots(), effect.parameters, strict=True):
            assert null_vector()[slot(name)] == q.null


def test_a_vector_sets_what_it_is_told_and_leaves_its_base_alone():
    base = vector({"alpha": -2.0})
    p = vector({"linear_drag.c": 0.3}, base)
    assert p[slot("alpha")] == -2.0 and p[slot("linear_drag.c")] == 0.3 and base[slot("linear_drag.c")] == 0.0
    assert np.sum(p != base) == 1
    with pytest.raises(InputError, match="no surge parameter 'linear_drag.k'; did you mean 'linear_drag.c'. there are"):
        slot("linear_drag.k")


def test_no_code_outside_the_effects_and_the_plants_names_an_effect():
    """The effects at places of a whole vehicle are catalogues of their own: the tank's, and that of its equations."""
    found, root = [], Path(catalogue.__file__).parents[1]
    places = {*(root / "tank" / "places").rglob("*.py"), root / "rigid" / "places.py", root / "rigid" / "layout.py"}
    for path in root.rglob("*.py"):
        if path.relative_to(root).parts[0] not in ("effects", "plant") and path not in places:
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if isinstance(node, ast.Constant) and isinstance(node.value, str) and names_an_effect(node.value):
                    found.append(f"{path.relative_to(root)}:{node.lineno}: {node.value!r}")
    assert not found, "ask the effect for what makes it special: " + ", ".join(found)


def names_an_effect(text: str) -> bool:
    """Whether a string is an effect's name, a slot of one, or the first words of several names."""
    return any(
        text == e or text.startswith(f"{e}.") or (text[1:].endswith("_") and e.startswith(text)) for e in BY_NAME
    )


def test_a_string_that_names_an_effect_is_found():
    assert all(map(names_an_effect, ("seiche", "tachometer_spikes.size", "sonar_", "tether.")))
    assert not any(map(names_an_effect, ("seiches", "the tether", "", "_", "thrust_N", "effects.tether.k_per_s2")))


@pytest.mark.parametrize(
    "text, said",
    [
        ("x = 1\ndef f(:\n", "bad.py:2: SyntaxError: "),
        ("x = 1\n\nEFFECT = y\n", "bad.py:3: NameError: name 'y' is not defined"),
        (
            "from vtank.effects.effect import Parameter\nEFFECT = Parameter('c', 's/furlong', '', 0.0, (0, 1), 1.0)\n",
            "bad.py:2: ValueError: unit 's/furlong' is not known",
        ),
    ],
)
def test_a_fault_in_an_effect_of_ones_own_is_told_by_file_and_line(
    text: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / f"own_{len(text)}"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "bad.py").write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(InputError, match=re.escape(said)) as told:
        list(effects_in(folder.name, [str(folder)]))
    assert str(told.value).startswith(str(folder))
