"""The gap budget in plain words, from a diagnosis' document: what the gap is made of, and what of it has no name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from ..diagnose.freeform.pursuit import OWN
from .numbers import percent
from .words import MINOR, WORDS, Document, effect_name, foreign, left_out, length, listed, number

TOLD = 0.0005  # share below which a line of the budget is not worth its words; a choice
NOTABLE = 0.05  # share without an explanation, or of own parameters, from which more is told of it; a choice
MOST_TOLD = 4  # places of things without a name that are told; a choice


def share(value: float) -> str:
    """A share in percent, with a digit after the point where it is small, never rounded up to all."""
    size = 100.0 * abs(value)
    if 99.5 <= size < 100.0:
        return "over 99 %"
    text = "under 0.1" if 0.0 < size < 0.1 else f"{size:.0f}" if size >= 9.5 or size == 0.0 else f"{size:.1f}"
    return "\N{MINUS SIGN}" * (value < 0.0) + f"{text} %"


def budget(document: Document) -> list[str]:
    """What the gap is made of, what of it has no name, what got worse, and an odd disturbance: a sentence each."""
    lines = document.get("budget") or []
    told = (shared_out(document), imitated(lines), unexplained(document), *places(document))
    return [*filter(None, (*told, *by_run(document), worse(document), disturbance(document)))]


def shared_out(document: Document) -> str:
    """The shares, in one sentence; empty where they were not worked out."""
    lines = document.get("budget") or []
    known = [line for line in lines if line["kind"] in ("parameters", "effect")]
    taken = [(line_name(line, document), share(line["share"])) for line in known if line["share"] >= TOLD]
    named = [f"{agreeing(name, 'account')} for {size}" for name, size in taken[:1]]
    named += [f"{name} for {size}" for name, size in taken[1:]]
    rest = [rest_of(line, document) for line in lines if line not in known and line["share"] >= TOLD]
    said = "; ".join(listed(part) for part in (named, rest, [*added(document)]) if part)
    return f"Of {whole_of(document)}, {said}." if said else ""


def imitated(lines: Sequence[Document]) -> str:
    """Why the share of a cause may be small; empty where own parameters take little off before it."""
    own = sum(line["share"] for line in lines if line["kind"] == "parameters")
    effects = [line["share"] for line in lines if line["kind"] == "effect"]
    if own < NOTABLE or sum(effects) < TOLD:
        return ""
    cause, most = "cause" if len(effects) == 1 else "causes", own + sum(effects)
    size = "nearly all" if most >= 0.995 else f"up to {share(most)}"
    return f"Own parameters are taken off first and may imitate the {cause}, which alone may account for {size}."


def whole_of(document: Document) -> str:
    """What all shares are of."""
    before = "drag and thrust alone" if foreign(document) else "the simulator as it is"
    return f"the mean-square error of {before} on {left_out(document)}"


def added(document: Document) -> Iterator[str]:
    """Steps that add to the error, and why the other shares then come to more than all."""
    worse = [line for line in document.get("budget") or () if line["share"] <= -TOLD]
    adds = [f"{agreeing(line_name(line, document), 'add')} {share(-line['share'])}" for line in worse]
    if adds:
        others = share(1.0 - sum(line["share"] for line in worse))
        yield f"{listed(adds)}, so that the shares of the others come to {others}"


def agreeing(name: str, verb: str) -> str:
    """A name and its verb, in the plural where it is about several."""
    return f"{name} {verb}" if " and " in name or name.endswith("parameters") else f"{name} {verb}s"


def line_name(line: dict[str, Any], document: Document) -> str:
    """A line of the budget by the name that it has in a text."""
    if line["kind"] == "effect":
        return effect_name(line["name"])
    refit = line["kind"] == "parameters" and (foreign(document) or line["share"] < 0.0)
    return "a refit" if refit else str(line["name"])


def rest_of(line: dict[str, Any], document: Document) -> str:
    """A line of the budget that neither own parameters nor an effect accounts for."""
    size = share(line["share"])
    if line["kind"] == "repeatable":
        return f"{size} repeats, but has no name"
    if line["kind"] == "noise":
        return f"{size} is sensor noise"
    if any(c["kind"] != "function" for c in document.get("unnamed", ())):
        return f"{size} does not repeat"
    water = document["disturbance"]
    than = "as" if water["plausible"] else "more than"
    made = f"{length(water['sigma_m_s2'], 'm/s2')}{_by_run(water)}, {than} still water and its own wake make"
    return f"{size} is disturbance ({made})"


def _by_run(water: dict[str, Any]) -> str:
    """In which runs a disturbance is least and largest, where runs differ."""
    if not (each := water.get("by_run")):
        return ""
    least, most = (find(each, key=each.__getitem__) for find in (min, max))
    return f", from {length(each[least], 'm/s2')} in {least} to {length(each[most], 'm/s2')} in {most}"


def disturbance(document: Document) -> str:
    """A disturbance that still water does not have; empty where there is none."""
    water = document.get("disturbance")
    if not water or water["plausible"]:
        return ""
    return (
        f"The disturbance, {length(water['sigma_m_s2'], 'm/s2')} with a memory of {number(water['memory_s'], 2)} s, is "
        "several times what still water and its own wake make: waves, a current that changes, or a cause that was not "
        "found."
    )


def worse(document: Document) -> str:
    """Parts left out that the diagnosis predicts worse; empty where there are none."""
    parts = document.get("worse")
    than = "drag and thrust alone" if foreign(document) else "the refitted one"
    return f"On {listed(parts)} the diagnosed simulator predicts worse than {than}." if parts else ""


# --- what has no name ----------------------------------------------------------------------------------------------
def unexplained(document: Document) -> str:
    """How much has no explanation, and with what it goes; empty where next to nothing is left."""
    found, rest = strangers(document), document.get("unexplained")
    doubt = document["verdict"]["kind"] in ("unknown", "undecided")
    if not rest or not (doubt or (found and rest["share"] >= NOTABLE)):
        return ""
    text = f"{share(rest['share'])} of it is not explained"
    functions = leading([c for c in found if c["kind"] == "function"])
    again = sum(line["share"] for line in document["budget"] if line["kind"] == "repeatable") >= TOLD
    if not functions:
        return f"{text}; it repeats." if again else f"{text}."
    lead = "it repeats, and" if again else "it does not come again on data left out, but here"
    return f"{text}; {lead} {listed([*goes(functions, document)])}."


def strangers(document: Document) -> list[dict[str, Any]]:
    """What has no name; own parameters that differ from run to run have one."""
    return [c for c in document.get("unnamed", ()) if not c["runs"]]


def leading(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What earns little beside the first is left out."""
    return [c for c in found if c["gain"] > MINOR * found[0]["gain"]]


