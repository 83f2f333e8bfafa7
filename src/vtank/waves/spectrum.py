"""JONSWAP spectrum with the TMA factor of finite depth, normalised to its significant wave height.

Written out rather than taken from a library: the packages that carry it (wavespectra, mhkit) bring xarray or a data
stack along for these ten lines.

Sources: Hasselmann et al., Deutsche Hydrographische Zeitschrift A8-12 (1973); Bouws et al., J. Geophys. Res. 90 (1985)
for the TMA factor, with Kitaigorodskii's function in the form tanh(kh)^2/(1 + 2kh/sinh(2kh)).
"""

from __future__ import annotations

import numpy as np

from .dispersion import Array, wave_number

NARROW, WIDE = 0.07, 0.09  # [-] widths of the peak below and above its frequency (Hasselmann et al.)
BAND = (0.5, 6.0)  # of the peak frequency; a Pierson-Moskowitz sea has 0.1 % of its energy outside; a choice
FINE = 8  # points of quadrature to each component; a choice


def jonswap_shape(rad_s: Array, peak_rad_s: float, peakedness: float) -> Array:
    """JONSWAP's shape without its scale [s5]: w^-5 exp(-5/4 (w_p/w)^4) gamma^exp(-(w - w_p)^2/(2 s^2 w_p^2))."""
    width = np.where(rad_s <= peak_rad_s, NARROW, WIDE)
    peak = peakedness ** np.exp(-0.5 * ((rad_s - peak_rad_s) / (width * peak_rad_s)) ** 2)
    return np.asarray(rad_s**-5.0 * np.exp(-1.25 * (peak_rad_s / rad_s) ** 4) * peak)


def finite_depth(rad_s: Array, depth_m: float) -> Array:
    """TMA factor [-]: 1 in deep water, (k h)^2/2 in shallow water."""
    x = 2.0 * wave_number(rad_s, depth_m) * depth_m
    with np.errstate(over="ignore"):
        return np.asarray(np.tanh(0.5 * x) ** 2 / (1.0 + x / np.sinh(x))) if np.isfinite(depth_m) else np.ones_like(x)


def bins(height_m: float, period_s: float, peakedness: float, depth_m: float, count: int) -> tuple[Array, Array]:
    """The spectrum in `count` bins of equal width: edges (count + 1,) [rad/s] and variance of each (count,) [m2].

    height_m: significant, so that the variances add up to (height/4)^2 whatever the cut at the band's ends.
    """
    peak = 2.0 * np.pi / period_s
    edges = peak * np.linspace(*BAND, count + 1)
    step = (edges[1] - edges[0]) / FINE
    w = edges[0] + step * (np.arange(count * FINE) + 0.5)
    energy = (jonswap_shape(w, peak, peakedness) * finite_depth(w, depth_m)).reshape(count, FINE).sum(axis=1)
    return edges, energy * ((height_m / 4.0) ** 2 / energy.sum())
