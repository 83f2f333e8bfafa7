"""Draw the Phoenix: write its meshes from the hull stations, sites and sizes in phoenix.toml.

    python models/shape/phoenix.py models/phoenix_shape.xml

A picture only: no mesh has mass, touches anything or is heard by the sonar. Body axes x forward, y starboard, z down.
"""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

import numpy as np
from hull import Hull
from mesh import INCH_M, Mesh
from parts import deck, fin, letters, sonar_head, stern_drive

COLOURS = ("hull", "nose", "tunnel", "dark", "bronze", "marks", "steel")  # one mesh each: every geom costs step time
HEAD = "<!-- Written by shape/phoenix.py from phoenix.toml: change those, not this. -->\n<mujoco>\n  <asset>\n"
TAIL = "  </asset>\n</mujoco>\n"


def draw(numbers: dict) -> dict[str, Mesh]:
    """All meshes by colour."""
    meshes = {colour: Mesh() for colour in COLOURS}
    hull = Hull(numbers)
    hull.draw(meshes)
    sites = {key: np.array(entry["value"]) / INCH_M for key, entry in numbers["sites"].items()}
    radius = numbers["propeller"]["diameter_m"]["value"] / INCH_M / 2.0
    stern_drive(meshes, sites["propeller_port_m"], radius, hand=1.0)
    stern_drive(meshes, sites["propeller_starboard_m"], radius, hand=-1.0)
    for x in np.array(numbers["hull"]["fin_axis_m"]["value"]) / INCH_M:
        height, width = hull.section(x)
        for out in ((0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)):
            root = np.array([x, out[1] * width / 2.0, out[2] * height / 2.0])
            fin(meshes["dark"], root, np.array(out), numbers["hull"])
    sonar_head(meshes, sites["sonar_st1000_m"])
    sonar_head(meshes, sites["sonar_st725_m"])
    height, width = hull.section(0.0)
    deck(meshes, top=-height / 2.0)
    for side in (-1.0, 1.0):
        letters(meshes["marks"], "PHOENIX", -3.0, side * (width / 2.0 + 0.02), pixel=0.72)
    return meshes


if __name__ == "__main__":
    toml = Path(__file__).resolve().parents[1] / "phoenix.toml"
    meshes = draw(tomllib.loads(toml.read_text(encoding="utf-8")))
    Path(sys.argv[1]).write_text(
        HEAD + "".join(mesh.xml(name) for name, mesh in meshes.items()) + TAIL, encoding="utf-8"
    )
