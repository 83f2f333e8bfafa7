"""The verdict held against the budget: what the evidence says, data left out must bear out.

The evidence weighs models on data that they were fitted to, step by step ahead; the budget asks what they foretell of
data they have not seen. Where the two disagree, nothing is decided.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import stdtrit

from .budget import Budget
from .evidence import Setting
from .noise_floor import plausible
from .verdict import Verdict

LIKELY = 0.95  # probability from which data left out speak against a verdict
REPEATS = 0.1  # least share of the gap that repeats without a name and yet was denied; a choice
UNSEEN = 1e-3  # share of what own parameters leave below which nothing is missing on data left out; a choice


def judged(verdict: Verdict, found: Budget, setting: Setting) -> Verdict:
    """The verdict, or that it is undecided, and why."""
    doubt = "" if verdict.kind == "undecided" else _doubt(verdict, found, setting)
    return replace(verdict, kind="undecided", doubt=doubt) if doubt else verdict


def _doubt(verdict: Verdict, found: Budget, setting: Setting) -> str:
    """What speaks against it: "worse", "repeats", "disturbance" or "unseen"; nothing where all agrees.

    The budget is one of places where there are any: what a speed log beside them misses is not in it.
    """
    if verdict.kind == "unknown":
        missing = sum(map(found.share, ("effect", "repeatable", "disturbance")))
        elsewhere = verdict.channel == "sensor" and any(
            run.has_position and not run.placed.all() for run in setting.runs
        )
        return "unseen" if missing <= UNSEEN * (missing + found.share("noise")) and not elsewhere else ""
    if verdict.kind != "none" and found.verdict.interval90[1] < 0.0 and consistent(-np.array(found.gains)):
        return "worse"
    if verdict.kind not in ("none", "parameters"):
        return ""
    if any(line.kind == "repeatable" and line.interval90[0] > REPEATS for line in found.lines):
        return "repeats"
    return "" if setting.foreign or plausible(setting.noise, setting.usual) else "disturbance"


def consistent(gains: np.ndarray) -> bool:
    """Whether gains, shape (K,), are above zero on average beyond their scatter, at 5 % by Student's t.

    A free simulation drifts with the disturbance, which may favour either model in a part.
    """
    size = gains.size
    if size < 2:
        return bool(np.all(gains > 0.0))
    return bool(gains.mean() > stdtrit(size - 1, LIKELY) * gains.std(ddof=1) / np.sqrt(size))
