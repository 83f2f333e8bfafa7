"""Whether a vehicle heaves, rolls and pitches where nothing tells: in the plane it does not, afloat it does.

Instruments that stand off the axes it turns about see it; where it does not turn they would seem to sit elsewhere.
"""

from __future__ import annotations

from ...rigid.fit import Fit
from ...rigid.layout import AXES, Layout
from ...rigid.noise import first_noise
from ...rigid.recorded import Recorded
from .model import blank
from .own import own_unknowns
from .settling import settled

OUT_OF_PLANE = (2, 3, 4)  # heave, roll, pitch


def in_the_plane(layout: Layout, runs: tuple[Recorded, ...]) -> tuple[tuple[Recorded, ...], tuple[str, ...]]:
    """The runs, whose axes out of the plane are still if nothing tells of them and that is likelier; and a note."""
    free = runs[0].moves & ~runs[0].asked
    untold = [i for i in OUT_OF_PLANE if free[i]]
    still = tuple(run.keeping_still(untold) for run in runs)
    if not untold or _likely(layout, still) <= _likely(layout, runs):
        return runs, ()
    names = ", ".join(AXES[i] for i in untold)
    return still, (f"nothing tells of {names}: taken as at rest, which is likelier than that they move",)


def _likely(layout: Layout, runs: tuple[Recorded, ...]) -> float:
    """Log evidence of own parameters alone, each with the noise that is likeliest beside them."""
    noise = first_noise(runs)
    model, _ = settled(blank(Fit(runs, noise), layout, (), own_unknowns(layout, runs)), noise.variance)
    return model.log_evidence
