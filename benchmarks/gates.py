"""What a change of structure must not change: verdicts, evidences, estimates and data sets, frozen beside this file.

    python benchmarks/gates.py [--cases N] [--recordings FOLDER]   compare with gates.json.xz; exit code 1 if it moved
    python benchmarks/gates.py --freeze [--recordings FOLDER]      write it anew, when a defect was mended on purpose

Forty open blind cases of all kinds (seed 24, drawn and flown anew, so that the generator is held as well), the demo's
data sets and their identification, and, where the folder of recordings is given, the catamaran and the drive. Verdicts
and data sets must be the same, log evidences and probabilities within 1e-3, estimates within 1e-6 of their value or
1e-3 of their standard deviation. Some minutes.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import lzma
import math
import os
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # two threads of it change the twelfth digit

FROZEN = Path(__file__).with_suffix(".json.xz")
CASES, SEED = 40, 24
TRUTHS, EXPERIMENTS = ("paper-ii", "paper-iii", "physical"), ("paper-ds1", "paper-ds2", "paper-ds3", "paper-ds4")
RECORDINGS = ("kingfisher_2017", "emps_estimation")
NATS, RELATIVE, OF_A_DEVIATION = 1e-3, 1e-6, 1e-3


# --- what is compared ------------------------------------------------------------------------------------------------
def diagnosed(data: Path, nominal: str) -> dict[str, Any]:
    """Everything the diagnosis of a data set says, and the log evidence of every hypothesis."""
    import vtank as vt

    d = vt.diagnose(vt.load(data), nominal=nominal)
    return {**json.loads(json.dumps(d.document)), "log_evidence": d.log_evidence}


def identified(data: Path) -> dict[str, Any]:
    """Estimates and deviations of Models I to III."""
    import vtank as vt

    found = {model: vt.identify(vt.load(data), model=model) for model in ("I", "II", "III")}
    return {model: {"values": e.values, "sd": e.sd} for model, e in found.items()}


def digests(folder: Path) -> dict[str, str]:
    """SHA-256 of every run of a data set."""
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.glob("*.csv"))}


def vtank(*arguments: str) -> None:
    """One command of vtank."""
    from vtank.cli import main

    assert main(arguments) == 0, arguments


def experiments(folder: Path, truth: str) -> dict[str, Any]:
    """The demo's four experiments with a truth: data set and identification."""
    data = folder / truth
    vtank("run", *EXPERIMENTS, "--truth", truth, "--seed", "1996", "--threads", "2", "--out", str(data))
    return {"digests": digests(data), "identified": identified(data)}


def blind_case(folder: Path, k: int) -> tuple[str, dict[str, Any]]:
    """One blind case: its data set and its diagnosis."""
    name = f"case_{k + 1:04d}"
    return name, {"digests": digests(folder / name), "diagnosed": diagnosed(folder / name, "paper-ii")}


def everything(cases: int, recordings: Path | None) -> Iterator[tuple[str, dict[str, Any]]]:
    """Name and findings, one after the other."""
    with tempfile.TemporaryDirectory() as temporary, ProcessPoolExecutor(2, get_context("spawn")) as pool:
        folder = Path(temporary)
        for truth in TRUTHS:
            yield f"demo/{truth}", experiments(folder, truth)
        blind = folder / "blind"
        vtank("blind", "make", "--trials", str(CASES), "--seed", str(SEED), "--no-separations", "--out", str(blind))
        yield from pool.map(partial(blind_case, blind), range(cases))
        if recordings is not None:
            for name in RECORDINGS:
                yield name, {"diagnosed": diagnosed(recordings / name, "none")}


# --- comparison ------------------------------------------------------------------------------------------------------
def differences(before: Any, now: Any, path: str = "", spread: float = 0.0) -> Iterator[tuple[str, float]]:
    """Where two findings part, and by how many of the tolerances; infinite where they are not of one kind."""
    if isinstance(before, dict) and isinstance(now, dict):
        for key in sorted({*before, *now}):
            if key not in before or key not in now:
                yield f"{path}/{key}", math.inf
            else:
                yield from differences(before[key], now[key], f"{path}/{key}", deviation(before, key))
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        for i, (a, b) in enumerate(zip(before, now, strict=True)):
            yield from differences(a, b, f"{path}/{i}", spread)
    elif isinstance(before, float | int) and isinstance(now, float | int) and not isinstance(before, bool):
        allowed = NATS if "log_evidence" in path or "probabil" in path else RELATIVE * abs(before)
        difference = abs(before - now)
        if difference > 0.0:
            yield path, difference / max(allowed, OF_A_DEVIATION * spread, 1e-12)
    elif before != now:
        yield path, math.inf


def deviation(entry: dict[str, Any], key: str) -> float:
    """Standard deviation of an estimate where its 95 % interval is told, else 0."""
    interval = entry.get("interval95")
    return (interval[1] - interval[0]) / 3.92 if interval and key in ("value", "interval95") else 0.0


def main() -> int:
    """Compare or freeze."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--freeze", action="store_true", help="write what is found now as what must stay")
    parser.add_argument("--cases", type=int, default=CASES, metavar="N", help=f"of the {CASES} blind cases")
    parser.add_argument("--recordings", type=Path, metavar="FOLDER", help="with kingfisher_2017 and emps_estimation")
    args = parser.parse_args()
    if args.freeze:
        found = dict(everything(args.cases, args.recordings))
        FROZEN.write_bytes(lzma.compress(json.dumps(found, indent=1, sort_keys=True).encode()))
        return 0
    frozen, moved = json.loads(lzma.decompress(FROZEN.read_bytes())), 0
    for name, now in everything(args.cases, args.recordings):
        parted = sorted(differences(frozen[name], json.loads(json.dumps(now))), key=lambda d: -d[1])
        beyond = [(path, size) for path, size in parted if size > 1.0]
        moved += bool(beyond)
        worst = f"{parted[0][0]} at {parted[0][1]:.2g} of its tolerance" if parted else "the same to the last digit"
        print(f"{'MOVED' if beyond else 'held '} {name}: {worst}")
        for path, size in beyond[1:12]:
            print(f"        {path}: {size:.3g}")
    print(f"{moved} of {args.cases + len(TRUTHS) + (len(RECORDINGS) if args.recordings else 0)} moved")
    return int(moved > 0)


if __name__ == "__main__":
    sys.exit(main())
