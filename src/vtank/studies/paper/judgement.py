"""Findings from the four published sets, judged together with T and the rest unknown, and their table."""

from __future__ import annotations

import numpy as np

from ...estimate.paper import Array
from ...present import Table, listed
from .campaign import Campaign
from .evidence import (
    FAILS,
    HOLDS,
    PARTLY,
    WITHIN,
    Finding,
    Results,
    filled,
    numbers,
    percents,
    steady,
    told,
)
from .joint import (
    BETWEEN,
    CLASSES,
    HIGH,
    JUDGED,
    LOW,
    MISFITS,
    MULTIPLES,
    OF_RUN,
    OF_WORLD,
    READINGS,
    REPEATS,
    STEPS_S,
    Joint,
)
from .published import published

DECIDES = 10.0  # ratio of likelihoods from which one side counts as shown, its 90 % interval included; a convention
SETTLED, LITERAL = READINGS


def sample_time(r: Results) -> Finding:
    """What the four sets say about T."""
    tau, deviation = (published()[2].values[name] for name in ("tau", "deviation"))
    ends, without = quantiles(r.joint), quantiles(r.joint, JUDGED[:3])
    literal = quantiles(r.joint, reading=LITERAL)
    return told(
        "sample_time",
        HOLDS if ends[2] <= WITHIN * ends[0] else PARTLY,
        printed=numbers(np.sort(tau)),
        limit=numbers(1.5 * np.sort(tau)),
        deviation=f"{deviation.min():.3f} to {deviation.max():.3f}",
        settled="{1:g} s [{0:g}, {2:g}]".format(*ends),
        without="{1:g} s [{0:g}, {2:g}]".format(*without),
        literal="{1:g} s [{0:g}, {2:g}]".format(*literal),
    )


def printed_q(r: Results) -> Finding:
    """Did the authors run the literal Q?"""
    preference, b = r.joint.preference, published()[2].values["b"]
    apart = b.max() / b.min()
    share = [steady(r.joint.estimates[reading][..., 1], apart).mean(axis=(0, 2, 3)).max() for reading in READINGS]
    return told(
        "printed_q",
        FAILS if preference >= DECIDES else HOLDS if preference <= 1.0 / DECIDES else PARTLY,
        preference=preference,
        apart=apart,
        settled=percents(share[:1]),
        literal=percents(share[1:]),
        misfit=misfit(r.joint, SETTLED),
        other=misfit(r.joint, LITERAL),
        grown=min(growth(c, "kalman") for c in r.campaigns.values()),
        steadied=min(growth(c, "kalman_settling") for c in r.campaigns.values()),
    )


def growth(campaign: Campaign, method: str) -> float:
    """Final variance of C2 = T/tau over that after a quarter of data set 1, Model III."""
    variance = campaign.paper[method, "III", 0].evolution.variance[:, 1]
    return float(variance[-1] / variance[variance.size // 4])


def artefact(r: Results) -> Finding:
    """Is the published drag an artefact?"""
    remain = left(r.joint)
    return told(
        "artefact",
        HOLDS if remain == [LOW] else FAILS if remain == [HIGH] else PARTLY,
        settled=with_interval(r.joint.odds(SETTLED, HIGH)),
        between=with_interval(r.joint.odds(SETTLED, BETWEEN)),
        literal=with_interval(r.joint.odds(LITERAL, HIGH)),
        left=listed(remain),
        decides=DECIDES,
        before=percents([np.size(MULTIPLES[of]) / len(MULTIPLES) for of in CLASSES.values()]),
        shares=percents([r.joint.over(SETTLED, "drag")[of].sum() for of in CLASSES.values()]),
        by_step=", ".join(f"{step:g} s {r.joint.odds(SETTLED, HIGH, k)[1]:.2g}" for k, step in enumerate(STEPS_S)),
    )


def left(joint: Joint) -> list[str]:
    """Classes of drag that the best one does not beat by DECIDES, its interval included, where Q settles."""
    drag = joint.over(SETTLED, "drag")
    best = max(CLASSES, key=lambda name: float(drag[CLASSES[name]].mean()))
    return [name for name in CLASSES if joint.odds(SETTLED, name, of=best)[0] < DECIDES]


def quantiles(joint: Joint, judged: tuple[str, ...] = JUDGED, reading: str = SETTLED) -> list[float]:
    """5 %, 50 % and 95 % of T [s], of STEPS_S."""
    below = np.cumsum(joint.over(reading, "step", judged))
    return [STEPS_S[int(np.searchsorted(below, level * below[-1]))] for level in (0.05, 0.5, 0.95)]


def with_interval(ratio: Array) -> str:
    """A ratio of likelihoods with its 90 % interval."""
    return "{1:.2g} [{0:.2g}, {2:.2g}]".format(*ratio.tolist())


def misfit(joint: Joint, reading: str) -> float:
    """Median over h of the factor that a printed number is off a simulated one."""
    below = np.cumsum(joint.over(reading, "misfit"))
    return float(np.exp(MISFITS[int(np.searchsorted(below, 0.5))]))


def joint_table(joint: Joint) -> Table:
    """Likelihood of each true drag over the best, T unknown and at every T."""
    of_step = joint.likelihoods[SETTLED].sum(axis=(0, 3)).T
    weight = joint.over(SETTLED, "step")
    lines = [("unknown", of_step.sum(axis=0), ""), ("unknown, q_ii = 1", joint.over(LITERAL, "drag"), "")]
    lines[1:1] = [(f"{step:g} s", of_step[k], f"{100.0 * weight[k]:.1f}") for k, step in enumerate(STEPS_S)]
    rows = [(name, *(f"{x:.2f}" for x in of / of.max()), share) for name, of, share in lines]
    worlds = [joint.estimates[reading].shape[2] for reading in READINGS]
    heaviest = percents([joint.over(reading, "world").max() for reading in READINGS])
    guesses = listed([f"{key} {low:g} to {high:g}" for key, (low, high) in (OF_WORLD | OF_RUN).items()])
    note = filled("joint_note", worlds=worlds[0], literal=worlds[1], repeats=REPEATS, guesses=guesses, share=heaviest)
    header = ("T", *(f"{multiple:g} times" for multiple in MULTIPLES), "share of T [%]")
    return Table(header, tuple(rows), (note,))


JUDGEMENT = (sample_time, artefact, printed_q)  # as the page has them
