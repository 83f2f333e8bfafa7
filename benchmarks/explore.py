"""The scientist's loop against a fixed plan: minutes of flights to a decision in sealed tanks, and how often right.

    python benchmarks/explore.py TRUTH [TRUTH ...] [--minutes 10] [--json FILE] [--modes planned fixed]

TRUTH: truths of cases of `vtank blind make --vehicles`, of which only the flights know the cause. The fixed plan flies
the same candidates in their order, all axes at once first, and stops by the same rule. A tank whose minutes are spent
before it is decided counts with all of them. Some minutes of a core for each tank.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from pathlib import Path
from typing import Any

os.environ["OPENBLAS_NUM_THREADS"] = "1"


def flown(path: Path, minutes: float, mode: str, planners: dict[str, Any]) -> dict[str, Any]:
    """One tank explored; planners: of vehicles, which are kept."""
    from vtank.studies.blind.whole import scored_name
    from vtank.studies.explore import Planner, SealedTank, candidates, document, explore

    began = time.process_time()
    with SealedTank(path) as tank:
        vehicle = tank.vehicle
        if vehicle.name not in planners:
            planners[vehicle.name] = Planner(vehicle, candidates(vehicle, None if vehicle.heave_N_per_m else 50.0))
        found = explore(planners[vehicle.name], tank.fly, minutes, fixed=mode == "fixed")
        truth = tank.reveal()
    right = scored_name(found.answer) == (truth if truth != "parameters" else "none")
    said = {"tank": path.stem, "vehicle": vehicle.name, "mode": mode, "truth": truth, "right": right}
    return said | document(found) | {"cpu_s": time.process_time() - began}


def main() -> None:
    """Print one line for each tank and mode, then the shares."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("truths", nargs="+", type=Path)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--modes", nargs="+", default=["planned", "fixed"])
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    planners: dict[str, Any] = {}
    rows = []
    for path in args.truths:
        for mode in args.modes:
            row = flown(path, args.minutes, mode, planners)
            rows.append(row)
            print(
                f"{row['tank']} {row['vehicle']:10} {mode:8} {row['truth']:32} {row['answer']:32} {row['ended']:8} "
                f"{row['minutes']:5.1f} min {len(row['runs'])} runs {row['right']!s:5} {row['cpu_s']:.0f} s",
                flush=True,
            )
            if args.json:
                args.json.write_text(json.dumps(rows, indent=1))
    for mode in args.modes:
        some = [row for row in rows if row["mode"] == mode]
        sure = [row for row in some if row["ended"] == "decided"]
        right = sum(row["right"] for row in sure)
        minutes = sorted(row["minutes"] for row in some)
        print(
            f"{mode}: decided {len(sure)} of {len(some)}, right {right}, wrong {len(sure) - right}; "
            f"median {minutes[len(minutes) // 2]:.1f} min, mean {sum(minutes) / len(minutes):.1f} min"
        )


if __name__ == "__main__":
    main()
