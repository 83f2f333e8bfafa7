"""Truth presets: the surge parameters a virtual experiment is run with, and where they come from.

A preset is a TOML file in models/truths/. It either prints lumped parameters, in the paper's feet or in SI, or names a
vehicle whose mass, added mass, drag and propellers they are derived from (`lumped.py`). Effects may be switched on in
it as in a scenario. A model written by the diagnosis is such a preset, with more tables that are passed over here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import astuple, dataclass, field
from pathlib import Path

import numpy as np

from ..effects.catalogue import BY_NAME, PARAMETERS
from ..effects.effect import unit_suffix
from ..record.table import Table, open_table
from ..record.toml import find_file
from ..resources import models_dir
from .formula import read_law
from .lumped import Lumped, from_feet, lump, propeller_forces
from .parameters import LUMPED, unit_of, vector
from .vehicle import load_vehicle

FEET = ("a_per_ft", "b_ft_per_rev2", "gamma_per_rev", "tau_s")
SI = ("alpha_per_m", "beta_m_per_rev2", "gamma_per_rev", "tau_s")
OWN = ("name", "source", "n_limit_rev_s", "moving_mass_kg", "lumped", "derived", "effects", "law")
PASSED_OVER = ("schema", "input", "verdict", "noise", "nominal", "refit")  # what a diagnosed model has besides


@dataclass(frozen=True)
class Truth(Lumped):
    """Surge parameters, with a name, the largest propeller speed either way [rev/s] and their origin.

    effects: slot of the parameter vector -> value, of effects that are switched on besides, and of a law that is data.
    moving_mass_kg: of its vehicle, None where neither the file nor what it is derived from says it.
    """

    name: str
    n_limit_rev_s: float
    source: str
    effects: Mapping[str, float] = field(default_factory=dict)
    moving_mass_kg: float | None = None

    @property
    def lumped(self) -> Lumped:
        """The four parameters alone."""
        return Lumped(self.alpha_per_m, self.beta_m_per_rev2, self.gamma_per_rev, self.tau_s)

    def vector(self) -> np.ndarray:
        """Parameter vector p of the surge equation; effects that are not switched on have their null values."""
        return vector({**dict(zip(LUMPED, astuple(self.lumped), strict=True)), **self.effects})


def truth_names() -> tuple[str, ...]:
    """Names of the presets that come with vtank."""
    return tuple(sorted(path.stem for path in (models_dir() / "truths").glob("*.toml")))


def load_truth(name_or_path: str | Path) -> Truth:
    """The preset of that name in models/truths/, or of that TOML file; InputError names file and key."""
    path = find_file(name_or_path, models_dir() / "truths", "truth preset")
    file = open_table(path)
    if file.text("input", "n_rev_s") != "n_rev_s":
        raise file.error("input", 'the tank is driven by propeller speed, expected "n_rev_s"')
    file.check_keys((*OWN, *PASSED_OVER))
    mass_kg = file.positive("moving_mass_kg") if file.has("moving_mass_kg") else None
    if file.has("derived"):
        lumped, mass_kg = _derived(file.table("derived"))
    else:
        lumped = _printed(file.table("lumped"))
    check_signs(file, lumped)
    return Truth(
        **vars(lumped),
        name=file.text("name"),
        n_limit_rev_s=file.positive("n_limit_rev_s"),
        source=file.text("source"),
        effects=read_effects(file.table("effects")) | read_law(file),
        moving_mass_kg=mass_kg,
    )


def key_of(name: str, input_name: str = "n_rev_s") -> str:
    """Key of an effect's parameter, with its unit where that is the input: `n_max_rev_s`, of a command `n_max`."""
    return PARAMETERS[name].name + unit_suffix(unit_of(name, input_name))


def read_effects(table: Table, input_name: str = "n_rev_s") -> dict[str, float]:
    """Slot -> value of all effects in an [effects] table, each parameter within its bounds.

    Of an input that is no propeller speed, what has the input's unit is not bound by rev/s.
    """
    values = {}
    table.check_keys(BY_NAME)
    for name in table.entries:
        own = table.table(name)
        for slot, q in zip(BY_NAME[name].slots(), BY_NAME[name].parameters, strict=True):
            if own.has(key := key_of(slot, input_name)):
                bounds = q.bounds if unit_of(slot, input_name) == q.unit else ()
                values[slot] = own.number(key, None, *bounds)
        own.close()
    return values


def _printed(table: Table) -> Lumped:
    if "a_per_ft" in table.entries:
        table.check_keys(FEET)
        return from_feet(*(table.number(key) for key in FEET))
    table.check_keys(SI)
    return Lumped(*(table.number(key) for key in SI))


def _derived(table: Table) -> tuple[Lumped, float]:
    table.check_keys(("vehicle", "density_kg_per_m3", "kt0", "kt1", "tau_s"))
    vehicle = load_vehicle(table.file("vehicle", presets=(models_dir(), "vehicle")))
    count, curve = len(vehicle.propeller_sites), (table.number("kt0"), table.number("kt1"))
    if math.isnan(vehicle.propeller_diameter_m):
        raise table.error("vehicle", f"{vehicle.path} has no [propeller] with sites and diameter_m, from which kt0 and "
                          "kt1 make a force")  # fmt: skip
    forces = propeller_forces(count, vehicle.propeller_diameter_m, *curve, table.positive("density_kg_per_m3"))
    mass_kg = vehicle.moving_mass_kg
    return lump(mass_kg, float(vehicle.quadratic_drag[0]), *forces, table.number("tau_s")), mass_kg


def check_signs(file: Table, lumped: Lumped) -> None:
    """InputError where drag or a loss of thrust would speed the vehicle up, or thrust does not push."""
    rules = {
        "alpha": (lumped.alpha_per_m <= 0.0, "drag must slow the vehicle: alpha (a) must not be positive"),
        "beta": (lumped.beta_m_per_rev2 > 0.0, "thrust must push: beta (b) must be positive"),
        "gamma": (lumped.gamma_per_rev <= 0.0, "thrust falls with speed: gamma must not be positive"),
        "tau": (lumped.tau_s >= 0.0, "tau must not be negative"),
    }
    for name, (holds, message) in rules.items():
        if not holds:
            raise file.error(name, message)
