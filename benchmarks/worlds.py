"""How the diagnosis does in worlds made by others: cases of an outside simulator, with their truth, per family.

    python benchmarks/worlds.py FOLDER [--only FAMILY ...] [--json FILE] [--workers N]

FOLDER holds truth.json and cases.tar.xz, as shared/data/worlds does; its README says what they mean. A case counts as
right where the verdict's kind is the true one and, for named effects, the true ones are those named or cannot be told
from them. Some minutes on two cores.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tarfile
import tempfile
import time
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

os.environ["OPENBLAS_NUM_THREADS"] = "1"

FOOT_M = 0.3048  # a truth file gives drag and thrust per foot, as the paper does
SURE = 0.95  # probability from which a wrong answer counts as confident


def nominal_text(name: str, vehicle: dict[str, float]) -> str:
    """Truth file of a vehicle of truth.json."""
    values = {
        "a_per_ft": vehicle["alpha_per_m"] * FOOT_M,
        "b_ft_per_rev2": vehicle["beta_m_per_rev2"] / FOOT_M,
        "gamma_per_rev": 0.0,
        "tau_s": vehicle["tau_s"],
    }
    lines = [f'name = "{name}"', 'source = "truth.json"', f"n_limit_rev_s = {vehicle['n_max_rev_s']!r}", "[lumped]"]
    return "\n".join(lines + [f"{key} = {value!r}" for key, value in values.items()])


def diagnosed(folder: Path, item: tuple[str, dict[str, Any]]) -> dict[str, Any]:
    """Verdict on one case, and whether it is right."""
    import vtank as vt

    name, case = item
    nominal = folder / f"{case['vehicle']}.toml"
    began = time.perf_counter()
    d = vt.diagnose(vt.load(folder / "cases" / name), nominal=nominal)
    noise = d.selection.setting.noise
    said = d.verdict.document() | {"world": name, "family": case["family"], "truth": case["kind"], "d": case.get("d")}
    said |= {"seconds": time.perf_counter() - began, "sigma": noise.sigma, "causes": case["causes"]}
    said["probabilities"] = d.probabilities
    return said | {"right": right(said, case), "channel_right": channel_right(said, case)}


def right(said: dict[str, Any], case: dict[str, Any]) -> bool:
    """Whether the verdict is the true kind, with the true effects among those it names or cannot tell from them."""
    true = {cause["name"] for cause in case["causes"]}
    if case["kind"] == "effect":
        return said["kind"] == "effect" and true <= {*said["effects"], *said["class"]}
    if case["kind"] == "effects":
        return said["kind"] == "effects" and true == set(said["effects"])
    return bool(said["kind"] == case["kind"])


def channel_right(said: dict[str, Any], case: dict[str, Any]) -> bool | None:
    """Whether an unknown cause is seen in the right channel; None where there is none."""
    if case["kind"] != "unknown" or said["kind"] != "unknown":
        return None
    true = [
        c
        for cause in case["causes"]
        for c in ([cause["channel"]] if isinstance(cause["channel"], str) else cause["channel"])
    ]
    return said["channel"] in true


def table(rows: list[dict[str, Any]]) -> str:
    """Right, undecided and confidently wrong per family, and every case that is not right."""
    families = defaultdict(list)
    for row in rows:
        families[row["family"]].append(row)
    out = ["family        cases  right  channel  undecided  wrong at 0.95  wrong at 0.8"]
    for family, own in [*families.items(), ("all", rows)]:
        wrong = [r for r in own if not r["right"] and r["kind"] != "undecided"]
        channel = [r["channel_right"] for r in own if r["channel_right"] is not None]
        out.append(
            f"{family:12}  {len(own):5}  {sum(r['right'] for r in own):5}  {f'{sum(channel)}/{len(channel)}':>7}  "
            f"{sum(r['kind'] == 'undecided' for r in own):9}  {sum(r['probability'] >= SURE for r in wrong):13}  "
            f"{sum(r['probability'] >= 0.8 for r in wrong):12}"
        )
    return "\n".join(out)


def line(row: dict[str, Any]) -> str:
    """One case, marked where it is not right."""
    names, true = "+".join(row["effects"]) or "-", "+".join(c["name"] for c in row["causes"]) or "-"
    return (
        f"{'  ' if row['right'] else 'x '}{row['world']} {row['family']:12} {true:45} d {row['d']:6.1f}  "
        f"{row['kind']:10} {names:35} {row['channel'] or '-':13} {row['probability']:.2f}  "
        f"disturbance {1e3 * row['sigma']:.2f} mm/s2  {row['seconds']:.1f} s"
    )


def main() -> int:
    """Score all cases."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="+", help="families or cases")
    parser.add_argument("--json", type=Path, help="file for the answers")
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    truth = json.loads((asked.folder / "truth.json").read_text(encoding="utf-8"))
    items = list(truth["cases"].items())
    if asked.only:
        items = [(n, c) for n, c in items if n in asked.only or c["family"] in asked.only]
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        with tarfile.open(asked.folder / "cases.tar.xz") as archive:
            archive.extractall(folder, filter="data")
        for vehicle, values in truth["vehicles"].items():
            (folder / f"{vehicle}.toml").write_text(nominal_text(vehicle, values), encoding="utf-8")
        with ProcessPoolExecutor(asked.workers, mp_context=get_context("spawn")) as pool:
            rows = []
            for row in pool.map(partial(diagnosed, folder), items):
                rows.append(row)
                print(line(row), flush=True)
    rows.sort(key=lambda r: (r["family"], r["world"]))
    print("\n" + table(rows))
    if asked.json:
        asked.json.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
