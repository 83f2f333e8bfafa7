"""What effects seem to explain where there is nothing to explain: a plant held against the runs it was fitted to."""

from __future__ import annotations

from ...rigid.fit import Fit
from ...rigid.layout import Layout
from ...rigid.noise import KEPT
from ...rigid.places import catalogue
from .model import blank, own_unknowns
from .score import based, promises
from .settling import settled
from .sizes import sizes_of
from .unnamed import unnamed


def mimicry(layout: Layout, fit: Fit) -> dict[str, float]:
    """Log evidence that EFFECT@PLACE and unknown@PLACE find beside own parameters, at least 0."""
    moves = fit.runs[0].moves
    model, found = settled(
        blank(fit, layout, (), own_unknowns(layout, moves)), fit.noise.variance, KEPT * fit.noise.variance
    )
    sizes, base = sizes_of(model, found), based(model, found)
    tried = [(promise.placed.effect, promise.placed.place, promise.gain)
             for promise in promises(model, base, layout, catalogue(layout, moves, sizes))]  # fmt: skip
    tried += [("unknown", block.place, block.gain) for block in unnamed(model, found, base, sizes)]
    gains: dict[str, float] = {}
    for effect, place, gain in tried:
        name = f"{effect}@{place}"
        gains[name] = max(float(gain), gains.get(name, 0.0))
    return gains
