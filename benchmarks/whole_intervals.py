"""How often the 95 % intervals of `identify` hold the drag and the added mass that a whole vehicle was flown with.

    python benchmarks/whole_intervals.py [--flights 100] [--seed 1] [--json FILE]

Vehicles, manoeuvres and numbers that their files have wrong are drawn as for sealed cases, without a cause, and flown
in the tank. Counted is what the recordings tell: intervals of less than half of what was believed before. Some seconds
of a core for each draw.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterator
from pathlib import Path

os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

Z = 1.96  # half the 95 % interval, in standard deviations
TOLD = 0.5  # of the standard deviation before, below which a recording is taken to tell of a number


def drawn(seed: int, number: int) -> Iterator[dict[str, object]]:
    """What one draw's identification says of each number: its error in standard deviations, and whether it is told."""
    from vtank.diagnose.whole.identified import identify
    from vtank.errors import InputError
    from vtank.experiment.whole_scenario import fly_whole, scenario_of
    from vtank.plant.vehicle import load_vehicle
    from vtank.rigid.layout import AXES
    from vtank.rigid.places import OWN_OF_AXIS
    from vtank.studies.blind.whole.case import CRAFT, other_numbers
    from vtank.studies.blind.whole.scenarios import FAMILIES, draw_scenario

    random = np.random.default_rng((seed, number))
    nominal = load_vehicle(str(random.choice(CRAFT)))
    texts = [draw_scenario(random, nominal, str(random.choice(FAMILIES))) for _ in range(int(random.integers(1, 4)))]
    flown = other_numbers(random, nominal)
    try:
        runs = [fly_whole(scenario_of(text, f"run_{k}"), flown).run for k, text in enumerate(texts, 1)]
        found = identify(runs, nominal)
    except InputError as error:
        print(f"{number} {nominal.name}: {error}", flush=True)
        return
    true = {f"linear_drag@{axis}": x for axis, x in zip(AXES, flown.linear_drag, strict=True)}
    true |= {f"quadratic_drag@{axis}": x for axis, x in zip(AXES, flown.quadratic_drag, strict=True)}
    true |= {f"added_mass@{axis}": x for axis, x in zip(AXES, np.diag(flown.added_mass), strict=True)}
    for name in true.keys() & found.values.keys():
        quantity, _, axis = name.partition("@")
        before = OWN_OF_AXIS[quantity] * abs(found.nominal[name])
        error = (found.values[name] - true[name]) / found.sd[name]
        yield {"draw": number, "vehicle": nominal.name, "quantity": quantity, "axis": axis, "error_sd": float(error),
               "told": found.sd[name] < TOLD * before}  # fmt: skip


def main() -> None:
    """Draw, identify, and print coverage by axis, quantity and vehicle."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--flights", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    rows: list[dict[str, object]] = []
    for number in range(args.flights):
        rows += drawn(args.seed, number)
        if args.json:
            args.json.write_text(json.dumps(rows))
    told = [row for row in rows if row["told"]]
    for key in ("axis", "quantity", "vehicle", None):
        for value in sorted({str(row[key]) for row in told}) if key else ("all",):
            errors = np.array([row["error_sd"] for row in told if not key or row[key] == value], float)
            share, root = np.mean(abs(errors) <= Z), float(np.sqrt(np.mean(errors**2)))
            print(f"{value:16} {errors.size:5} intervals, {100 * share:5.1f} % hold the truth, rms error {root:.2f} sd")


if __name__ == "__main__":
    main()
