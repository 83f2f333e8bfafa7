"""The sections of the report, from the verdict to what to do next, as blocks of a document."""

from __future__ import annotations

from collections.abc import Iterator

from ..diagnose.localise.where import WhereData
from . import pictures, pictures_where, words
from .blocks import Bars, Block, Drawing, Heading, Paragraph, Table, Terms
from .words import Document

MOST_BARS = 8  # hypotheses listed by name; the rest are summed up
UNNAMED = {
    "smooth force": "an unknown force",
    "force lines": "an unknown force with a rhythm of its own",
    "wandering thrust": "an unknown thrust that comes and goes",
    "smooth error": "an unknown error of the sensor",
    "lone ranges": "single ranges that are wrong",
    "lone speeds": "single readings of the propeller that are wrong",
}  # families of discrepancies in words


def sections(document: Document, data: WhereData) -> Iterator[Block]:
    """The whole report."""
    for section in (opening, how_far, where, over_time, over_frequency, over_motion):
        yield from section(document, data)
    for rest in (which, estimates, what_next):
        yield from rest(document)


def opening(document: Document, data: WhereData) -> Iterator[Block]:
    """The verdict, and the three answers in short."""
    yield Heading(words.headline(document), 1)
    yield Paragraph(" ".join(words.explanation(document)))
    facts = {
        "Where": where_in_short(document),
        "Which": which_in_short(document),
        "How far": far_in_short(document, data),
    }
    yield Terms(tuple((term, (Paragraph(detail, short),)) for term, (short, detail) in facts.items()))


def where_in_short(document: Document) -> tuple[str, str]:
    """The channel, and the run that shows it most."""
    v = document["verdict"]
    if v["kind"] == "undecided" and not v["channel"]:
        return "Not settled", words.runs(document)
    if v["kind"] in ("none", "parameters") or not v["channel"]:
        return "Nowhere in particular", "no effect is missing"
    return v["channel"].capitalize(), words.runs(document)


def which_in_short(document: Document) -> tuple[str, str]:
    """The cause and its probability."""
    v = document["verdict"]
    pair = v["kind"] == "effects"
    chosen = v["effects"] if pair else v["class"] or v["effects"]
    found = words.listed([words.effect_name(name) for name in chosen], "and" if pair else "or")
    plain = {"none": "Nothing", "parameters": "Parameters", "unknown": "Unmodelled cause"}
    name = plain.get(v["kind"], found or "Undecided")
    return name[:1].upper() + name[1:], f"probability {words.percent(v['probability'])}"


def far_in_short(document: Document, data: WhereData) -> tuple[str, str]:
    """The shrinkage: on runs left out where that was worked out, on these runs otherwise."""
    s = document.get("shrink") or {}
    if s.get("fraction_closed") is not None:
        return f"{words.closed(s)} closed", f"of what refitting leaves, on {words.left_out(document)}"
    before, after = pictures_where.pair_of(document["verdict"]["kind"])
    unit = data.gaps[0].unit
    sizes = [(sum(g.rms(s) ** 2 for g in data.gaps) / len(data.gaps)) ** 0.5 for s in (before, after)]
    change = f"{words.length(sizes[0], unit)} to {words.length(sizes[1], unit)}"
    return change, f"error, simulator {pictures.CALLED[before]} to {pictures.CALLED[after]}, on these runs"


def how_far(document: Document, data: WhereData) -> Iterator[Block]:
    """Gap before and after: on these runs, and on runs left out."""
    legend = (
        ("dot nominal", "simulator as it is"),
        ("dot refit", "its parameters refitted"),
        ("dot diagnosed", "with the diagnosis"),
        ("area floor", "noise floor"),
    )
    caption = (
        "Each row is a run, simulated from the start that suits it best. The further left a dot, the closer the "
        "simulator follows the recording; "
        "inside the grey bar it misses no more than noise and turbulence make."
    )
    yield Heading("How far the gap shrinks")
    yield Drawing(pictures.gap_picture(data.gaps), caption, legend)
    yield Paragraph(words.shrinkage(document))
    if document.get("shrink"):
        caption = "Each is predicted by simulators that were chosen and fitted without it."
        yield Drawing(pictures.shrink_picture(document), caption)


def where(document: Document, data: WhereData) -> Iterator[Block]:
    """The channel, and the runs that show it."""
    chances = document["where"]["channel"]["probability"]
    most = max(chances.values())
    yield Heading("Where the gap lies")
    yield Paragraph(f"{words.channel(document)} {words.runs(document)}")
    yield Bars(tuple((name if name != "none" else "no channel", p, p == most) for name, p in chances.items()))


