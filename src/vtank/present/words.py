"""A diagnosis in plain words, from its document (schema vtank.diagnosis/2): for the terminal and for the report."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ..effects.catalogue import BY_NAME, PARAMETERS
from .numbers import percent

Document = dict[str, Any]

WORDS = tomllib.loads(Path(__file__).with_name("words.toml").read_text(encoding="utf-8"))
SLOW = 0.5  # share of the drive frequency up to which a line is told as a drift
MINOR = 0.2  # share of the evidence below which a variable explains little, or little beside the leading one
COUNTS = {2: "two", 3: "three", 4: "four", 5: "five"}
WORTH_IT = 1.05  # times a repeat from which an experiment is better than one
MOST_SPANS = 3  # stretches of time told, the most telling
OTHERS = 3  # explanations named beside one that is not settled
MANY = 100  # times a repeat beyond which the exact number means nothing
THROUGHOUT = 0.8  # share of the time from which a gap is there throughout


def effect_name(name: str) -> str:
    """An effect's name as words, `linear_drag` is linear drag; several are listed."""
    return listed([part.replace("_", " ") for part in name.split("+")])


def hypothesis(name: str) -> str:
    """A hypothesis in words."""
    return WORDS["hypothesis"].get(name) or effect_name(name)


def unit_text(unit: str) -> str:
    """A unit as it is shown: none for pure numbers."""
    return "" if unit == "-" else unit


def foreign(document: Document) -> bool:
    """Whether there was no simulator to compare with, but drag and thrust fitted to the recordings themselves."""
    return bool(document.get("nominal") == "none")


def simulators(document: Document) -> tuple[str, ...]:
    """The simulators whose errors are told; "as it is" is none that nobody gave."""
    return ("refit", "diagnosed") if foreign(document) else ("nominal", "refit", "diagnosed")


def listed(items: Sequence[str], last: str = "and") -> str:
    """Words in a row: a, b and c."""
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} {last} {items[-1]}" if items else ""


def number(value: float, digits: int = 3) -> str:
    """A number with so many significant digits."""
    return f"{value:.{digits}g}".replace("-", "\N{MINUS SIGN}")


def whole(value: float) -> str:
    """A number without decimals."""
    return f"{value:z.0f}".replace("-", "\N{MINUS SIGN}")


def length(value: float, unit: str) -> str:
    """A value in m, m/s or m/s2 with its unit, in thousandths where it is small."""
    unit_text = unit.replace("s2", "s²")
    return f"{number(1e3 * value)} m{unit_text}" if abs(value) < 0.1 else f"{number(value)} {unit_text}"


# --- the verdict ---------------------------------------------------------------------------------------------------
def compared(document: Document) -> str:
    """What the recordings were compared with, in one sentence."""
    if foreign(document):
        return "Without a simulator to compare with, drag and thrust were fitted to these recordings."
    name = document.get("nominal", "given parameters")
    if document.get("nominal_by_default"):
        return f"Compared with {name}, the Phoenix of 1996, since no simulator was named."
    return f"Compared with {name}."


def headline(document: Document) -> str:
    """What was compared, and the verdict in one sentence."""
    return f"{compared(document)} {verdict(document)}"


def verdict(document: Document) -> str:
    """The verdict in one sentence."""
    v = document["verdict"]
    if foreign(document) and v["kind"] in ("none", "parameters"):
        return "They explain them: no effect is missing."
    if v["kind"] == "none":
        return f"No gap: {document.get('nominal', 'the simulator')} as it is explains these recordings."
    effects, rivals = [effect_name(e) for e in v["effects"]], [effect_name(e) for e in v["class"]]
    beside = " Whether something else acts beside is not decided." * (v.get("doubt") == "beside")
    match v["kind"]:
        case "parameters":
            return "The simulator's structure is right, but its parameters are off."
        case "effect" if len(rivals) > 1:
            return f"The gap is caused by {listed(rivals, 'or')}.{beside}"
        case "effect":
            return f"The gap is caused by {effects[0]}.{beside}"
        case "effects":
            return f"The gap has {COUNTS.get(len(effects), len(effects))} causes: {listed(effects)}.{beside}"
        case "varying":
            text = f"{varying(document)} from run to run"
            alone = f"The simulator's structure is right, but its {text}."
            return f"{text.capitalize()}." if document["estimates"] else alone
        case "undecided" if not effects:
            perhaps = WORDS["perhaps_foreign" if foreign(document) else "perhaps"][likeliest(document)]
            return f"Undecided: perhaps {perhaps}, but {doubt(document)}."
        case "undecided":
            perhaps = listed(effects) if len(effects) > 1 else listed(rivals, "or")
            return f"Undecided: perhaps {perhaps}, but {doubt(document)}."
    whole = "drag and thrust" if foreign(document) else "the simulator"
    return f"Something is missing from {whole}, and no known effect explains it."


