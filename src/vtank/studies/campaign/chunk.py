"""The work that is handed out: some runs of a campaign, flown together, each with its outcome and its recording."""

from __future__ import annotations

import functools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np

from ...errors import InputError
from ...experiment import Plan, Result, simulate_surge, simulate_tank
from ...record import content_fault, current_versions, sha256
from .campaign import Campaign
from .decimals import csv_of, table_of
from .table import Row, row

Choice = Mapping[str, Any]  # key -> value of one run


@dataclass(frozen=True)
class Flown:
    """One run: its row in the table, and its recording (None: failed), the bytes of a CSV file or of an .npy array."""

    row: Row
    data: bytes | None = None
    sha256: str = ""


@dataclass(frozen=True)
class Piece:
    """A chunk that is done: its runs from number `start` on, and the versions of what computed them."""

    start: int
    runs: tuple[Flown, ...]
    versions: Mapping[str, str]


@dataclass(frozen=True)
class Work:
    """What to do with a chunk of run numbers; it can be sent to another process or machine."""

    campaign: Campaign
    form: str  # "csv" or "hdf5"

    def __call__(self, chunk: range) -> Piece:
        """Fly the runs of a chunk; one that fails is told in its row and stops nothing."""
        planned = list(self._planned(chunk))
        outcomes = iter(simulated(self.campaign.model, [plan for _, _, plan in planned if isinstance(plan, Plan)]))
        runs = [
            self._flown(number, choice, plan, next(outcomes) if isinstance(plan, Plan) else plan)
            for number, choice, plan in planned
        ]
        return Piece(chunk.start, tuple(runs), versions())

    def _planned(self, chunk: range) -> Iterator[tuple[int, Choice, Plan | Exception]]:
        """Number, values and plan of each run, or why it has none. What differs in noise alone is planned once."""
        before: tuple[Choice, Plan | Exception] | None = None
        for number in chunk:
            choice = self.campaign.choice(number)
            if before is None or before[0] != choice:
                before = choice, self._plan(number, choice)
            plan = before[1]
            yield number, choice, self.campaign.renumbered(plan, number, choice) if isinstance(plan, Plan) else plan

    def _plan(self, number: int, choice: Choice) -> Plan | Exception:
        try:
            return self.campaign.plan(number, choice)
        except Exception as error:
            return error

    def _flown(self, number: int, choice: Choice, plan: Plan | Exception, outcome: Result | Exception) -> Flown:
        known = plan if isinstance(plan, Plan) else None
        message = told(outcome) if isinstance(outcome, Exception) else fault(outcome)
        entries = row(known, choice, self.campaign.run_name(number), message)
        if message or isinstance(outcome, Exception):
            return Flown(entries)
        data = csv_of(outcome.run) if self.form == "csv" else array_bytes(table_of(outcome.run))
        return Flown(entries, data, sha256(data))


versions = functools.cache(current_versions)


def simulated(model: str, plans: Sequence[Plan]) -> list[Result | Exception]:
    """The result of each plan, or what went wrong with it; the others are as if it had not been there."""
    try:
        return list((simulate_tank if model == "tank" else simulate_surge)(plans)) if plans else []
    except Exception as error:
        if len(plans) == 1:
            return [error]
        half = len(plans) // 2
        return simulated(model, plans[:half]) + simulated(model, plans[half:])


def fault(result: Result) -> str:
    """Why a simulated run is of no use; empty for a good one."""
    moving = np.isfinite(result.true["position_m"]) & np.isfinite(result.true["surge_m_s"])
    if not moving.all():
        return f"diverged at {result.run.time_s[np.argmin(moving)]:g} s; its parameters or inputs are out of range"
    try:
        result.check_clearance()
    except InputError as error:
        return str(error)
    broken = content_fault(result.run)
    return broken.message if broken else ""


def told(error: Exception) -> str:
    """What an exception says, on one line."""
    text = " ".join(str(error).split())
    return text if isinstance(error, InputError) else f"{type(error).__name__}: {text}"


def array_bytes(values: np.ndarray) -> bytes:
    """An array as the bytes of an .npy file."""
    file = BytesIO()
    np.save(file, values, allow_pickle=False)
    return file.getvalue()
