"""A campaign from first run to last: hand out the chunks that are left, keep what comes back, make the files."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from time import monotonic

from ...errors import InputError
from .campaign import Campaign
from .chunk import differing, fly_chunk, versions
from .executors import Executor
from .folder import write_folder
from .hdf5 import check_hdf5, write_hdf5
from .journal import Journal
from .table import FAILED

MOST = {"tank": 64, "surge": 256}  # runs per chunk; more together fly no faster
SAMPLES = 400_000  # in a chunk at most, for memory: about 100 MB while it is computed
SHARE = 4  # chunks per worker at least, so that none waits long for the last


@dataclass
class Tally:
    """How far a campaign is: runs in all, done before this go, done in it, failed among those."""

    total: int
    before: int
    flown: int = 0
    failed: int = 0
    start: float = field(default_factory=monotonic)

    @property
    def rate(self) -> float:
        """Runs per second in this go."""
        return self.flown / max(monotonic() - self.start, 1e-9)

    @property
    def note(self) -> str:
        """Rate and failures, in a few words."""
        rate = f"{self.rate:.3g} runs/s" if self.flown else "done before"
        return rate + (f", {self.failed} failed" if self.failed else "")

    @property
    def summary(self) -> str:
        """How it ended."""
        failed = f", {self.failed} of them failed (runs.csv says why)" if self.failed else ""
        if not self.flown:
            return f"{self.total} runs{failed}, all done before"
        before = f", {self.before} of them done before" if self.before else ""
        return f"{self.total} runs{failed}{before}; {self.rate:.3g} runs/s"


def fly_campaign(
    campaign: Campaign,
    out: Path,
    executor: Executor,
    form: str = "csv",
    progress: Callable[[Tally], None] = lambda tally: None,
    chunk: int | None = None,
) -> Tally:
    """Fly what is left of a campaign into a folder: data/*.csv with a manifest, or runs.h5; and runs.csv.

    Args:
        campaign: what to fly.
        out: a new folder, or one where this campaign was interrupted, or finished.
        executor: what computes; the results do not depend on it.
        form: "csv" or "hdf5".
        progress: called before the first and after every chunk.
        chunk: runs per chunk, by default as many as suit model and executor; the results do not depend on it.

    Returns:
        The tally; `failed` counts all failed runs of the campaign.

    Raises:
        InputError: the folder holds something else, or a worker computes with other versions.
    """
    if form == "hdf5":
        check_hdf5(campaign)
    size = chunk or chunk_size(campaign, executor.workers)
    with Journal(out, campaign, form, size) as journal:
        if journal.complete:
            return Tally(len(campaign), len(campaign), 0, journal.failed)
        left = journal.left()
        tally = Tally(len(campaign), len(campaign) - sum(map(len, left)))
        progress(tally)
        with closing(executor.results(partial(fly_chunk, campaign, form), left)) as pieces:
            for piece in pieces:
                if found := differing(piece.versions, versions()):
                    raise InputError(f"a worker computes with {found}: results would depend on who computes them")
                journal.add(piece)
                tally.flown += len(piece.runs)
                tally.failed += sum(row["status"] == FAILED for row, _ in piece.runs)
                progress(tally)
        tally.failed = (write_folder if form == "csv" else write_hdf5)(journal, campaign)
        journal.finish(len(campaign), tally.failed)
    return tally


def chunk_size(campaign: Campaign, workers: int) -> int:
    """Runs per chunk: enough to fly well together, few enough for memory and for every worker to have some."""
    fair = math.ceil(len(campaign) / (SHARE * workers))
    return max(1, min(MOST[campaign.model], SAMPLES // campaign.samples, fair))