def goes(functions: list[dict[str, Any]], document: Document) -> Iterator[str]:
    """With what a missing force goes, how own terms change, and with what the readings are wrong."""
    plain = [c["about"] for c in functions if c["force"] and " over " not in c["about"]]
    if plain:
        yield f"goes with {listed(variables(plain))}"
    for c in functions:
        term, _, over = c["about"].partition(" over ")
        if over:
            yield f"is {term} that changes with {listed(variables([over]))}"
    wrong = [c["about"] for c in functions if not c["force"]]
    if wrong:
        yield f"is an error of {sensor(document)} that goes with {listed(variables(wrong))}"


def variables(about: list[str]) -> list[str]:
    """The variables of several functions, each once."""
    names = [name for text in about for name in text.split(" and ")]
    return [WORDS["about"].get(n, n.replace(" of the last ", " over the last ")) for n in dict.fromkeys(names)]


def sensor(document: Document) -> str:
    """What takes the readings."""
    return "the sonar" if "distance_m" in document["where"]["region"] else "the readings"


def places(document: Document) -> list[str]:
    """Stretches of time and frequencies at which something without a name shows, a sentence each."""
    if not unexplained(document):
        return []
    alike: dict[tuple[str, str], dict[str, Any]] = {}
    for c in strangers(document):
        key = (c["kind"], c["about"] if c["kind"] == "window" else str(len(alike)))
        alike[key] = c | {"windows": [*alike.get(key, c | {"windows": []})["windows"], *c["windows"]]}
    told = filter(None, (place(c, document) for c in alike.values()))
    return [f"{text[:1].upper()}{text[1:]}." for text in told][:MOST_TOLD]


def place(c: dict[str, Any], document: Document) -> str:
    """Where one thing without a name shows; empty for a function of the motion, which is everywhere."""
    looks = WORDS["as_if"].get(c["about"], "").format(sensor=sensor(document))
    spans = listed([f"in {w['run']} from {w['from']:.0f} to {w['to']:.0f} s" for w in c["windows"]])
    match c["kind"]:
        case "window":
            return f"{spans} it looks {looks}"
        case "wander":
            return f"{c['about']} comes and goes without a rule" + f", clearly {spans}" * bool(spans)
        case "line":
            late = c["about"].startswith("latency")
            what = "a delay" if late else "a force" if c["force"] else "an error"
            what += f" of {sensor(document)}" * (not c["force"])
            return f"at {c['frequency_rad_s']:.2f} rad/s there is {what}"
        case "run":
            return f"it looks {looks}, of another size in every run"
    return ""


def laws(document: Document) -> Iterator[str]:
    """Formulas that would be the missing law, a sentence or two for each."""
    for law in document.get("laws", ()):
        closes = (
            f"It closes {share(min(law['gap_closed'], 1.0))} of what refitting leaves beyond noise on data left out"
        )
        yield f"{law['sentence']} {law['formula']}. {closes} (probability {percent(law['probability'])})."


def by_run(document: Document) -> Iterator[str]:
    """By how much own parameters differ from run to run, a sentence for each."""
    found = document.get("unnamed", [])
    for c in found if document["verdict"]["kind"] == "varying" else leading(found):
        if c["runs"]:
            name = WORDS["own"][OWN[c["about"]]]
            sizes = [f"{100.0 * r['change']:+.1f} ± {100.0 * r['sd']:.1f} %" for r in c["runs"]]
            text = ", ".join(sizes).replace("-", "\N{MINUS SIGN}")
            yield f"{name.capitalize()} differs from run to run: {text}, in order of the runs."
