"""The page of findings: what holds, what does not, each sentence filled from the results."""

from __future__ import annotations

from ...present import Block, Heading, Paragraph, listed
from .central import CENTRAL
from .claims import CLAIMS
from .evidence import Results, filled, span
from .joint import BETWEEN, HIGH
from .judgement import DECIDES, JUDGEMENT, SETTLED, joint_table, left, quantiles, with_interval
from .published import brutzman_a_per_ft, published


def page(r: Results) -> list[Block]:
    """The whole page."""
    return [
        Heading("Findings: the published drag and the paper's estimator", 1),
        Paragraph(summary(r)),
        Heading("What the four published sets say together"),
        *(finding(r).block for finding in JUDGEMENT),
        joint_table(r.joint),
        Heading("What the estimator does"),
        *(finding(r).block for finding in CENTRAL),
        Heading("What the paper says of its method"),
        *(finding(r).block for finding in CLAIMS),
        Heading("How this was found"),
        Paragraph(method(r)),
    ]


def summary(r: Results) -> str:
    """The answer in one paragraph."""
    low, middle, high = quantiles(r.joint)
    return filled(
        "summary",
        printed=span(published()[2].values["a"] / brutzman_a_per_ft(), 0),
        step=f"{middle:g} s, with 90 % between {low:g} and {high:g} s",
        odds=with_interval(r.joint.odds(SETTLED, HIGH)),
        between=with_interval(r.joint.odds(SETTLED, BETWEEN)),
        left=listed(left(r.joint)),
        decides=DECIDES,
    )


def method(r: Results) -> str:
    """What was simulated."""
    ways = len({level.key for level in r.study.levels})
    return filled("method", seeds=r.study.seeds, seed=r.study.seed, truths=len(r.study.truths), ways=ways)
