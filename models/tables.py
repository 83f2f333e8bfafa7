"""Write the tables of README.md from the vehicle files, the truth presets and the walls of basin.xml.

python models/tables.py models/README.md
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import mujoco

HERE = Path(__file__).resolve().parent
FOOT_M = 0.3048
UNITS = {  # end of a key -> unit; the longest that fits counts
    "N_m_s2_per_rad2": "N m/(rad/s)²",
    "N_m_s_per_rad": "N m/(rad/s)",
    "N_s2_per_m2": "N/(m/s)²",
    "N_s_per_m": "N/(m/s)",
    "kg_per_m3": "kg/m³",
    "kg_m2": "kg m²",
    "kg_m": "kg m",
    "kg": "kg",
    "ft_per_rev2": "ft/rev²",
    "N_s2_per_rev2": "N/(rev/s)²",
    "N_per_m": "N/m",
    "per_rad": "1/rad",
    "per_rev": "1/rev",
    "per_ft": "1/ft",
    "rev_s": "rev/s",
    "rad": "rad",
    "m2": "m²",
    "hz": "Hz",
    "m": "m",
    "in": "in",
    "N": "N",
    "s": "s",
}
HEAD = "| number | value | imperial | source | confidence | remark |\n|---|---|---|---|---|---|\n"


def split_unit(key: str) -> tuple[str, str]:
    """Name and unit of a key: `surge_N_s2_per_m2` is surge in N/(m/s)²."""
    for ending, unit in UNITS.items():
        if key.endswith("_" + ending):
            return key.removesuffix("_" + ending).replace("_", " "), unit
    return key.replace("_", " "), ""


def written(value: object) -> str:
    """A number or a list of numbers, to six digits."""
    if isinstance(value, list):
        return ", ".join(written(item) for item in value)
    return f"{value:.6g}" if isinstance(value, int | float) else str(value)


def row(key: str, entry: dict, about: str = "") -> str:
    """One line of a table."""
    name, unit = split_unit(key)
    cells = [f"{about}{name}", f"{written(entry['value'])} {unit}".strip(), entry.get("imperial", "")]
    return "| " + " | ".join([*cells, entry["source"], entry["confidence"], entry.get("note", "")]) + " |\n"


def vehicle_tables(name: str = "phoenix") -> str:
    """One table for each part of a vehicle file."""
    numbers = tomllib.loads((HERE / f"{name}.toml").read_text(encoding="utf-8"))
    text = ""
    for part, entries in numbers.items():
        if rows := "".join(rows_of(entries)):
            text += f"\n### {part.replace('_', ' ')}\n\n{HEAD}{rows}"
    return text


def rows_of(entries: object, about: str = "") -> Iterator[str]:
    """A row for every number with an origin, within tables and lists of tables, which go by their name or site."""
    if isinstance(entries, list):
        for entry in filter(lambda entry: isinstance(entry, dict), entries):
            yield from rows_of(entry, f"{entry.get('name', entry.get('site'))}: ")
    elif isinstance(entries, dict):
        for key, entry in entries.items():
            if isinstance(entry, dict) and "value" in entry:
                yield row(key, entry, about)
            elif isinstance(entry, dict):
                yield from rows_of(entry, f"{key}: ")


def truth_tables() -> str:
    """One table for each preset."""
    text = ""
    for path in sorted((HERE / "truths").glob("*.toml")):
        truth = tomllib.loads(path.read_text(encoding="utf-8"))
        entries = truth.get("lumped", {}) | truth.get("derived", {}) | {"n_limit_rev_s": truth["n_limit_rev_s"]}
        rows = [row(key, entry) for key, entry in entries.items() if isinstance(entry, dict)]
        text += f"\n### {truth['name']}: {truth['source']}\n\n{HEAD}{''.join(rows)}"
    return text


def tank_table() -> str:
    """The tank as compiled from basin.xml, and the Phoenix in it."""
    model, basin = (mujoco.MjModel.from_xml_path(str(HERE / name)) for name in ("phoenix.xml", "basin.xml"))
    at = {name: basin.geom(name).pos for name in ("wall_ahead", "wall_astern", "wall_port", "wall_starboard", "floor")}
    start, sonar = model.qpos0, model.site("sonar_st1000").pos
    tail = model.site("propeller_port").pos[0] + start[0] - at["wall_astern"][0]
    brim = at["wall_ahead"][2] + basin.geom("wall_ahead").size[1]
    recalled = ("-", "U", "about 20 x 20 ft and 6 to 8 ft deep is recollection only")
    lengths = {
        "length": (at["wall_ahead"][0] - at["wall_astern"][0], *recalled),
        "width": (at["wall_port"][1] - at["wall_starboard"][1], *recalled),
        "depth of water": (-at["floor"][2], *recalled),
        "wall above the water": (brim, "-", "guess", ""),
        "sonar to wall ahead": (at["wall_ahead"][0] - start[0] - sonar[0], "S0", "H", '"about 10 feet away"'),
        "depth of the vehicle's origin": (-start[2], "S0", "H", '"~3 ft"'),
        "free behind the propellers": (tail, "-", "guess", "follows from the lines above"),
    }
    rows = [
        f"| {name} | {metres:.4g} m | {metres / FOOT_M:.3g} ft | {source} | {confidence} | {note} |\n"
        for name, (metres, source, confidence, note) in lengths.items()
    ]
    return "\n" + HEAD + "".join(rows)


def refreshed(readme: str) -> str:
    """The README with its tables, between the markers, written anew."""
    tables = {"vehicle": vehicle_tables, "truths": truth_tables, "tank": tank_table}
    tables |= {name: lambda name=name: vehicle_tables(name) for name in ("bluerov2", "remus100", "kingfisher")}
    for name, table in tables.items():
        begin, end = f"<!-- {name}: written by tables.py -->", f"<!-- end of {name} -->"
        readme = re.sub(f"{begin}.*?{end}", lambda _: f"{begin}\n{table()}\n{end}", readme, flags=re.DOTALL)  # noqa: B023
    return readme


if __name__ == "__main__":
    target = Path(sys.argv[1])
    target.write_text(refreshed(target.read_text(encoding="utf-8")), encoding="utf-8")
