"""A simulator of one axis in a file, by the keys that go with its input: a truth preset for that of a propeller speed.

Of a command or a thrust in N the file has a name, `input`, `[lumped]` with the keys below, and `[effects]`. A model
file of the diagnosis is one, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..effects.catalogue import PARAMETERS
from ..plant.formula import read_law
from ..plant.lumped import Lumped
from ..plant.parameters import LAG, LOSS, slot, vector
from ..plant.surge import LINEAR_INPUT
from ..plant.truth import OWN as OF_A_TRUTH
from ..plant.truth import PASSED_OVER, check_signs, load_truth, read_effects
from ..record.table import Table, open_table
from ..record.toml import find_file
from ..resources import models_dir
from .holdout import Model

OWN = {  # by the input's column: keys of the simulator's own parameters, by slot
    "n_rev_s": {"beta": "beta_m_per_rev2", LOSS: "gamma_per_rev"},
    "command": {"beta": "beta_m_s2", "linear_input": "linear_share", LOSS: "gamma_per_s"},
    "thrust_N": {"beta": "beta_per_kg", "force_offset": "force_offset_N"},
}
OWN = {name: {"alpha": "alpha_per_m", **keys, LAG: "tau_s"} for name, keys in OWN.items()}
OPTIONAL = (LOSS, "linear_input", "force_offset", LAG)  # nothing where the file does not say


def simulator(
    table: Table, input_name: str, effects: Table | None = None, law: Mapping[str, float] | None = None
) -> Model:
    """The simulator of a table with its own parameters; effects: those in it by default."""
    keys = OWN[input_name]
    table.check_keys((*keys.values(), "effects"))
    on = read_effects(table.table("effects") if effects is None else effects, input_name)
    own = {name: table.number(key, 0.0 if name in OPTIONAL else None) for name, key in keys.items()}
    p = vector({**own, **on, **(law or {})})
    if input_name == "thrust_N":
        p[LINEAR_INPUT] = 1.0
    return Model(p, tuple(name for name in on if PARAMETERS[name].per_run))


def read_simulator(name_or_path: str | Path) -> tuple[str, str, Model, float | None]:
    """Name, input, simulator and moving mass [kg] of a truth preset or a file; InputError names file and key."""
    file = open_table(find_file(name_or_path, models_dir() / "truths", "truth preset"))
    input_name = file.choice("input", tuple(OWN), "n_rev_s")
    if input_name == "n_rev_s":
        truth = load_truth(name_or_path)
        return truth.name, input_name, Model(truth.vector()), truth.moving_mass_kg
    file.check_keys((*OF_A_TRUTH, *PASSED_OVER, "between_samples"))
    mass_kg = file.positive("moving_mass_kg") if file.has("moving_mass_kg") else None
    found = simulator(file.table("lumped"), input_name, file.table("effects"), read_law(file))
    check_signs(file, Lumped(*(float(found.p[slot(name)]) for name in ("alpha", "beta", LOSS, LAG))))
    return file.text("name"), input_name, found, mass_kg
