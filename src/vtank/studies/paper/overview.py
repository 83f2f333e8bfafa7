"""The main numbers of some campaigns on one small table."""

from __future__ import annotations

from collections.abc import Mapping

from ...estimate.paper import Model
from ...plant import to_feet
from ...present.document import Table
from .campaign import Campaign
from .published import OF_MODEL, PARAMETERS
from .tables import Entry

SHOWN: tuple[tuple[str, Model], ...] = (
    ("paper-ii", "I"),
    ("paper-ii", "II"),
    ("paper-iii", "III"),
    ("physical", "III"),
)
HEADER = ("model, truth", "from", "a [1/ft]", "b [ft/rev2]", "gamma [1/rev]", "tau [s]")
ROWS = ("truth", "paper's estimator, data set 1", "least squares, data set 1", "maximum likelihood, all four")


def overview(campaigns: Mapping[str, Campaign]) -> Table:
    """Truth, the paper's estimator, least squares and maximum likelihood, for Models I, II and III."""
    rows, kinds = [], []
    for truth, model in SHOWN:
        if truth in campaigns:
            for source, cells in zip(ROWS, _cells(campaigns[truth], model), strict=True):
                first = source == ROWS[0]
                rows.append((f"Model {model}, {truth}" if first else "", source, *cells))
                kinds.append("truth first" if first else "")
    return Table(HEADER, tuple(rows), kinds=tuple(kinds), left=2)


def _cells(campaign: Campaign, model: Model) -> tuple[tuple[str, ...], ...]:
    joint = campaign.joint[model]
    columns = (
        (to_feet(campaign.truth.lumped), (0.0,) * 4),
        (campaign.paper["kalman", model, 0].feet, (0.0,) * 4),
        (campaign.paper["least_squares", model, 0].feet, (0.0,) * 4),
        (to_feet(joint.parameters), to_feet(joint.sd)),
    )
    return tuple(tuple(_cell(model, *of) for of in zip(PARAMETERS, values, sd, strict=True)) for values, sd in columns)


def _cell(model: Model, name: str, value: float, sd: float) -> str:
    return Entry(0, "", name, "", value, sd).text if name in OF_MODEL[model] else ""
