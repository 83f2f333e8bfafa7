"""What effects seem to explain where there is nothing to explain: a plant held against the runs it was fitted to."""

from __future__ import annotations

from ...rigid.fit import Fit
from ...rigid.layout import Layout
from ...rigid.noise import KEPT
from ...rigid.places import catalogue
from .model import blank
from .own import own_unknowns
from .score import based, promises
from .settling import settled
from .sizes import sizes_of
from .unnamed import NAMELESS, unnamed


def mimicry(layout: Layout, fit: Fit) -> dict[str, float]:
    """Log evidence that EFFECT@PLACE finds beside own parameters, and NAMELESS the most wherever; at least 0.

    Other runs take the vehicle elsewhere, where what a plant misses may come up at another place.
    """
    moves, variance = fit.runs[0].moves, fit.noise.variance
    own, least = own_unknowns(layout, fit.runs), KEPT * variance  # a simulator's own runs may have no noise at all
    model, found = settled(blank(fit, layout, (), own), variance, least, alone=True)
    sizes, base = sizes_of(model, found), based(model, found)
    blocks = unnamed(model, found, base, sizes, least=least)
    gains = {NAMELESS: max([0.0, *(float(block.gain) for block in blocks)])}
    for promise in promises(model, base, layout, catalogue(layout, moves, sizes)):
        name = f"{promise.placed.effect}@{promise.placed.place}"
        gains[name] = max(float(promise.gain), gains.get(name, 0.0))
    return gains
