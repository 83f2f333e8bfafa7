"""Tachometer spikes: single readings jump far from the propeller's speed (the paper's data set 4).

In a recording, a spike is a reading that stands alone and lies off by between 0.6 and 1.4 of the spikes' size.
"""

import numpy as np

from ..compiled import law
from ..lanes import where
from .effect import Effect, Parameter

SEEN = 0.6  # share of the size by which a reading must lie off: above one half, since most readings are good; a guess


@law
def reading(n: float, p: float, size: float, uniform: float) -> float:
    """Tachometer reading: off by +-size with probability p, decided by `uniform` in [0, 1) [rev/s]."""
    if uniform < 0.5 * p:
        return n + size
    return n - size if uniform < p else n


@law
def carried(lone, size):  # type: ignore[no-untyped-def]
    """Whether a reading that stands alone by `lone`, a number or any shape, carries a spike of this size [rev/s]."""
    return (np.abs(lone) > SEEN * size) & (np.abs(lone) < (2.0 - SEEN) * size)


@law
def repaired(n_read: float, lone: float, size: float) -> float:
    """Reading less the spike it carries, where it stands alone by `lone`; size = 0 repairs nothing [rev/s]."""
    return where(carried(lone, size), where(lone > 0.0, n_read - size, n_read + size), n_read)


@law
def true_input(n_read: float, lone: float, p: float, size: float) -> float:
    """Propeller speed behind a reading [rev/s]: which readings carry a spike is seen, however rare they are."""
    return repaired(n_read, lone, size)


EFFECT = Effect(
    name="tachometer_spikes",
    channel="sensor",
    place="n_rev_s",
    sentence="Brush noise throws single tachometer readings far off, though the propeller turned evenly.",
    law="n_read = n +- size with probability p, independently from reading to reading",
    parameters=(
        Parameter("p", "-", "probability per reading", 0.0, (0.0, 0.3), 0.03, counted=True),
        Parameter("size", "rev/s", "size of a spike, in the unit of the input", 0.0, (0.0, 20.0), 4.0, seen=True),
    ),
    source="Marco, Martins, Healey, section VI: spikes in the tachometer readings of data set 4",
    order=6,
    confused_with=("sonar_multipath",),
    needs=("propeller",),
    true_input=true_input,
)
