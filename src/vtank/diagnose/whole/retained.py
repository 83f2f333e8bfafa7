"""Effects that stay beside what has no name: a free-form part somewhere else takes nothing over from them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...rigid.filtered import Filtered
from ...rigid.layout import Layout
from ...rigid.places import Sizes
from .lesser import without
from .model import Model, refit
from .score import based
from .unnamed import at_place

STAYS = 0.5  # share of what an effect explains that has to be its own beside a free-form part; a choice


def retained(model: Model, place: str, layout: Layout, found: Sequence[Filtered], sizes: Sizes) -> set[str]:
    """Names of the effects of a model that are needed as well beside a free-form part at a place as without one.

    One cause without a name there is no explanation of what they do; of an effect that but imitates it, the free-form
    part takes over what the effect explains.
    """

    def beside(fitted: Model) -> float:
        return max((block.gain for block in at_place(based(fitted, found), sizes, place)), default=np.inf)

    here = refit(model, found, model.theta, steps=0)
    most, stay = beside(here), set[str]()
    for placed in model.effects if np.isfinite(most) else ():
        less = without(here, layout, [placed], found)
        explains = here.log_evidence - less.log_evidence
        if explains > 0.0 and beside(less) - most < (1.0 - STAYS) * explains:
            stay.add(placed.name)
    return stay
