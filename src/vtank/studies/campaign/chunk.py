"""The work that is handed out: some runs of a campaign, flown together, each with its outcome and its recording."""

from __future__ import annotations

import functools
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from itertools import groupby
from operator import itemgetter
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
class Piece:
    """A chunk that is done: where it starts, its runs, and the versions of what computed them.

    Each run has its row in the table, and its recording: bytes of a CSV file or .npy array, none if it failed.
    """

    start: int
    runs: tuple[tuple[Row, bytes], ...]
    versions: Mapping[str, str]


def fly_chunk(campaign: Campaign, form: str, chunk: range) -> Piece:
    """Fly the runs of these numbers, for "csv" or "hdf5"; one that fails is told in its row and stops nothing."""
    planned: list[tuple[int, Choice, Plan | Exception]] = []
    for first, alike in groupby(((number, campaign.choice(number)) for number in chunk), itemgetter(1)):
        plan = _plan(campaign, first)  # once for all that differ in noise alone
        planned += [(k, own, campaign.renumbered(plan, k, own) if isinstance(plan, Plan) else plan) for k, own in alike]
    outcomes = iter(simulated(campaign.model, [plan for _, _, plan in planned if isinstance(plan, Plan)]))
    runs = []
    for number, choice, plan in planned:
        known, outcome = (plan, next(outcomes)) if isinstance(plan, Plan) else (None, plan)
        message = told(outcome) if isinstance(outcome, Exception) else fault(outcome)
        entries, data = row(known, choice, campaign.run_name(number), message), b""
        if not message and not isinstance(outcome, Exception):
            data = csv_of(outcome.run) if form == "csv" else array_bytes(table_of(outcome.run))
            entries["sha256"] = sha256(data)
        runs.append((entries, data))
    return Piece(chunk.start, tuple(runs), versions())


def _plan(campaign: Campaign, choice: Choice) -> Plan | Exception:
    try:
        return campaign.plan(0, choice)
    except Exception as error:
        return error


versions = functools.cache(current_versions)


def differing(theirs: Mapping[str, str], ours: Mapping[str, str]) -> str:
    """Their versions that are not ours, in words; empty where all are."""
    apart = {name: str(theirs.get(name)) for name, own in ours.items() if theirs.get(name) != own}
    return ", ".join(f"{name} {textwrap.shorten(found, 40)} (here {ours[name]})" for name, found in apart.items())


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
