"""Where chunks are computed: threads, processes, or a Dask cluster. The results are the same everywhere.

An executor takes work (a function of one chunk) and chunks, and yields the results in the order in which they come,
with only a few chunks under way at a time. A worker that dies takes its chunk with it; the chunk is done again.
"""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, CancelledError, Future, ThreadPoolExecutor, wait
from concurrent.futures import Executor as Pool
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from time import monotonic, sleep
from typing import Any, Self, TypeVar

from ...errors import InputError
from ..processes import HINT, pool

T = TypeVar("T")
R = TypeVar("R")
CRASHES = 3  # in a row, without one chunk done, before giving up; as Dask's allowed-failures
PATIENCE_S = 10.0  # [s] for a scheduler to answer; a choice
RESTART_S = 60.0  # [s] for one that went to come back, with a worker; a choice
SILENCE_S = 1.0  # [s] without a result, after which the scheduler is asked whether it still is the same one; a choice


class Executor(ABC):
    """What computes chunks: `workers` of them at a time. A context manager that ends what it started."""

    workers: int

    @abstractmethod
    def results(self, work: Callable[[T], R], chunks: Sequence[T]) -> Generator[R, None, None]:
        """The results of all chunks, in any order."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:  # noqa: B027  (nothing to end unless a subclass says so)
        """End what was started."""


def flow(
    workers: Pool, work: Callable[[T], R], left: deque[T], window: int, silent: Callable[[], None] = lambda: None
) -> Generator[R, None, None]:
    """Results as they come; at most `window` chunks under way. After an exception `left` has those not yielded.

    `silent` is called after every SILENCE_S without a result: its exception ends the waiting.
    """
    flying: dict[Future[R], T] = {}
    try:
        while left or flying:
            while left and len(flying) < window:
                flying[workers.submit(work, left[0])] = left[0]
                left.popleft()
            done = wait(flying, SILENCE_S, FIRST_COMPLETED).done
            if not done:
                silent()
            for future in done:
                result = future.result()
                del flying[future]
                yield result
    finally:
        left.extend(flying.values())
        for future in flying:
            future.cancel()


class Threads(Executor):
    """Threads of this process: MuJoCo and compiled code run without Python's lock."""

    def __init__(self, workers: int | None = None) -> None:
        """`workers`: threads, by default one for each processor."""
        self.workers = workers or processors()

    def results(self, work: Callable[[T], R], chunks: Sequence[T]) -> Generator[R, None, None]:
        """See `Executor`."""
        with ThreadPoolExecutor(self.workers) as threads:
            yield from flow(threads, work, deque(chunks), 2 * self.workers)


class Processes(Executor):
    """Processes on this machine."""

    def __init__(self, workers: int) -> None:
        """`workers`: processes."""
        self.workers = workers

    def results(self, work: Callable[[T], R], chunks: Sequence[T]) -> Generator[R, None, None]:
        """See `Executor`. InputError when the processes keep dying."""
        left, crashes = deque(chunks), 0
        while left:
            try:
                with pool(self.workers) as workers:
                    for result in flow(workers, work, left, 2 * self.workers):
                        crashes = 0
                        yield result
            except BrokenProcessPool:
                crashes += 1
                if crashes == CRASHES:
                    raise InputError(f"worker processes die again and again: {HINT}") from None


class Cluster(Executor):
    """A Dask cluster, by the address of its scheduler (tcp://host:8786). Scheduler and workers need the same vtank."""

    def __init__(self, address: str) -> None:
        """Connect; InputError where nothing answers there."""
        self.address = address
        try:
            self.client = _distributed().Client(address, timeout=PATIENCE_S)
        except (OSError, ValueError) as error:
            raise InputError(f"{address}: no Dask scheduler answers there ({error})") from None
        self.workers = max(1, sum(self.client.nthreads().values()))

    def results(self, work: Callable[[T], R], chunks: Sequence[T]) -> Generator[R, None, None]:
        """See `Executor`. Dask itself gives the chunks of a dead worker to another.

        A scheduler that is started again at its address is given what is left; a worker whose system refuses something,
        such as a full disk, gets no more. InputError where neither scheduler nor workers remain.
        """
        left, unable = deque(chunks), dict[str, str]()
        while left:
            try:
                workers, attempt = self._able(unable), partial(_attempted, work)
                with closing(flow(workers, attempt, left, 2 * self.workers, self._same_scheduler())) as attempts:
                    for result in attempts:
                        if isinstance(result, Unable):
                            unable[result.worker] = result.reason
                            left.append(result.chunk)
                            break
                        yield result
            except CancelledError:
                self._find_again()
            except InputError:
                raise
            except Exception as error:
                what = " ".join(f"{type(error).__name__}: {error}".split())
                raise InputError(f"{self.address}: do the scheduler and all workers have this vtank? {what}") from error

    def _able(self, unable: Mapping[str, str]) -> Pool:
        """The cluster without some of its workers; InputError where these are all."""
        if not unable:
            return self.client.get_executor(pure=False)
        able = [worker for worker in self.client.nthreads() if worker not in unable]
        if not able:
            said = "; ".join(f"{worker}: {reason}" for worker, reason in unable.items())
            raise InputError(f"{self.address}: no worker is left that can work: {said}")
        return self.client.get_executor(pure=False, workers=able)

    def _same_scheduler(self) -> Callable[[], None]:
        """What raises CancelledError once the scheduler is another one than now, or gone.

        A client that connects again by itself cancels what it waits for, but not a result that was just being fetched:
        that one would be waited for without end.
        """
        client, identity = self.client, self.client.scheduler_info().get("id")

        def ask() -> None:
            if client.status == "closed" or client.scheduler_info().get("id") != identity:
                raise CancelledError

        return ask

    def _find_again(self) -> None:
        """Connect anew to the scheduler, which was started again; InputError where it is not."""
        self.client.close()
        end = monotonic() + RESTART_S
        while (left_s := end - monotonic()) > 0.0:
            try:
                self.client = _distributed().Client(self.address, timeout=min(left_s, PATIENCE_S))
                self.client.wait_for_workers(1, timeout=max(end - monotonic(), 1.0))
                return
            except (OSError, ValueError):  # nobody yet, or nobody but the scheduler
                sleep(0.2)
        raise InputError(f"{self.address}: the scheduler is gone; the same command goes on from here") from None

    def __exit__(self, *error: object) -> None:
        """Leave the cluster, which goes on."""
        self.client.close()


@dataclass(frozen=True)
class Unable:
    """A chunk that the system of a worker refused, and why."""

    chunk: Any
    worker: str
    reason: str


def _attempted(work: Callable[[T], R], chunk: T) -> R | Unable:
    """The result of a chunk, on a worker."""
    try:
        return work(chunk)
    except OSError as error:
        return Unable(chunk, _distributed().get_worker().address, str(error))


class LocalCluster(Cluster):
    """A Dask cluster of worker processes on this machine."""

    def __init__(self, workers: int) -> None:
        """`workers`: processes of one thread each; InputError where one of them dies before it can work."""
        start = _distributed().LocalCluster
        try:
            self.cluster = start(workers, threads_per_worker=1, processes=True, dashboard_address=None)
        except RuntimeError as error:
            raise InputError(f"a worker of the local Dask cluster did not start ({error}): {HINT}") from error
        super().__init__(self.cluster.scheduler_address)

    def __exit__(self, *error: object) -> None:
        """End the cluster."""
        super().__exit__(*error)
        self.cluster.close()


def processors() -> int:
    """Processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise InputError("Dask is not installed: pip install 'vtank[cluster]'") from None
    return distributed
