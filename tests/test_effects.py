"""The catalogue of effects: complete, well formed, and honest about what is tied or absorbed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import vtank.effects
from vtank.effects.catalogue import BY_NAME, CATALOGUE
from vtank.effects.effect import UNIT_SUFFIX
from vtank.errors import InputError
from vtank.plant.parameters import NAMES, PLAIN, SIZE, null_vector, slot, vector

PARAMETERS = [pytest.param(effect, q, id=f"{effect.name}.{q.name}") for effect in CATALOGUE for q in effect.parameters]

# Names that users script on; they may be added to and never changed.
FIXED = {
    "hydrodynamics": "linear_drag coulomb_friction ambient_current seiche wall_proximity tether"
    " drag_asymmetry wake_memory",
    "actuator": "thrust_deadband thrust_asymmetry thrust_loss thrust_lag thrust_saturation supply_sag",
    "sensor": "sonar_latency sonar_multipath tachometer_bias tachometer_spikes clock_skew",
}


def test_every_file_is_an_effect_in_the_catalogue_and_bears_its_name():
    folder = Path(vtank.effects.__file__).parent
    files = {path.stem for path in folder.glob("*.py")} - {"__init__", "effect", "catalogue"}
    assert files == {effect.name for effect in CATALOGUE}
    assert len(BY_NAME) == len(CATALOGUE)


@pytest.mark.parametrize("channel", FIXED)
def test_the_names_that_users_script_on_are_there(channel):
    for name in FIXED[channel].split():
        assert BY_NAME[name].channel == channel


@pytest.mark.parametrize("effect", CATALOGUE, ids=lambda effect: effect.name)
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
    assert q.unit in UNIT_SUFFIX and q.key == q.name + UNIT_SUFFIX[q.unit]
    assert low <= q.null <= high and low < high
    assert q.scale > 0 and q.meaning
    assert q.null + q.scale <= high or q.null - q.scale >= low  # a typical size is admissible


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
    with pytest.raises(InputError, match="no surge parameter 'linear_drag.k'; there are: alpha, beta"):
        slot("linear_drag.k")
