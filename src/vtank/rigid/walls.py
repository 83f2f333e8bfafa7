"""Where the walls stand that the sonars of several runs hear ahead."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from .layout import SENSOR, SITE
from .readings import POSITION, RANGE
from .recorded import Recorded

ASKEW = 0.4  # [rad] between the headings at which runs start before one wall; a choice


def facing_walls(runs: Sequence[Recorded]) -> tuple[Recorded, ...]:
    """The runs before their walls: one wall for all that start at about one heading.

    A wall stands still, while the first sample of a heading has its noise: of a wall of its own for each run, some
    metres to the side a sonar would tell another heading than the compass.
    """
    found, facing = list[Recorded](), list[float]()
    for run in runs:
        heading, wall = float(run.start[5]), bool((run.kind == RANGE).any() and not (run.kind == POSITION).any())
        near = (other for other in facing if abs(np.angle(np.exp(1j * (heading - other)))) < ASKEW)
        square = next(near, heading) if wall else heading
        facing += [square] if wall else []
        found.append(replace(run, facing=square, wall=_wall(run, square)))
    return tuple(found)


def _wall(run: Recorded, facing: float) -> float:
    """Distance ahead of the start to the wall that the first ranges tell, by where their sonar sits [m]; 0 without."""
    heard, layout = np.flatnonzero(run.kind == RANGE), run.layout
    if not heard.size:
        return 0.0
    at = layout.starts[2] + SENSOR * run.sensor[heard[0]] + SITE
    roll, pitch, heading = run.start[3:6]
    ahead = Rotation.from_euler("ZYX", [heading - facing, pitch, roll]).as_matrix()[0]
    first = run.value[heard[run.sensor[heard] == run.sensor[heard[0]]][:5]]
    return float(np.median(first) * ahead[0] + ahead @ layout.null[at : at + 3])