def doubt(document: Document) -> str:
    """Why nothing is decided."""
    return str(WORDS["doubt"].get(document["verdict"].get("doubt"), "these recordings do not settle it"))


def likeliest(document: Document) -> str:
    """The most probable answer that names no effect."""
    chances = document["probabilities"]
    return max(WORDS["perhaps"], key=lambda name: float(chances.get(name, 0.0)))


def estimates(document: Document) -> Iterator[tuple[str, str, str, str, str]]:
    """Sizes of the named effects: effect, quantity, value, 95 % interval (empty where there is none) and unit.

    Where the mass is known, what makes a force has a second row in N.
    """
    for name, found in document["estimates"].items():
        for key, e in found.items():
            meaning = PARAMETERS[f"{name}.{key}"].meaning
            for told in filter(None, (e, e.get("force"))):
                yield effect_name(name), meaning, *sized(told)
                meaning = meaning.removesuffix(" per unit of moving mass").replace(
                    " per unit of moving mass and", " per"
                )


def sized(told: Document) -> tuple[str, str, str]:
    """Value, 95 % interval (empty where there is none) and unit."""
    return number(told["value"], 4), " to ".join(map(number, told["interval95"] or ())), unit_text(told["unit"])


def own_parameters(document: Document) -> Iterator[tuple[str, str, str, str, str]]:
    """The simulator's own parameters: name, as it is, refitted, diagnosed and unit."""
    for name, p in document.get("parameters", {}).items():
        nominal, refit, diagnosed = (number(p[key], 4) for key in ("nominal", "refit", "diagnosed"))
        yield WORDS["own"].get(name, name), nominal, refit, diagnosed, unit_text(p["unit"])


def in_newton(document: Document) -> Iterator[tuple[str, str, str, str]]:
    """Own parameters of the diagnosed simulator times the mass, and the mass: name, value, 95 % interval and unit."""
    for name, p in document.get("parameters", {}).items():
        if "mass" in p:
            yield "moving mass", *sized(p["mass"])
        if "force" in p:
            yield WORDS["own"].get(name, name), *sized(p["force"])


def explanation(document: Document) -> list[str]:
    """What the verdict means, in a few sentences."""
    v, lines = document["verdict"], []
    for name in v["effects"]:
        lines.append(BY_NAME[name].sentence)
    if v["kind"] == "none":
        lines.append(f"What is missed is no larger than sensor noise{still_water(document)}.")
    if v["kind"] == "parameters" and not foreign(document):
        lines.append("Refitting drag and thrust explains the recordings; no further effect is needed.")
    if v["kind"] == "unknown":
        best = listed([effect_name(name) for name in document["estimates"]])
        several = len(document["estimates"]) > 1
        named = f"effects, {best}, leave" if several else f"effect, {best}, leaves"
        rest = f"and the best known {named} a part unexplained" if best else "nor does any known effect"
        lines.append(f"Refitting the parameters does not close the gap, {rest}.")
    if v["kind"] == "undecided" and not v["effects"]:
        chances = document["probabilities"]
        ranked = sorted((name for name in chances if name != likeliest(document)), key=lambda name: -chances[name])
        possible = [f"{hypothesis(name)} ({percent(chances[name])})" for name in ranked[:OTHERS]]
        lines.append(f"Possible as well: {listed(possible)}.")
    lines.append(f"Probability: {percent(v['probability'])}.")
    if only := document.get("considered"):
        lines.append(f"No other effects were considered than {listed([effect_name(name) for name in only])}.")
    return lines


