"""What was found missing without a name, as plain data."""

from __future__ import annotations

from typing import Any

import numpy as np

from .evidence import Fitted
from .freeform import OWN, Component
from .selection import Selection
from .verdict import Verdict


def unnamed(selection: Selection, verdict: Verdict) -> list[dict[str, Any]]:
    """What the verdict's model lacks, the largest gain of evidence first.

    Each has `kind`, `channel`, `about`, whether it is a `force` (else an error of the readings), its `gain` [nats], the
    `windows` in which it shows, its `frequency_rad_s`; and by how much an own parameter differs in every run, `runs`.
    """
    free = next((f for f in selection.free if f.fit is verdict.fit), None)
    components = sorted(free.components if free else (), key=lambda c: -c.gain)
    return [_told(selection, component) for component in components]


def _told(selection: Selection, c: Component) -> dict[str, Any]:
    names = [run.name for run in selection.setting.runs]
    told = {name: getattr(c, name) for name in ("kind", "channel", "about", "force", "gain")}
    windows = [{"run": names[k], "from": start, "to": end} for k, start, end in c.windows]
    fit = next((f.fit for f in selection.free if c.own and OWN[c.about] in f.fit.problem.per_run), None)
    runs = _by_run(fit, OWN[c.about]) if fit else []
    return told | {"windows": windows, "frequency_rad_s": c.frequency, "runs": runs}


def _by_run(fit: Fitted, name: str) -> list[dict[str, Any]]:
    """An own parameter in every run: by how much of the mean over the runs it differs from that, with deviation."""
    runs, i = fit.problem.runs, fit.problem.per_run.index(name)
    at = [fit.problem.own_slice(k).start + i for k in range(len(runs))]
    values, sd = fit.optimum.theta[at], np.sqrt(np.diag(fit.covariance())[at])
    mean = float(np.mean(values))
    changes = zip(runs, values / mean - 1.0, sd / abs(mean), strict=True)
    return [{"run": run.name, "change": float(change), "sd": float(s)} for run, change, s in changes]
