"""How well a law of the catalogue fits a cause that is its own, and one that is not."""

from __future__ import annotations

IMPERFECT = 0.01  # share of the evidence for an effect that may be due to its form; a guess
MIMICKED = 7.0  # [-] deviations at which every second cause without a name passes for a named one


def imitating(seen: float) -> float:
    """Share of causes without a name that some effect imitates to within the noise, where they show `seen` deviations.

    It falls as one over what they show, as few directions in many do (of open trials of surge, 7 of 24 at 10 to 30
    deviations, 1 of 16 above).
    """
    return MIMICKED / (MIMICKED + seen)
