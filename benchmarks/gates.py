"""What a change of structure must not change: verdicts, evidences, estimates and data sets, frozen beside this file.

    python benchmarks/gates.py [--cases N] [--recordings FOLDER]   compare with gates.json.xz; exit code 1 if it moved
    python benchmarks/gates.py --freeze [--recordings FOLDER]      write it anew, when a defect was mended on purpose

Forty open blind cases of all kinds (seed 24, drawn and flown anew, so that the generator is held as well), the paper's
experiments and their identification, and, where the folder of recordings is given, the catamaran and the drive.
Verdicts and data sets must be the same, probabilities and the log evidences of all that is not hopeless within 1e-3,
estimates and errors within 1e-6 of their value, or, since an optimum is found to no more than that, 1e-3 of their
standard deviation. Some minutes.
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
HOPELESS = 20.0  # [nats] behind the best: such a fit has a probability of 1e-9 and ends wherever it gives up
HELD = ("verdict", "probabilities", "estimates", "shrink", "parameters")  # parts of a diagnosis that are compared


# --- what is compared ------------------------------------------------------------------------------------------------
def diagnosed(data: Path, nominal: str) -> dict[str, Any]:
    """Everything the diagnosis of a data set says, and the log evidence of every hypothesis."""
    import vtank as vt

    d = vt.diagnose(vt.load(data), nominal=nominal)
    found = json.loads(json.dumps(d.document))
    return {key: found[key] for key in HELD} | {"log_evidence": d.log_evidence}


def identified(data: Path) -> dict[str, Any]:
    """Estimates and deviations of Models I to III."""
    import vtank as vt

    found = {model: vt.identify(vt.load(data), model=model) for model in ("I", "II", "III")}
    return {
        model: {name: {"value": e.values[name], "interval95": e.interval95(name)} for name in e.values}
        for model, e in found.items()
    }


def digests(folder: Path) -> dict[str, str]:
    """SHA-256 of every run of a data set."""
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.glob("*.csv"))}


def vtank(*arguments: str) -> None:
    """One command of vtank."""
    from vtank.cli import main

    assert main(arguments) == 0, arguments


def experiments(folder: Path, truth: str) -> dict[str, Any]:
    """The paper's four experiments with a truth: data set and identification."""
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
        keys = hopeful(before) if path.endswith("log_evidence") else {*before, *now}
        for key in sorted(keys):
            if key not in before or key not in now:
                yield f"{path}/{key}", math.inf
            else:
                yield from differences(before[key], now[key], f"{path}/{key}", deviation(before, spread))
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        for i, (a, b) in enumerate(zip(before, now, strict=True)):
            yield from differences(a, b, f"{path}/{i}", spread)
    elif isinstance(before, float | int) and isinstance(now, float | int) and not isinstance(before, bool):
        allowed = NATS if "log_evidence" in path or "probabilit" in path else RELATIVE * abs(before)
        if before != now:
            yield path, abs(before - now) / max(allowed, OF_A_DEVIATION * spread, 1e-12)
    elif before != now:
        yield path, math.inf


def hopeful(evidence: dict[str, float]) -> set[str]:
    """Hypotheses that are not hopeless."""
    return {name for name, value in evidence.items() if value > max(evidence.values()) - HOPELESS}


def deviation(entry: dict[str, Any], outer: float) -> float:
    """Standard deviation of an estimate whose 95 % interval is told, else that of the entry around it."""
    interval = entry.get("interval95")
    return (interval[1] - interval[0]) / 3.92 if interval else outer


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
