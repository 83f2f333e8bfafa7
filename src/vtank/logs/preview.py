"""What an import tells: what the log held, the columns that came of it, and what they allow to decide."""

from __future__ import annotations

import numpy as np

from ..record.run import Run
from .convert import Columns
from .decidable import Decidable
from .log import Log
from .mapping import Mapping
from .table import NAME

MESSAGES = 12  # of those not used, the most frequent that are named; a choice


def preview(run: Run, log: Log, found: Columns, allowed: Decidable, mapping: Mapping) -> str:
    """The text, ended by LF."""
    messages = sum(stream.count for stream in log.streams.values())
    by = f"preset {mapping.path.stem}" if mapping.preset else str(mapping.path)
    lines = [f"{run.name}: {log.kind}, {messages} messages, {run.duration_s:.4g} s, by {by}", "", *_columns(run, found)]
    lines += _notes(log, found)
    said = str(allowed)
    if said:
        lines += ["", *said.splitlines()]
    return "\n".join(lines) + "\n"


def _columns(run: Run, found: Columns) -> list[str]:
    """A table of the columns: rate, samples, least and greatest value, origin."""
    rows = [("column", "Hz", "samples", "least", "greatest", "from")]
    for name in run.columns:
        time_s, values = run.samples(name)
        rate = (time_s.size - 1) / np.ptp(time_s) if time_s.size > 1 else 0.0
        rows.append(
            (name, f"{rate:.3g}", str(time_s.size), f"{values.min():.4g}", f"{values.max():.4g}", found.origin[name])
        )
    wide = [max(len(row[k]) for row in rows) for k in range(5)]
    return [
        "  ".join([row[0].ljust(wide[0]), *(row[k].rjust(wide[k]) for k in range(1, 5)), row[5]]).rstrip()
        for row in rows
    ]


def _notes(log: Log, found: Columns) -> list[str]:
    """What was left out, damaged or taken for granted."""
    used = {origin.split()[0] for origin in found.origin.values()}
    others = sorted((name for name in log.streams if name not in used), key=lambda name: -log.streams[name].count)
    lines = []
    if others:
        named = ", ".join(f"{name} {log.streams[name].rate_hz:.3g} Hz" for name in others[:MESSAGES])
        lines.append(f"not used: {named}{', ...' if len(others) > MESSAGES else ''}")
    cells = log.streams[NAME].sample if NAME in log.streams else ()
    left = [repr(each) for each in cells if (NAME, each) not in found.taken]
    if left:
        lines.append(f"not taken: {', '.join(left)}; a mapping file tells what they are (--map)")
    if log.undecoded:
        lines.append(log.lost())
    if found.armed is not None:
        lines.append("motors armed: " + ("never" if not found.armed else "at times" if found.armed < 1.0 else "yes"))
    return ["", *lines, *log.remarks, *found.remarks] if lines or log.remarks or found.remarks else []
