"""A tank whose cause is sealed: the truth of a case of `vtank blind make --vehicles`, which only the flight opens.

Whoever plans and diagnoses sees the name of the vehicle file and the recordings.
"""

from __future__ import annotations

from concurrent.futures.process import BrokenProcessPool
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from ...errors import InputError
from ...experiment.whole_scenario import fly_whole, scenario_of
from ...plant import Vehicle, load_vehicle
from ...record import Run, parse_json, read_text
from ..blind.whole import caused, true_name
from ..processes import pool


class SealedTank:
    """The tank of one sealed case; its flights are made in a process of their own.

    with SealedTank("trials-truth/case_0001.json") as tank:
        run = tank.fly(scenario_text, seed=1)
    """

    def __init__(self, path: Path | str) -> None:
        """InputError where the file is not the truth of a case of a whole vehicle."""
        self.path, self._pool = Path(path), pool(1)
        try:
            self.vehicle: Vehicle = load_vehicle(self._ask(_vehicle, self.path))
        except InputError:
            self._pool.shutdown(wait=False, cancel_futures=True)
            raise

    def fly(self, text: str, seed: int) -> Run:
        """What is recorded of a scenario; InputError where the vehicle cannot fly it, or strikes a wall."""
        run: Run = self._ask(_fly, self.path, text, seed)
        return run

    def reveal(self) -> str:
        """The true cause, under the name by which it is scored; to be asked last."""
        return str(self._ask(_cause, self.path))

    def _ask(self, work: Any, *arguments: Any) -> Any:
        try:
            return self._pool.submit(work, *arguments).result()
        except BrokenProcessPool:
            raise InputError(f"{self.path}: the process that flies the tank died; too little memory?") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._pool.shutdown(wait=False, cancel_futures=True)


# --- in the process that flies ---------------------------------------------------------------------------------------
def _truth(path: Path) -> dict[str, Any]:
    content = parse_json(read_text(path), path)
    truth = content.get("truth") if isinstance(content, dict) else None
    if not isinstance(truth, dict) or not {"vehicle", "effects", "own", "kind"} <= truth.keys():
        raise InputError(f"{path}: not the truth of a sealed vehicle; expected one of vtank blind make --vehicles")
    return truth


def _vehicle(path: Path) -> str:
    return str(_truth(path)["vehicle"])


def _cause(path: Path) -> str:
    return true_name(_truth(path))


def _fly(path: Path, text: str, seed: int) -> Run:
    vehicle, effects = caused(_truth(path))
    scenario = scenario_of(text, f"run_{seed}", seed)
    flown = fly_whole(replace(scenario, effects=effects), vehicle)
    if flown.ended:
        raise InputError(f"{scenario.name}: {flown.ended}")
    return flown.run
