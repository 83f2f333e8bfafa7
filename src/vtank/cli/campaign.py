"""`vtank campaign`: fly the many runs of a campaign file and keep them as one data set, with a table of their truth."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from ..studies.campaign import Executor, Tally
    from .progress import progress


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `campaign CAMPAIGN --out DIR`."""
    text = "simulate a campaign: a grid or random draws of scenarios, truths, effects and noise, as one data set"
    more = "an interrupted campaign goes on where it was when the same command is given again"
    parser = subparsers.add_parser("campaign", help=text, description=f"{text}; {more}")
    parser.add_argument("campaign", metavar="CAMPAIGN", help="name of a campaign, or path of a .toml file")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder to write")
    parser.add_argument(
        "--format", choices=("csv", "hdf5"), default="csv", help="a CSV file for each run, or one HDF5 file for all"
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--threads", type=int, metavar="N", help="threads (default: one for each processor)")
    where.add_argument("--processes", type=int, metavar="N", help="processes on this machine")
    where.add_argument("--scheduler", metavar="ADDRESS", help="Dask cluster with this scheduler, tcp://HOST:PORT")
    where.add_argument("--local-cluster", type=int, metavar="N", help="Dask cluster of N processes on this machine")


def run(args: argparse.Namespace) -> int:
    """Fly, and say what became of it."""
    from ..errors import InputError
    from ..studies.campaign import fly_campaign, load_campaign
    from .checks import check_outputs
    from .progress import progress, taken_up_later

    check_outputs(args, "out")
    campaign = load_campaign(args.campaign)
    with executor(args) as where, progress(f"flying {campaign.name}, run", len(campaign)) as advance:
        with taken_up_later(f"{args.out}: "):
            tally = fly_campaign(campaign, args.out, where, args.format, _follow(advance))
    if tally.failed == tally.total:
        raise InputError(f"{args.out}: all {tally.total} runs failed; runs.csv says why")
    print(f"wrote {args.out}: {tally.summary}")
    return 0


def executor(args: argparse.Namespace) -> Executor:
    """What computes, by the arguments; all processors as threads by default."""
    from ..studies.campaign import Cluster, LocalCluster, Processes, Threads
    from .checks import at_least

    at_least(1, threads=args.threads, processes=args.processes, local_cluster=args.local_cluster)
    if args.scheduler is not None:
        return Cluster(args.scheduler)
    if args.local_cluster is not None:
        return LocalCluster(args.local_cluster)
    return Processes(args.processes) if args.processes is not None else Threads(args.threads)


def _follow(advance: progress) -> Callable[[Tally], None]:
    """Advance the counter run by run to where a tally stands."""

    def show(tally: Tally) -> None:
        if not tally.flown:
            advance.done_before(tally.before)
        else:
            advance(tally.note, tally.before + tally.flown - advance.done)

    return show
