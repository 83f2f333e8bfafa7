"""A sea state, and the water's motion that it makes at one point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .dispersion import Array
from .orbit import Complex, Orbit, point
from .spectrum import bins

KINDS = ("none", "regular", "irregular")


@dataclass(frozen=True)
class Waves:
    """Waves that travel towards the wall ahead.

    Attributes:
        kind: one of KINDS.
        height_m: crest to trough of regular waves; significant height 4 sqrt(m0) of irregular ones [m].
        period_s: of regular waves; peak period of irregular ones [s].
        water_depth_m: from the still surface to the bed; infinite for deep water [m].
        peakedness: JONSWAP's gamma; 1 is Pierson and Moskowitz's spectrum [-].
        components: of an irregular sea.
        reflection: share of the amplitude that the wall ahead sends back, 0 to 1.
        ramp_s: time over which the waves are faded in [s].
    """

    kind: str = "none"
    height_m: float = 0.0
    period_s: float = 6.0
    water_depth_m: float = float("inf")
    peakedness: float = 3.3  # mean of JONSWAP's measurements (Hasselmann et al., 1973)
    components: int = 200
    reflection: float = 0.0
    ramp_s: float = 0.0


def surface(waves: Waves, random: np.random.Generator) -> tuple[Array, Complex]:
    """Frequencies [rad/s] and complex amplitudes a exp(i phase) [m] of the surface's components, shape (M,) each.

    A regular wave has its crest at x = 0 at t = 0. In an irregular sea amplitudes are the spectrum's; phases and the
    frequencies' places within their bins are random, so that the sea does not repeat itself.
    """
    if waves.kind == "none":
        return np.empty(0), np.empty(0, dtype=np.complex128)
    if waves.kind == "regular":
        return np.array([2.0 * np.pi / waves.period_s]), np.array([0.5 * waves.height_m + 0.0j])
    edges, variance = bins(waves.height_m, waves.period_s, waves.peakedness, waves.water_depth_m, waves.components)
    place, phase = random.random((2, waves.components))
    return edges[:-1] + place * np.diff(edges), np.sqrt(2.0 * variance) * np.exp(2j * np.pi * phase)


def orbit(waves: Waves, depth_m: float, to_wall_m: float, random: np.random.Generator) -> Orbit:
    """The water's motion at x = 0 and depth_m below the surface, a wall standing to_wall_m ahead."""
    rad_s, amplitude = surface(waves, random)
    return point(rad_s, amplitude, -depth_m, waves.water_depth_m, wall=(to_wall_m, waves.reflection))
