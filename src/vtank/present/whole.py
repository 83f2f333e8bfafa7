"""The diagnosis of a whole vehicle in words, tables and a picture of the vehicle on which the place lights up."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..plant.vehicle import AXES
from . import likeness, words
from .blocks import Bars, Block, Details, Drawing, Heading, Paragraph, Table, Terms
from .document import html, plain
from .numbers import percent
from .predicted import channel, predicted, size
from .vehicle_picture import vehicle_picture
from .words import WORDS, effect_name, listed, unit_text
from .words_budget import TOLD, imitated, share

if TYPE_CHECKING:
    from ..diagnose.whole.diagnosis import WholeDiagnosis

Document = dict[str, Any]
WHOLE = "the mean-square error of the simulator as it is"  # of which all shares are
MOST = 6  # probabilities that are shown
DOUBTS = {"worse": "the diagnosed simulator does not predict what was left out of its fit any better",
          "disturbance": "the disturbance that is left is too large for turbulence",
          "likeness": "the fitted plant misses more of the simulator than the simulator of the recordings"}  # fmt: skip


def terminal_text(document: Document, width: int) -> str:
    """What `vtank diagnose` prints."""
    return plain(Heading(title(document), 1), Terms(tuple(facts(document))), width=width)


def report_html(diagnosis: WholeDiagnosis, numbers: str) -> str:
    """The report, one page that loads nothing."""
    document = diagnosis.document
    lit = dict.fromkeys(document["verdict"]["places"], 1.0) or document["where"]
    picture = Drawing(
        vehicle_picture(diagnosis.vehicle, lit), "The vehicle from above, bow to the right; what is named is filled."
    )
    blocks: list[Block] = [Heading(title(document), 1), Paragraph(sentence(document)), picture]
    blocks += [block for name, parts in facts(document) if name != "Verdict" for block in (Heading(name), *parts)]
    return html(title(document), [*blocks, *details(document), Details("All numbers (JSON)", numbers)])


def title(document: Document) -> str:
    """What was diagnosed, and the cause."""
    verdict = document["verdict"]
    said = {
        "none": "no gap",
        "parameters": "only its parameters are off",
        "unknown": f"an unmodelled cause at {placed(verdict['places'])}",
        "undecided": "undecided",
    }.get(verdict["kind"]) or listed([found(effect, explained=False) for effect in document["effects"]])
    return f"{document['nominal']}: {said}"


def facts(document: Document) -> list[tuple[str, tuple[Paragraph | Table | Bars, ...]]]:
    """Verdict, probabilities, sizes and budget, each with its name."""
    items: list[tuple[str, tuple[Paragraph | Table | Bars, ...]]] = [
        ("Compared", (Paragraph(f"{', '.join(document['runs'])} with {document['nominal']}: "
                                f"{', '.join(document['axes'])}"),)),
        ("Verdict", (Paragraph(sentence(document)),)),
    ]  # fmt: skip
    if "against" in document:
        items.insert(1, ("Likeness", (Paragraph(likeness.sentence(document)),)))
    if document["effects"]:
        items.append(("Sizes", (Table(("effect", "number", "value", "sd", "unit"), tuple(_sizes(document)), left=2),)))
    chances = list(document["probabilities"].items())[:MOST]
    named = "+".join(sorted(_full(e) for e in document["effects"]))
    items.append(("Probable", (Bars(tuple((hypothesis(name), p, name == named) for name, p in chances)),)))
    items.append(("Budget", (budget(document["budget"]),)))
    if document["notes"]:
        items.append(("Noticed", (Paragraph("; ".join(document["notes"]) + "."),)))
    return items


def sentence(document: Document) -> str:
    """The verdict in a sentence or three."""
    verdict = document["verdict"]
    explained = sum(max(line["share"], 0.0) for line in document["budget"] if line["kind"] == "effect")
    left = document["unexplained"]["share"]
    said = {
        "none": "No gap: what is left is sensor noise and a small disturbance.",
        "parameters": "The simulator's own parameters are off; nothing else is seen.",
        "unknown": f"Something acts that has no name here, most likely at {placed(verdict['places'])}.",
        "undecided": "Undecided: " + (DOUBTS.get(verdict["doubt"]) or "several causes are about as likely") + ".",
    }.get(verdict["kind"], "")
    if verdict["kind"] in ("effect", "effects"):
        names = " and ".join(map(found, document["effects"]))
        said = f"{names[:1].upper() + names[1:]}; probability {percent(verdict['probability'])}. "
        said += f"It explains {share(explained)} of {WHOLE}."
        said += " Own parameters, which may imitate it, are taken off first." * bool(imitated(document["budget"]))
    if verdict["kind"] in ("effect", "effects") and len(verdict["class"]) > 1:
        said += f" This data does not rule out {listed([hypothesis(name) for name in verdict['class'][1:]], 'or')}."
    if verdict["kind"] == "unknown" and verdict["doubt"]:
        said += f" There {DOUBTS[verdict['doubt']]}, and it does not go with the motion."
    if verdict["unexplained"]:
        said += f" Something that repeats and has no name is left at {placed(verdict['unexplained'])}."
    elif left > 0.1 and verdict["kind"] != "none":
        said += f" Of {WHOLE}, {share(left)} does not repeat and is not sensor noise."
    return said


def found(effect: Document, explained: bool = True) -> str:
    """An effect at its place: how much is lost where it is a share, else its name, `explained` by its sentence."""
    place = placed([effect["place"]])
    if lacks := WORDS["lacks"].get(effect["name"]):
        return str(lacks.format(place=place, share=share(effect["values"]["share"]["value"])))
    return f"{effect_name(effect['name'])} at {place}" + f" ({effect['sentence']})" * explained


def placed(places: Sequence[str]) -> str:
    """Places in words: `thruster_4` is thruster 4, a column its channel and instrument."""
    return listed([channel(place) if "." in place else place.replace("_", " ") for place in places])


def hypothesis(name: str) -> str:
    """A hypothesis in words, `thruster_dead@thruster_4+linear_drag@yaw`."""
    return listed([_one(part) for part in name.split("+")])


def _one(name: str) -> str:
    """One effect of a hypothesis, or one that names none."""
    what, at, where = name.partition("@")
    place, _, column = where.partition(":")
    if what in WORDS["lacks"]:
        return str(WORDS["lacks"][what].format(place=placed([place]), share="part"))
    told = WORDS["hypothesis"].get(what) or effect_name(what)
    return told + f" at {placed([place])}" * bool(at) + f" ({placed([column])})" * bool(column)


def _full(effect: Document) -> str:
    return f"{effect['name']}@{effect['place']}" + (f":{effect['column']}" if effect["column"] else "")


def _sizes(document: Document) -> Iterator[tuple[str, ...]]:
    """Effect, number, value, deviation and unit; what is lost as a share of all."""
    for effect in document["effects"]:
        for name, v in effect["values"].items():
            if effect["name"] in WORDS["lacks"]:
                yield _one(_full(effect)), "share", number(100.0 * v["value"]), number(100.0 * v["sd"], 2), "%"
            else:
                yield _one(_full(effect)), name, number(v["value"]), number(v["sd"], 2), unit_text(v["unit"])


def number(value: float, digits: int = 4) -> str:
    """A number with so many significant digits; a dash where there is none."""
    return words.number(value, digits) if math.isfinite(value) else "-"


def budget(lines: list[Document]) -> Table:
    """Whose the error of simulation is."""
    rows = tuple((hypothesis(line["name"]), share(line["share"]),
                  " to ".join(words.whole(100.0 * end) for end in line["interval90"])) for line in lines)  # fmt: skip
    notes = [f"Shares of {WHOLE}; they add to 100 %."]
    if any(line["share"] <= -TOLD for line in lines):
        notes.append("What is below zero adds to the error, and the others take that off as well.")
    if told := imitated(lines):
        notes.append(told)
    return Table(("whose error it is", "share", "90 % interval [%]"), rows, tuple(notes))


def details(document: Document) -> list[Block]:
    """Own parameters, and errors by column."""
    own = tuple(
        (*_own(p["name"]), number(p["nominal"]), number(p["value"]), number(p["sd"], 2)) for p in document["parameters"]
    )
    columns = predicted({"columns": {name: c["rms"] for name, c in document["channels"].items()}}, "these runs")
    drifts = tuple(
        (channel(name), size(d["size"], name), number(d["memory_s"], 2)) for name, d in document["slow_errors"].items()
    )
    slow = [Table(("of", "size", "lasts [s]"), drifts, title="Slow errors of instruments, as noise")]
    return [
        *(likeness.tables(document)[1:] if "against" in document else ()),
        Table(("own parameter", "unit", "nominal", "found", "sd"), own, title="Own parameters", left=2),
        replace(columns, title="Errors of simulation"),
        *(slow if drifts else ()),
    ]  # fmt: skip


def _own(name: str) -> tuple[str, str]:
    """An own parameter in words, and its unit: of an axis along it or about it."""
    what, _, where = name.partition("@")
    word, along, about = WORDS["own_whole"].get(what, (what.replace("_", " "), "", ""))
    place = placed(where.split("/"))
    return word if where == "hull" else f"{word}, {place}", about if where in AXES[3:] else along
