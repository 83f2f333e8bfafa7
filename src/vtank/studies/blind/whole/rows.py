"""One row per case of a whole vehicle: what was true, what was answered, and how far it could be told."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ....diagnose.whole import Known, known_fits
from ....plant import Vehicle, load_vehicle
from ....plant.vehicle import AXES
from ....record import read_run
from ....tank.places import places
from ..measures import Z
from ..rows import Row, chances_of
from ..verify import Opened
from .closed import closed
from .names import parts, scored_name, true_name

TOLD = 0.5  # of its prior's deviation, below which a coefficient counts as identified; a choice
PRIOR_SHARE = 0.3  # deviation of the prior of drag and added mass, as a share of the vehicle file's


@dataclass(frozen=True)
class WholeRow(Row):
    """A scored case of a whole vehicle.

    Attributes:
        covered_each: of each identified coefficient, whether its 95 % interval holds what was flown.
        place_kind: what the true effect's place is: axis, thruster, fin, sensor or vehicle; "" for none.
    """

    covered_each: tuple[bool, ...]
    place_kind: str

    @property
    def named(self) -> tuple[str, ...]:
        """The class that was named, under the names that are scored."""
        if self.said in ("none", "parameters", "unknown"):
            return (self.said,)
        names = [scored_name(str(name)) for name in self.verdict.get("class", ())]
        return tuple(dict.fromkeys(names[:1] if self.said == "effects" else names)) or (self.answer,)

    @property
    def effect_right(self) -> bool:
        """Whether the true effect is in the most probable answer, at whatever place."""
        return bool({e for e, _ in parts(self.label)} & {e for e, _ in parts(self.answer)})

    @property
    def place_right(self) -> bool:
        """Whether it is there at its place."""
        return bool(set(parts(self.label)) & set(parts(self.answer)))


def row(opened: Opened, truth: Path, case: str) -> WholeRow:
    """The row of one case; InputError where a vehicle or a run cannot be read."""
    sealed, answer = opened.truths[case], opened.answers[case]
    vehicle, label = load_vehicle(sealed["vehicle"]), true_name(sealed)
    given = [read_run(path) for path in sorted((opened.folder / case).glob("run_*.csv"))]
    plain = [read_run(truth / "plain" / case / name) for name in sorted(sealed["plain_files"])]
    held = [read_run(truth / "held_out" / case / name) for name in sorted(sealed["held_out_files"])]
    known = known_fits(vehicle, given, plain, lambda name: scored_name(name) == label)
    document = answer["document"]
    return WholeRow(
        case=case, label=label, truth=sealed, document=document, d=_difficulty(label, known),
        chances=chances_of(document["probabilities"], scored_name), refused=str(answer.get("refused", "")),
        closed=closed(vehicle, answer, known, held), covered_each=_covered(sealed, document),
        place_kind=_place_kind(sealed, vehicle),
    )  # fmt: skip


def _difficulty(label: str, known: Known) -> float:
    if label == "none":
        return 0.0
    return known.d_parameters if label == "parameters" else known.d


def _covered(truth: Mapping[str, Any], document: Mapping[str, Any]) -> tuple[bool, ...]:
    """Whether stated intervals hold the drag and the added mass that were flown; of what an effect moves, none."""
    own, found = truth["own"], []
    flown = {f"{key}_drag@{axis}": own[key][i] for key in ("linear", "quadratic") for i, axis in enumerate(AXES)}
    flown |= {f"added_mass@{axis}": own["added_mass"][7 * i] for i, axis in enumerate(AXES)}
    named = {f"{e['name']}@{e['place']}" for e in document.get("effects", ())}
    for number in document.get("parameters", ()):
        told = number["sd"] < TOLD * PRIOR_SHARE * abs(number["nominal"])
        if number["name"] in flown and number["name"] not in named and told:
            found.append(bool(abs(number["value"] - flown[number["name"]]) <= Z * number["sd"]))
    return tuple(found)


def _place_kind(truth: Mapping[str, Any], vehicle: Vehicle) -> str:
    if truth["kind"] != "single":
        return ""
    place = str(truth["label"]).partition("@")[2]
    return next((kind for kind, known in places(vehicle).items() if place in known), "")