def still_water(document: Document) -> str:
    """The disturbance beside the noise, where it was worked out."""
    water = document.get("disturbance")
    if not water:
        return ""
    size = length(water["sigma_m_s2"], "m/s2")
    return f" and a disturbance of {size}" + ", as still water and its own wake make" * water["plausible"]


def varying(document: Document) -> str:
    """Which own parameters differ."""
    names = [WORDS["own"].get(name, name) for name in document["verdict"]["varying"]]
    return f"{listed(names)} differ{'s' * (len(names) == 1)}"


# --- where ---------------------------------------------------------------------------------------------------------
def channel(document: Document) -> str:
    """Where in the machine the gap acts."""
    chances = document["where"]["channel"]["probability"]
    name = document["verdict"]["channel"] or max(chances, key=lambda c: chances[c])
    if document["verdict"]["kind"] == "undecided" and not document["verdict"]["effects"]:
        return f"Not settled; that no channel is at fault has a probability of {percent(chances['none'])}."
    if document["verdict"]["kind"] in ("none", "parameters") or name == "none":
        return f"No channel is at fault (probability {percent(chances['none'])})."
    acting = {effect: BY_NAME[effect].channel for effect in document["verdict"]["effects"]}
    if document["verdict"]["kind"] == "effects" and len(set(acting.values())) > 1:
        told = [f"{effect_name(effect)} acts {WORDS['acts'][where]} ({where})" for effect, where in acting.items()]
        return f"{listed(told).capitalize()}."
    return f"It acts {WORDS['acts'][name]} ({name}, probability {percent(chances[name])})."


def runs(document: Document) -> str:
    """Which runs show it."""
    found = sorted(document["where"]["runs"], key=lambda r: -r["share"])
    if not found or found[0]["share"] == 0.0:
        return "No run stands out."
    if len(found) == 1:
        return f"There is one run, {found[0]['run']}."
    return f"It shows most in {found[0]['run']} ({percent(found[0]['share'])} of the evidence)."


def time(document: Document) -> str:
    """When it shows."""
    spans = document["where"]["time_s"]
    duration_s = sum(run["duration_s"] for run in document["where"]["runs"])
    covered = sum(span["to"] - span["from"] for span in spans)
    if not spans:
        return "No stretch of time stands out by itself."
    if covered > THROUGHOUT * duration_s:
        return "It is there throughout."
    best = sorted(spans, key=lambda s: -s["log_likelihood_gain"])[:MOST_SPANS]
    named: dict[str, list[str]] = {}
    for span in spans:
        if span in best:
            named.setdefault(span["run"], []).append(f"{span['from']:.0f} to {span['to']:.0f} s")
    return f"It shows in {listed([f'{run} from {listed(stretches)}' for run, stretches in named.items()])}."


def frequency(document: Document) -> str:
    """At which frequencies it shows."""
    lines = sorted(document["where"]["frequency_rad_s"], key=lambda line: -line["power"])
    if not lines:
        return "No frequency stands out of the noise."
    multiples = sorted({line["multiple_of_drive"] for line in lines if line["multiple_of_drive"]})
    strangers = [line for line in lines if not line["multiple_of_drive"]]
    own = sorted({round(line["frequency"], 2) for line in strangers if line["frequency"] > SLOW * line["drive"]})
    parts = []
    if multiples:
        first = "the drive frequency" if multiples[0] == 1 else f"{multiples[0]} times the drive frequency"
        parts.append(f"at {listed([first, *(f'{m} times it' for m in multiples[1:])])}")
    if own:
        parts.append(f"at {listed([number(f) for f in own[:4]])} rad/s, which is no multiple of the drive")
    if any(line["frequency"] <= SLOW * line["drive"] for line in strangers):
        parts.append("as a slow drift")
    return f"What the refit cannot predict stands out {listed(parts)}."


