"""The sections of the report, from the verdict to what to do next."""

from __future__ import annotations

from ..diagnose.diagnosis import Diagnosis, own_parameters
from ..diagnose.localise.where import WhereData
from . import pictures, pictures_where, words
from .html import bars, escape, figure, heading, paragraph, section, table
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


def opening(document: Document, data: WhereData) -> str:
    """The verdict, and the three answers in short."""
    facts = (
        ("Where", *where_in_short(document)),
        ("Which", *which_in_short(document)),
        ("How far", *far_in_short(document, data)),
    )
    cards = "".join(f"<div><dt>{a}</dt><dd><b>{escape(b)}</b>{escape(c)}</dd></div>" for a, b, c in facts)
    lead = escape(" ".join(words.explanation(document)))
    title = escape(words.headline(document))
    return f'<h1>{title}</h1>\n<p class="lead">{lead}</p>\n<dl class="facts">{cards}</dl>\n'


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
    name = {"none": "Nothing", "parameters": "Parameters", "unknown": "Unknown"}.get(v["kind"], found or "Undecided")
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


def how_far(document: Document, data: WhereData) -> str:
    """Gap before and after: on these runs, and on runs left out."""
    legend = [
        ("dot nominal-fill", "simulator as it is"),
        ("dot refit-fill", "its parameters refitted"),
        ("dot diagnosed-fill", "with the diagnosis"),
        ("area floor-fill", "noise floor"),
    ]
    caption = (
        "Each row is a run, simulated from the start that suits it best. The further left a dot, the closer the "
        "simulator follows the recording; "
        "inside the grey bar it misses no more than noise and turbulence make."
    )
    parts = [figure(pictures.gap_picture(data.gaps), caption, legend), paragraph(words.shrinkage(document))]
    if document.get("shrink"):
        caption = "Each is predicted by simulators that were chosen and fitted without it."
        parts.append(figure(pictures.shrink_picture(document), caption))
    return section("How far the gap shrinks", *parts)


def where(document: Document, data: WhereData) -> str:
    """Channel, time, frequency and region."""
    chances = document["where"]["channel"]["probability"]
    most = max(chances.values())
    rows = [(name if name != "none" else "no channel", p, p == most) for name, p in chances.items()]
    return section(
        "Where the gap lies",
        paragraph(f"{words.channel(document)} {words.runs(document)}"),
        bars(rows),
        heading("Over time"),
        paragraph(words.time(document)),
        over_time(document, data),
        heading("Over frequency"),
        paragraph(words.frequency(document)),
        over_frequency(data),
        heading("Over speed, input and place"),
        paragraph(words.region(document)),
        over_motion(data),
    )


def over_time(document: Document, data: WhereData) -> str:
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
    legend = [
        (f"{pair[0]}-colour", f"simulator {before}"),
        (f"{pair[1]}-colour", f"simulator {after}"),
        ("area floor-fill", "noise, two deviations"),
        ("area mark-fill", "significant"),
    ]
    return figure(pictures_where.time_picture(data.gaps, data.windows, pair), caption, legend)


def hidden(data: WhereData, most: int) -> str:
    """What is said when not all runs are shown."""
    if len(data.gaps) <= most:
        return ""
    return f" Shown are the {most} runs with the largest shares of the evidence, of {len(data.gaps)}."


def over_frequency(data: WhereData) -> str:
    """Spectra and coherences."""
    caption = (
        "Above: spectrum of what the refitted simulator cannot predict; 1 is pure noise. A peak above the dashed line "
        "comes up by chance in 1 % of data sets; its frequency stands beside it, with the multiple of the drive "
        "frequency (dotted). Below: coherence with the thrust asked for; above the dashed line the two are "
        "linked, because the thrust makes the error or because a controller answers to it."
        f"{hidden(data, pictures_where.MOST_SPECTRA)}"
    )
    return figure(pictures_where.spectrum_picture(data.gaps, data.spectra), caption)


def over_motion(data: WhereData) -> str:
    """Missing force over speed, input and place."""
    caption = (
        "Acceleration that would have to be added to the simulator, as a sum over speed, input and place. All bands "
        "hold together with a probability of 95 %: where one is filled it excludes zero, and a force is missing there."
    )
    legend = [
        ("refit-colour", "missing after refitting"),
        ("area found-fill", "band excludes zero"),
        ("diagnosed-colour", "missing after the diagnosis"),
    ]
    return figure(pictures_where.force_picture(data.profiles), caption, legend)


def which(document: Document) -> str:
    """Probabilities of all hypotheses, and what cannot be told apart."""
    ranked = sorted(document["probabilities"].items(), key=lambda item: -item[1])
    v = document["verdict"]
    named = {"+".join(v["effects"]), v["kind"], *v["class"]}
    rows = [(words.hypothesis(name), p, name in named) for name, p in ranked[:MOST_BARS]]
    if len(ranked) > MOST_BARS:
        rest = ranked[MOST_BARS:]
        rows.append((f"{len(rest)} others together", sum(p for _, p in rest), False))
    ties = words.ties(document) or ["Nothing that these recordings cannot tell apart."]
    return section("Which effect", bars(rows), heading("What cannot be told apart"), *map(paragraph, ties))


def estimates(diagnosis: Diagnosis, document: Document) -> str:
    """Sizes of the named effects, and the simulator's own parameters before and after."""
    rows = []
    for name, found in document["estimates"].items():
        for key, e in found.items():
            span = "\N{EM DASH}"
            if e["interval95"]:
                span = " to ".join(words.number(end) for end in e["interval95"])
            value, unit = words.number(e["value"], 4), words.unit_text(document, e["unit"])
            rows.append((words.effect_name(name), words.meaning(name, key), value, span, unit))
    effects = table(("effect", "quantity", "value", "95 % interval", "unit"), rows, 2) if rows else ""
    own = []
    for name, p in own_parameters(diagnosis.selection, diagnosis.verdict).items():
        values = (words.number(p[key], 4) for key in ("nominal", "refit", "diagnosed"))
        own.append((words.OWN.get(name, name), *values, words.unit_text(document, p["unit"])))
    header = ("parameter", "as it is", "refitted", "with the diagnosis", "unit")
    return section("Estimates", effects, heading("The simulator's own parameters"), table(header, own))


def what_next(document: Document) -> str:
    """The next experiment, and the runners-up."""
    plan = document.get("next_experiment") or {}
    ranked = [plan, *plan["alternatives"]] if plan.get("alternatives") else []
    rows = [(a["experiment"], *(words.number(a[key], 2) for key in ("minutes", "per_minute"))) for a in ranked]
    header = ("experiment", "minutes", "information per minute [nats]")
    return section("What to do next", paragraph(words.next_experiment(document)), table(header, rows) if rows else "")