def over_time(document: Document, data: WhereData) -> Iterator[Block]:
    """Residuals with the windows that matter."""
    pair = pictures_where.pair_of(document["verdict"]["kind"])
    before, after = (pictures.CALLED[name] for name in pair)
    better = f"the simulator {after} predicts better than {before}"
    if found := UNNAMED.get(data.windows[0].after):
        better = f"{found}, put on top of the best known explanation, predicts better than that alone"
    caption = (
        f"Measured less simulated: every sample (pale) and its mean over 2 s. Marked are the windows in which {better} "
        f"beyond chance (1 % in all windows together).{hidden(data, pictures_where.MOST_RUNS)}"
    )
    legend = (
        (pair[0], f"simulator {before}"),
        (pair[1], f"simulator {after}"),
        ("area floor", "noise, two deviations"),
        ("area mark", "significant"),
    )
    yield Heading("Over time", 3)
    yield Paragraph(words.time(document))
    yield Drawing(pictures_where.time_picture(data.gaps, data.windows, pair), caption, legend)


def hidden(data: WhereData, most: int) -> str:
    """What is said when not all runs are shown."""
    if len(data.gaps) <= most:
        return ""
    return f" Shown are the {most} runs with the largest shares of the evidence, of {len(data.gaps)}."


def over_frequency(document: Document, data: WhereData) -> Iterator[Block]:
    """Spectra and coherences."""
    caption = (
        "Above: spectrum of what the refitted simulator cannot predict; 1 is pure noise. A peak above the dashed line "
        "comes up by chance in 1 % of data sets; its frequency stands beside it, with the multiple of the drive "
        "frequency (dotted). Below: coherence with the thrust asked for; above the dashed line the two are "
        "linked, because the thrust makes the error or because a controller answers to it."
        f"{hidden(data, pictures_where.MOST_SPECTRA)}"
    )
    yield Heading("Over frequency", 3)
    yield Paragraph(words.frequency(document))
    yield Drawing(pictures_where.spectrum_picture(data.gaps, data.spectra), caption)


def over_motion(document: Document, data: WhereData) -> Iterator[Block]:
    """Missing force over speed, input and place."""
    caption = (
        "Acceleration that would have to be added to the simulator, as a sum over speed, input and place. All bands "
        "hold together with a probability of 95 %: where one is filled it excludes zero, and a force is missing there."
    )
    legend = (
        ("refit", "missing after refitting"),
        ("area found", "band excludes zero"),
        ("diagnosed", "missing after the diagnosis"),
    )
    yield Heading("Over speed, input and place", 3)
    yield Paragraph(words.region(document))
    yield Drawing(pictures_where.force_picture(data.profiles), caption, legend)


def which(document: Document) -> Iterator[Block]:
    """Probabilities of all hypotheses, and what cannot be told apart."""
    ranked = sorted(document["probabilities"].items(), key=lambda item: -item[1])
    v = document["verdict"]
    named = {"+".join(v["effects"]), v["kind"], *v["class"]}
    rows = [(words.hypothesis(name), p, name in named) for name, p in ranked[:MOST_BARS]]
    if len(ranked) > MOST_BARS:
        rest = ranked[MOST_BARS:]
        rows.append((f"{len(rest)} others together", sum(p for _, p in rest), False))
    yield Heading("Which effect")
    yield Bars(tuple(rows))
    yield Heading("What cannot be told apart", 3)
    yield from map(Paragraph, words.ties(document) or [words.NO_TIES])


def estimates(document: Document) -> Iterator[Block]:
    """Sizes of the named effects, and the simulator's own parameters before and after."""
    rows = []
    for name, found in document["estimates"].items():
        for key, e in found.items():
            span = " to ".join(map(words.number, e["interval95"] or ())) or "\N{EM DASH}"
            value, unit = words.number(e["value"], 4), words.unit_text(document, e["unit"])
            rows.append((words.effect_name(name), words.meaning(name, key), value, span, unit))
    own = []
    for name, p in document["parameters"].items():
        values = (words.number(p[key], 4) for key in ("nominal", "refit", "diagnosed"))
        own.append((words.OWN.get(name, name), *values, words.unit_text(document, p["unit"])))
    yield Heading("Estimates")
    if rows:
        yield Table(("effect", "quantity", "value", "95 % interval", "unit"), tuple(rows), left=2)
    yield Heading("The simulator's own parameters", 3)
    yield Table(("parameter", "as it is", "refitted", "with the diagnosis", "unit"), tuple(own))


def what_next(document: Document) -> Iterator[Block]:
    """The next experiment, and the runners-up."""
    plan = document.get("next_experiment") or {}
    yield Heading("What to do next")
    yield Paragraph(words.next_experiment(document))
    if plan.get("alternatives"):
        rows = [(a["experiment"], words.number(a["minutes"], 2), words.number(a["per_minute"], 2))
                for a in (plan, *plan["alternatives"])]  # fmt: skip
        yield Table(("experiment", "minutes", "information per minute [nats]"), tuple(rows))
