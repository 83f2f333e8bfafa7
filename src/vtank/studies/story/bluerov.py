"""Act two: a whole BlueROV2 in open water, and a thruster that makes only part of its force."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import vtank as vt

from ...present import Bars, Drawing, Table, vehicle_picture, whole, words
from ...record import write_text
from .pictures import filmed
from .step import Act, Step

VEHICLE, AXES = "bluerov2", ("surge", "sway", "yaw")
SCENARIO, UNSEEN = "whole/bluerov2-multisine", "whole/turns-and-steps"
SETTINGS = ("duration_s=40",)
THRUSTERS = ("thruster_1", "thruster_2", "thruster_3", "thruster_4")  # those that push along the axes asked about
LOST = (0.2, 0.5)  # share of its force that one of them lacks; a choice
LIKELIEST = 5  # hypotheses shown
SHOWN = {  # column -> meaning, unit as shown, and factor
    "dvl.surge_m_s": ("speed ahead", "m/s", 1.0),
    "dvl.sway_m_s": ("speed to starboard", "m/s", 1.0),
    "imu.yaw_rate_rad_s": ("rate of turn", "°/s", 180.0 / np.pi),
}


def bluerov(act: Act) -> Iterator[Step]:
    """Fly, diagnose, correct, and only then look at what was withheld."""
    random = np.random.default_rng(act.seed)
    thruster, share = str(random.choice(THRUSTERS)), float(random.uniform(*LOST))
    weak = f'effects."thruster_dead@{thruster}".share={share:.3f}'
    folder = act.folder / "bluerov2"
    folder.mkdir()
    runs = flown(act, SCENARIO, weak, act.seed)
    yield flight(act, runs[0])
    with act.stages() as say:
        found = vt.diagnose(runs, VEHICLE, axes=AXES, progress=say)
    yield place(found)
    found.write(json=folder / "gap.json", model=folder / "gap.toml", report=folder / "gap.html")
    (unseen,) = flown(act, UNSEEN, weak, act.seed + 1)
    yield corrected(vt.predict(folder / "gap.toml", unseen)["columns"])
    write_text(act.folder / "withheld" / "bluerov2.txt", f"{thruster} lacked {share:.3f} of its force.\n")
    yield told(found, thruster, share)


def flown(act: Act, scenario: str, weak: str, seed: int) -> tuple[vt.Run, ...]:
    """A flight of the BlueROV2 with its weak thruster, as it can be read back from its data set."""
    name = Path(scenario).name
    out = act.folder / "bluerov2" / name
    with act.shares(f"flying {name}") as report:
        vt.run(scenario, seed=seed, settings=(*SETTINGS, f"vehicle={VEHICLE}", weak), out=out, progress=report)
    (out / "truth.json").rename(act.folder / "withheld" / f"{name}.json")
    return vt.load(out)


# --- the steps -----------------------------------------------------------------------------------------------------


def flight(act: Act, run: vt.Run) -> Step:
    """What was flown and recorded."""
    vehicle = vt.load_vehicle(VEHICLE)
    seen = vt.view(act.folder / "bluerov2" / run.name / f"{run.name}.csv", vehicle=VEHICLE)
    film = filmed(
        seen, act.folder, "bluerov2/film.mp4", "The simulator by its vehicle file, and the recording as a ghost in blue"
    )
    text = (
        f"{vehicle.mass_kg:.1f} kg, {len(vehicle.thrusters)} thrusters; {run.duration_s:.0f} s of surge, heave and yaw "
        f"at once, {len(run.columns)} channels. Which thruster lacks part of its force is sealed. {film.text}"
    )
    return Step("A whole vehicle: the BlueROV2 in open water", text.strip(), film.blocks)


def place(found: Any) -> Step:
    """Which effect, and where on the vehicle."""
    document = found.document
    lit = dict.fromkeys(document["verdict"]["places"], 1.0) or document["where"]
    picture = Drawing(
        vehicle_picture.vehicle_picture(found.vehicle, lit),
        "The BlueROV2 from above, bow to the right; the cause is filled.",
    )
    named = "+".join(sorted(f"{e['name']}@{e['place']}" for e in document["effects"]))
    chances = [(name, p, name == named) for name, p in document["probabilities"].items()][:LIKELIEST]
    shown = tuple((whole.hypothesis(name), p, mark) for name, p, mark in chances)
    verdict = document["verdict"]
    causes = words.listed([whole.found(e, explained=False) for e in document["effects"]]) or verdict["kind"]
    card = (
        "BlueROV2",
        causes.replace("_", " ").capitalize(),
        f"probability {words.percent(verdict['probability'])}",
    )
    return Step("Where on the vehicle the gap lies", whole.sentence(document), (picture, Bars(shown)), card)


def corrected(columns: dict[str, dict[str, float]]) -> Step:
    """The vehicle file with its cause on a flight that it has never seen."""
    rows = []
    for name, (meaning, unit, factor) in SHOWN.items():
        sizes = (factor * columns[name][key] for key in ("nominal", "diagnosed", "noise"))
        rows.append((meaning, *(words.length(size, unit) for size in sizes)))
    told = "; ".join(f"{meaning} {before} to {after} (noise {noise})" for meaning, before, after, noise in rows)
    table = Table(("error of", "as it is", "corrected", "noise"), tuple(rows))
    text = f"Errors on {Path(UNSEEN).name}, a flight it has never seen, before and after: {told}."
    return Step("The corrected BlueROV2 and a second flight", text, (table,))


def told(found: Any, thruster: str, share: float) -> Step:
    """The truth, beside what was found."""
    named = {(e["name"], e["place"]): e["values"] for e in found.document["effects"]}
    size, name = named.get(("thruster_dead", thruster)), thruster.replace("_", " ")
    said = "did not name it." if size is None else f"named it, with {100.0 * size['share']['value']:.1f} %."
    return Step(
        "What was withheld from it",
        f"It was {name}, which lacked {100.0 * share:.1f} % of its force. The diagnosis {said}",
    )
