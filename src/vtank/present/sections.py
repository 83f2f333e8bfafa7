"""The sections of the report, from the verdict to what to do next, as blocks of a document."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ..diagnose.localise.where import WhereData
from . import likeness, pictures, pictures_budget, pictures_where, words, words_budget
from .blocks import Bars, Block, Drawing, Heading, Paragraph, Table, Terms
from .words import WORDS, Document

MOST_BARS = 8  # hypotheses listed by name; the rest are summed up


def sections(document: Document, data: WhereData) -> Iterator[Block]:
    """The whole report."""
    for section in (opening, budget, how_far, runs, where, over_time, over_frequency, over_motion):
        yield from section(document, data)
    for rest in (which, estimates, laws, simulator, what_next):
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
    name = WORDS["short"].get(v["kind"], found or "Undecided")
    return name[:1].upper() + name[1:], f"probability {words.percent(v['probability'])}"


def far_in_short(document: Document, data: WhereData) -> tuple[str, str]:
    """The shrinkage: on runs left out where that was worked out, on these runs otherwise."""
    s = document.get("shrink") or {}
    if s.get("fraction_closed") is not None:
        return f"{words.closed(s)} closed", f"of what refitting leaves beyond noise, on {words.left_out(document)}"
    if rest := document.get("unexplained"):
        named = sum(line["share"] for line in document["budget"] if line["kind"] in ("parameters", "effect"))
        size = words_budget.share(rest["share"])
        return (
            f"{words_budget.share(max(named, 0.0))} accounted for",
            f"of {words_budget.whole_of(document)}; {size} is not sensor noise either",
        )
    before, after = pictures_where.pair_of(document)
    unit = data.gaps[0].unit
    sizes = [(sum(g.rms(s) ** 2 for g in data.gaps) / len(data.gaps)) ** 0.5 for s in (before, after)]
    change = f"{words.length(sizes[0], unit)} to {words.length(sizes[1], unit)}"
    return change, f"error, simulator {WORDS['called'][before]} to {WORDS['called'][after]}, on these runs"


def drawing(name: str, svg: str, **values: object) -> Drawing:
    """A picture with the caption and the legend of that name in words.toml, the values in their places."""
    legend = tuple((style.format(**values), text.format(**values)) for style, text in WORDS[name].get("legend", ()))
    return Drawing(svg, " ".join(WORDS[name]["caption"].format(**values).split()), legend)


def budget(document: Document, data: WhereData) -> Iterator[Block]:
    """What the gap is made of."""
    yield Heading("What the gap is made of")
    yield from map(Paragraph, words_budget.budget(document) or ["This was not worked out."])
    if lines := document.get("budget"):
        before = "drag and thrust alone" if words.foreign(document) else "the simulator as it is"
        svg = pictures_budget.budget_picture(lines, document)
        yield drawing("budget", svg, before=before, left_out=words.left_out(document))


def runs(document: Document, data: WhereData) -> Iterator[Block]:
    """Measured and simulated, before and after."""
    before = words.simulators(document)[0]
    yield Heading("Every run, before and after", 3)
    svg = pictures_budget.runs_picture(data.gaps, before)
    yield drawing("runs", svg, before_style=before, before=WORDS["called"][before])


def how_far(document: Document, data: WhereData) -> Iterator[Block]:
    """Gap before and after: on these runs, and on runs left out."""
    yield Heading("How far the gap shrinks")
    shown = words.simulators(document)
    picture = drawing("gap", pictures.gap_picture(data.gaps, shown))
    dots = {f"dot {name}" for name in pictures.SIMULATORS if name not in shown}
    yield replace(picture, legend=tuple(row for row in picture.legend if row[0] not in dots))
    yield Paragraph(words.shrinkage(document))
    if document.get("shrink"):
        yield drawing("shrink", pictures.shrink_picture(document))


def where(document: Document, data: WhereData) -> Iterator[Block]:
    """The channel, and the runs that show it."""
    chances = document["where"]["channel"]["probability"]
    most = max(chances.values())
    yield Heading("Where the gap lies")
    yield Paragraph(f"{words.channel(document)} {words.runs(document)}")
    yield Bars(tuple((name if name != "none" else "no channel", p, p == most) for name, p in chances.items()))


def over_time(document: Document, data: WhereData) -> Iterator[Block]:
    """Residuals with the windows that matter."""
    pair = pictures_where.pair_of(document)
    before, after = (WORDS["called"][name] for name in pair)
    better = f"the simulator {after} predicts better than {before}"
    if found := WORDS["unnamed"].get(data.windows[0].after):
        better = f"{found}, put on top of the best known explanation, predicts better than that alone"
    left = hidden(data, pictures_where.MOST_RUNS)
    svg = pictures_where.time_picture(data.gaps, data.windows, pair)
    yield Heading("Over time", 3)
    yield Paragraph(words.time(document))
    yield drawing("time", svg, pair=pair, before=before, after=after, better=better, hidden=left)


def hidden(data: WhereData, most: int) -> str:
    """What is said when not all runs are shown."""
    if len(data.gaps) <= most:
        return ""
    return f" Shown are the {most} runs with the largest shares of the evidence, of {len(data.gaps)}."


def over_frequency(document: Document, data: WhereData) -> Iterator[Block]:
    """Spectra and coherences."""
    svg = pictures_where.spectrum_picture(data.gaps, data.spectra)
    yield Heading("Over frequency", 3)
    yield Paragraph(words.frequency(document))
    yield drawing("frequency", svg, hidden=hidden(data, pictures_where.MOST_SPECTRA))


def over_motion(document: Document, data: WhereData) -> Iterator[Block]:
    """Missing force over speed, input and place."""
    yield Heading("Over speed, input and place", 3)
    yield Paragraph(words.region(document))
    yield drawing("motion", pictures_where.force_picture(data.profiles))


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
    rows = tuple((*names, span or "\N{EM DASH}", unit) for *names, span, unit in words.estimates(document))
    yield Heading("Estimates")
    if rows:
        yield Table(("effect", "quantity", "value", "95 % interval", "unit"), rows, left=2)
    yield Heading("Drag and thrust", 3)
    header = ("parameter", "as it is", "refitted", "with the diagnosis", "unit")
    own: list[tuple[str, ...]] = [header, *words.own_parameters(document)]
    if words.foreign(document):
        own = [(row[0], *row[2:]) for row in own]
    yield Table(own[0], tuple(own[1:]))
    if found := tuple(words.in_newton(document)):
        yield Table(("with the diagnosis", "value", "95 % interval", "unit"), found)


def laws(document: Document) -> Iterator[Block]:
    """What a cause without a name may be."""
    if told := [*words_budget.laws(document)]:
        yield Heading("The missing law")
        yield from map(Paragraph, told)


def simulator(document: Document) -> Iterator[Block]:
    """The plant that stands for another's simulator."""
    if "against" in document:
        yield Heading("The simulator")
        yield from likeness.tables(document)


def what_next(document: Document) -> Iterator[Block]:
    """The next experiment, and the runners-up."""
    plan = document.get("next_experiment") or {}
    yield Heading("What to do next")
    yield Paragraph(words.next_experiment(document))
    if plan.get("alternatives"):
        rows = [(a["experiment"], words.number(a["minutes"], 2), words.number(a["per_minute"], 2))
                for a in (plan, *plan["alternatives"])]  # fmt: skip
        yield Table(("experiment", "minutes", "information per minute [nats]"), tuple(rows))
