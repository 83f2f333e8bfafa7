"""Act one: the Phoenix before the wall of its tank, and an effect of the catalogue that its simulator lacks."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import vtank as vt

from ...effects import Effect
from ...plant import slot
from ...present import Bars, Drawing, Picture, Table, pictures_budget, sections, words, words_budget
from ...record import write_text
from ...resources import NOMINAL
from ...tank import load_model, render
from .pictures import WIDTH, filmed, overlay
from .step import Act, Step
from .withheld import candidates, draw, toml

EXPERIMENTS = ("paper-ds1", "paper-ds4", "multisine")  # in closed loop: no cause drives the vehicle into a wall
UNSEEN = "paper-ds2"
SETTINGS = ("duration_s=60",)
OWN = {  # parameter -> in words, unit as shown, and factor
    "alpha": ("drag", "1/m", 1.0),
    "beta": ("thrust", "mm/rev²", 1e3),
    "tau": ("lag", "s", 1.0),
}
OFF = 3.0  # deviations beyond which an identified parameter has missed the truth; a choice
LIKELIEST = 5  # hypotheses shown


def phoenix(act: Act) -> Iterator[Step]:
    """Fly, compare, identify, diagnose, correct, and only then look at what was withheld."""
    nominal = vt.load_truth(NOMINAL)
    yield tank(act)
    effect, truth = draw(act.seed, nominal)  # seen by nothing but the tank until they are told
    preset = act.folder / "withheld" / "phoenix.toml"
    preset.parent.mkdir()
    write_text(preset, toml(effect, truth))
    runs = recorded(act, preset, EXPERIMENTS, "recording", act.seed)
    yield recording(runs, len(candidates(nominal)))
    yield beside(act.folder)
    yield identified(vt.identify(runs, model="II"), nominal, truth)
    with act.stages() as say:
        found = vt.diagnose(runs, NOMINAL, progress=say)
        document = found.document
    yield gap(document)
    yield cause(document)
    yield Step("The next experiment", words.next_experiment(document))
    found.write(json=act.folder / "gap.json", model=act.folder / "gap.toml", report=act.folder / "gap.html")
    (unseen,) = recorded(act, preset, (UNSEEN,), "second", act.seed + 1)
    yield corrected(act.folder, vt.predict(act.folder / "gap.toml", unseen))
    yield told(document, effect, truth)


def recorded(act: Act, preset: Path, scenarios: Sequence[str], name: str, seed: int) -> tuple[vt.Run, ...]:
    """Experiments in the tank with the withheld vehicle, as they can be read back from their data set."""
    out = act.folder / name
    with act.shares(f"flying {', '.join(scenarios)}") as report:
        vt.run(*scenarios, seed=seed, truth=str(preset), settings=SETTINGS, threads=2, out=out, progress=report)
    (out / "truth.json").rename(preset.with_name(f"{name}.json"))
    return vt.load(out)


# --- the steps -----------------------------------------------------------------------------------------------------


def tank(act: Act) -> Step:
    """The vehicle and its surroundings."""
    vehicle = vt.load_vehicle("phoenix")
    how = render.picture(act.folder / "tank.png", load_model())
    text = (
        f"{vehicle.mass_kg:.0f} kg, two stern propellers, a sonar that looks at the wall ten feet ahead. Its "
        f"simulator, {NOMINAL}, knows drag, thrust and the lag of thrust."
    )
    picture = Picture("tank.png", f"The Phoenix in the virtual tank, with the beam of its sonar, {how}.", plot=False)
    return Step("The Phoenix in its tank", text, (picture,))


def recording(runs: Sequence[vt.Run], possible: int) -> Step:
    """What was recorded, and that its cause is not told."""
    pings = sum(int(np.isfinite(run.columns["range_m"]).sum()) for run in runs)
    text = (
        f"{len(runs)} experiments ({words.listed([run.name for run in runs])}), "
        f"{sum(run.duration_s for run in runs):.0f} s, {pings} sonar ranges. Of {possible} effects that the simulator "
        "lacks the seed drew one, and other drag, thrust and lag; all stay sealed."
    )
    return Step("A recording whose cause is withheld", text)


def beside(folder: Path) -> Step:
    """The simulator on the recorded propeller speeds, as a picture and a film."""
    name = EXPERIMENTS[0]
    seen = vt.view(folder / "recording" / f"{name}.csv")
    svg, apart_m = overlay("before", seen, {"nominal": seen.flown})
    film = filmed(seen, folder, "film.mp4", "The simulator, and the recording as a ghost in blue")
    far = words.length(apart_m, "m")
    text = f"Given the propeller speeds of the experiment {name}, it is up to {far} from where the vehicle was"
    legend = (("dot ink", "measured by sonar"), ("nominal", "simulator as it is"))
    picture = Drawing(svg, f"{name}: distance ahead, and by how much the simulator misses it.", legend)
    return Step("Its simulator beside it", f"{text}. {film.text}".strip(), (picture, *film.blocks))


def identified(fit: Any, nominal: vt.Truth, truth: vt.Truth) -> Step:
    """Own parameters from the recording alone, beside the truth."""
    rows, values, off = [], [], 0
    for name, value in fit.values.items():
        true, sd = truth.vector()[slot(name)], fit.sd[name]
        off += abs(value - true) > OFF * sd
        meaning, unit, factor = OWN[name.rpartition(".")[2]]
        before, now, then = (words.number(factor * v, 4) for v in (nominal.vector()[slot(name)], value, true))
        found = f"{now} ± {words.number(factor * sd, 2)}"
        rows.append((f"{meaning} [{unit}]", before, found, then))
        values.append(f"{meaning} {found} {unit} (true {then})")
    text = "; ".join(values)
    bent = "They bend to hide what is missing." if off else "They are right: something else is wrong."
    table = Table(("of the vehicle", "simulator", "identified", "true"), tuple(rows))
    return Step("Identified as if nothing were missing", f"{text.capitalize()}. {bent}", (table,))


def gap(document: dict[str, Any]) -> Step:
    """How large it is and what it is made of."""
    size, noise = (words.length(document["shrink"][key], document["shrink"]["unit"]) for key in ("nominal", "floor"))
    svg = pictures_budget.budget_picture(document["budget"], document, WIDTH)
    caption = (
        "What it is made of, from above to below. Nine times out of ten other data would put an end within its line."
    )
    picture = Drawing(svg, caption)
    shares = filter(None, (words_budget.shared_out(document), words_budget.imitated(document["budget"])))
    text = f"The simulator misses the recording by {size}; sensor noise alone gives {noise}. {' '.join(shares)}"
    return Step("The gap and its budget", text, (picture,), ("The gap", size, f"sensor noise alone gives {noise}"))


def cause(document: dict[str, Any]) -> Step:
    """Which effect, and how probable it is."""
    ranked = sorted(document["probabilities"].items(), key=lambda item: -item[1])[:LIKELIEST]
    named = {"+".join(document["verdict"]["effects"]), document["verdict"]["kind"], *document["verdict"]["class"]}
    bars = Bars(tuple((words.hypothesis(name), p, name in named) for name, p in ranked))
    text = " ".join((words.verdict(document), *words.explanation(document)))
    return Step("Its cause", text, (bars,), ("Its cause", *sections.which_in_short(document)))


def corrected(folder: Path, errors: dict[str, Any]) -> Step:
    """The simulator with its cause on a recording that it has never seen."""
    unit, sizes = errors["unit"], errors["rms"] | {"noise": errors["floor"]}
    before, refit, after, noise = (words.length(sizes[k], unit) for k in ("nominal", "refit", "diagnosed", "noise"))
    path = folder / "second" / f"{UNSEEN}.csv"
    old, new = vt.view(path), vt.view(path, truth=folder / "gap.toml")
    svg, _ = overlay("after", old, {"nominal": old.flown, "diagnosed": new.flown})
    legend = (("dot ink", "measured by sonar"), ("nominal", "simulator as it is"), ("diagnosed", "corrected simulator"))
    picture = Drawing(
        svg, f"{UNSEEN}, which no simulator has seen: distance ahead, and what each misses of it.", legend
    )
    text = (
        f"gap.toml, the simulator with its cause, predicts {UNSEEN}, which it has never seen, to {after}. As it was "
        f"it missed it by {before}, refitted alone by {refit}; sensor noise alone gives {noise}."
    )
    card = ("A second recording", f"{before} to {after}", f"error before and after; sensor noise alone gives {noise}")
    return Step("The corrected simulator and a second recording", text, (picture,), card)


def told(document: dict[str, Any], effect: Effect, truth: vt.Truth) -> Step:
    """The truth, beside what was found."""
    name, found = words.effect_name(effect.name), document["estimates"].get(effect.name, {})
    rows = []
    for parameter, value in zip(effect.parameters, truth.effects.values(), strict=True):
        size = words.number(found[parameter.name]["value"]) if parameter.name in found else "-"
        rows.append((f"{name}: {parameter.meaning} [{parameter.unit}]", size, words.number(value)))
    for key, values in document["parameters"].items():
        if key.rpartition(".")[2] in OWN:
            meaning, unit, factor = OWN[key.rpartition(".")[2]]
            size, true = (words.number(factor * v, 4) for v in (values["diagnosed"], truth.vector()[slot(key)]))
            rows.append((f"{meaning} [{unit}]", size, true))
    verdict = document["verdict"]
    said = judged(effect.name, verdict["effects"], verdict["class"])
    table = Table(("with the cause", "found", "true"), tuple(rows))
    return Step("What was withheld", f"It was {name}. {said}", (table,), ("What was withheld", name.capitalize(), said))


def judged(name: str, effects: Sequence[str], rivals: Sequence[str]) -> str:
    """Whether the diagnosis was right."""
    if name in effects and len(effects) == 1:
        return "The diagnosis named it."
    if name in (*effects, *rivals):
        return f"The diagnosis named it, among {len({*effects, *rivals})}."
    return "The diagnosis did not name it."
