"""The missing law: up to three formulas for what no effect of the catalogue explains, the best first."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from ...plant.formula import Formula
from ..evidence import Fitted, Setting, evaluate
from ..freeform import pursue
from ..noise_floor import noise_at
from ..prior import calibration
from .heldout import Left, closed, floor
from .metric import metric
from .motion import motions
from .refit import Refitted, polished, refitted
from .screen import Table, screened, within
from .words import sentence

MOST = 3  # laws that are shown
TRIED, CARRIED = 10, 6  # formulas of one modulator that are fitted, and formulas that are fitted to the end
QUIETER = 0.7  # fall of the disturbance, once a law is known, from which all is weighed anew; a choice
FORMULAS = 8.0  # [nats] log of the number of structures that were looked at
WITHIN = 3.0  # [nats] by which formulas that are called as good as each other differ
SAME = 1.0  # [nats] that tell two formulas apart on average, below which they are one in two forms; a choice
WORTH = 0.03  # share of the gap that a further factor must close; a choice
OVER = 50.0  # [nats] left over at which nothing is left of a probability; keeps numbers finite
UNSEEN = 0.1  # odds beforehand that a law has no form of the grammar; a choice
NINETY = 1.644854  # deviations of a 90 % interval


@dataclass(frozen=True)
class Law:
    """A formula that would be the missing law.

    Attributes:
        formula: structure, numbers and unit.
        parameters: its numbers by slot: value, interval90, unit.
        sentence: what it says.
        gap_closed: share of the gap between refit and floor of noise that it closes on stretches left out.
        probability: that it is the law, among all that were weighed and none of these.
        tied: formulas as good as this, in text.
        fit: of the whole simulator with it.
    """

    formula: Formula
    parameters: dict[str, dict[str, Any]]
    sentence: str
    gap_closed: float
    probability: float
    tied: tuple[str, ...]
    fit: Fitted = field(repr=False)

    def document(self) -> dict[str, Any]:
        """As plain data."""
        told: dict[str, Any] = {
            "formula": f"{self.formula.text()} [{self.formula.unit}]",
            "channel": self.formula.channel,
        }
        told |= {"place": self.formula.place, "parameters": self.parameters, "sentence": self.sentence}
        return told | {"gap_closed": self.gap_closed, "probability": self.probability, "tied": list(self.tied)}


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # of candidates that run away, which gain nothing
def laws(setting: Setting, fit: Fitted, channel: str, fitted: Sequence[np.ndarray]) -> tuple[Law, ...]:
    """Up to three laws for what a fit leaves over, in a channel: "hydrodynamics", "actuator" or "sensor".

    Forces are rivals of a sensor's errors too, since the channel is told less surely than the law.

    fitted: per run, the free-form force over the input's stamps [m/s2], shape (I,), which mends the motion that the
    formulas are functions of; of a sensor's error, it is not used.
    """
    ranged = channel == "sensor" and all(run.has_position for run in setting.runs)
    tables = [
        Table(motions(fit, fitted, sensor), "range" if sensor else "force", setting.runs[0].input_name)
        for sensor in (False, True)[: 1 + ranged]
    ]
    setting, fit, found = _weighed(setting, fit, tables)
    left = Left(fit)
    pairs = [(r, Left(r.fit)) for r in found if r.weight > fit.log_evidence + FORMULAS]
    pairs = sorted((pair for pair in pairs if pair[1].cost < left.cost), key=lambda pair: pair[1].cost - pair[0].weight)
    if not pairs:
        return ()
    before, least = left.squares(setting), floor(setting, pairs[0][0].fit)
    shares = [closed(before, own.squares(setting), least) for _, own in pairs]
    ranked = _distinct(_spare([(*pair, share) for pair, share in zip(pairs, shares, strict=True) if share > 0.0]))
    if not ranked:
        return ()
    chances = _chances([r.weight - own.cost for r, own, _ in ranked]) * _sure(ranked[0][0])
    out = []
    for (r, _, share), chance in list(zip(ranked, chances, strict=True))[:MOST]:
        tied = tuple(o.formula.text() for o, _, _ in ranked if o is not r and abs(o.weight - r.weight) < WITHIN)
        out.append(Law(r.formula, numbers(r), sentence(r.formula), share, float(chance), tied, r.fit))
    return tuple(out)


def _spare(ranked: list[tuple[Refitted, Left, float]]) -> list[tuple[Refitted, Left, float]]:
    """Without formulas that are another with one factor more and close no more of the gap."""
    return [
        (r, own, share) for r, own, share in ranked
        if not any(within(o.formula, r.formula) and other > share - WORTH for o, _, other in ranked)
    ]  # fmt: skip


def _distinct(ranked: list[tuple[Refitted, Left, float]]) -> list[tuple[Refitted, Left, float]]:
    """Without formulas that say the same as a better one in another form: no recording could tell them apart."""
    out, shown = list[tuple[Refitted, Left, float]](), list[np.ndarray]()
    for one in ranked:
        whitened = np.concatenate([f.innovation / np.sqrt(f.variance) for f in one[0].fit.filtered])
        if all(0.5 * float(np.sum((whitened - other) ** 2)) > SAME for other in shown):
            out.append(one)
            shown.append(whitened)
    return out


def _weighed(setting: Setting, fit: Fitted, tables: Sequence[Table]) -> tuple[Setting, Fitted, list[Refitted]]:
    """The promising formulas fitted, at the noise that is left once a law is known."""
    found = _tried(setting, fit, tables)
    noise = noise_at(found[0].fit.problem, found[0].fit.optimum.theta, setting.usual)
    if noise.sigma < QUIETER * setting.noise.sigma:
        setting = setting.with_noise(noise)
        fit = evaluate(setting, fit.hypothesis, [fit.start()])
        found = _tried(setting, fit, tables)
    with ThreadPoolExecutor(2) as pool:  # the compiled kernels release the interpreter
        return setting, fit, list(pool.map(partial(polished, setting), found[:CARRIED]))


def _tried(setting: Setting, fit: Fitted, tables: Sequence[Table]) -> list[Refitted]:
    """Quick fits of the promising formulas, the best first."""
    promising = [(p, table.runs) for table in tables for p in screened(table, metric(fit, table.acts), TRIED)]
    with ThreadPoolExecutor(2) as pool:
        found = pool.map(lambda one: refitted(setting, fit, one[0].formula, one[1]), promising)
        return sorted(found, key=lambda r: -r.weight)


def _chances(weights: Sequence[float]) -> np.ndarray:
    """Probabilities from means of log evidence and held-out log likelihood, tempered as all evidence is."""
    power = 0.5 * calibration().tempering * np.asarray(weights)
    odds = np.exp(power - np.max(power))
    return np.asarray(odds / np.sum(odds))


def _sure(best: Refitted) -> float:
    """Probability that the law is among these forms: what the best leaves over speaks for none of them."""
    return (1.0 - calibration().doubt) / (1.0 + UNSEEN * float(np.exp(min(pursue(best.fit).gain, OVER))))


def numbers(r: Refitted) -> dict[str, dict[str, Any]]:
    """The numbers of a formula with 90 % intervals."""
    values, sd = r.fit.values, np.sqrt(np.maximum(np.diag(r.covariance()), 0.0))
    return {
        ("size" if name.endswith(r.formula.acts) else name.partition(".")[2]): {
            "value": values[name], "unit": r.formula.unit_of(name),
            "interval90": [values[name] - NINETY * float(s), values[name] + NINETY * float(s)],
        }
        for name, s in zip(r.formula.fitted(), sd, strict=True)
    }  # fmt: skip