def region(document: Document) -> str:
    """With what a missing force goes, and where it is largest."""
    over = {name: r for name, r in document["where"]["region"].items() if r["bins"]}
    if not over:
        return "No missing force stands out over speed, input or place."
    most = max(r["log_likelihood_gain"] for r in over.values())
    if max(r["share"] for r in over.values()) < MINOR:
        return "It is no function of speed, input or place: they explain little of it."
    parts = []
    for name, found in sorted(over.items(), key=lambda item: -item[1]["log_likelihood_gain"]):
        if found["log_likelihood_gain"] > MINOR * most:
            b = max(found["bins"], key=lambda b: abs(b["acceleration"]))
            what, unit, _ = WORDS["quantity"][name]
            span = f"{number(b['from'])} to {number(b['to'])} {unit}".rstrip()
            parts.append(f"the {what} ({length(b['acceleration'], 'm/s2')} at {span})")
    return f"The force that the refit lacks goes with {listed(parts)}."


# --- how far -------------------------------------------------------------------------------------------------------
def shrinkage(document: Document) -> str:
    """How far the gap shrinks, on runs left out where that was worked out."""
    s = document.get("shrink")
    if not s:
        return "How far the gap shrinks on runs left out was not worked out."
    unit = s["unit"]
    before = f"{length(s['nominal'], unit)} with the simulator as it is, {length(s['refit'], unit)} after refitting it"
    if foreign(document):
        before = f"{length(s['refit'], unit)} with drag and thrust alone"
    text = (
        f"On {left_out(document)}, of which only the start is used, the error is {before}, "
        f"{length(s['diagnosed'], unit)} with the diagnosis; noise alone gives {length(s['floor'], unit)}."
    )
    if s.get("fraction_closed") is None:
        return f"{text} Refitting leaves next to nothing to close."
    text += f" The diagnosis closes {closed(s)} of what refitting leaves beyond noise"
    if s.get("interval90"):
        low, high = s["interval90"]
        text += f" (on new data nine times out of ten {whole(100.0 * low)} to {whole(100.0 * high)} %)"
    return f"{text}."


def left_out(document: Document) -> str:
    """What was left out in turn: runs, or stretches of few runs."""
    names = {run["run"] for run in document["where"]["runs"]}
    parts = (document.get("shrink") or {}).get("left_out", names)
    return "runs left out" if len(names) > 1 and set(parts) <= names else "stretches of time left out"


def closed(shrink: Document) -> str:
    """Share of the reducible gap that is closed; by luck of the noise it can be measured beyond all of it."""
    return f"{100.0 * min(max(shrink['fraction_closed'], 0.0), 1.0):.0f} %"


# --- ties and the next experiment ------------------------------------------------------------------------------------
NO_TIES = "Nothing that these recordings cannot tell apart."


def ties(document: Document) -> list[str]:
    """What these recordings cannot tell apart, one sentence each."""
    rivals, lines = document["verdict"]["class"], []
    if len(document["verdict"]["effects"]) > 1:  # a class of its own for each: the groups of the catalogue tell it
        rivals = []
    if len(rivals) > 1:
        names = [effect_name(name) for name in rivals]
        others = "the other" if len(rivals) == 2 else "each of the others"
        lines.append(
            f"{listed(names).capitalize()} are indistinguishable here: recordings of the first, without any noise, "
            f"are matched by {others} to within three deviations of the noise."
        )
    if "distance_m" not in document["where"]["region"]:  # no sonar: nothing of the following can be at work
        return lines
    for group in document["tied"]:
        if len(group) > 1 and not set(group) <= set(rivals):
            lines.append(f"{listed([effect_name(n) for n in group]).capitalize()} are indistinguishable to one sonar.")
    if document["absorbed"]:
        names = [effect_name(name) for name in document["absorbed"]]
        lines.append(f"{listed(names).capitalize()} are not identifiable: refitting the parameters hides them.")
    return lines


def next_experiment(document: Document) -> str:
    """What to do next."""
    plan = document.get("next_experiment")
    if not plan:
        return "No next experiment was worked out."
    aim = "to tell the candidates apart" if plan["question"] == "which hypothesis" else "to sharpen the estimates"
    text = f"Best next, {aim}: {plan['experiment']} ({number(plan['minutes'], 2)} min)."
    if plan["against_repeat"] > MANY:
        return f"{text} Per minute it tells over {MANY} times as much as repeating a run."
    if plan["against_repeat"] < WORTH_IT:
        return f"{text} Nothing that was looked at tells more per minute than repeating a run."
    return f"{text} Per minute it tells {number(plan['against_repeat'], 2)} times as much as repeating a run."
