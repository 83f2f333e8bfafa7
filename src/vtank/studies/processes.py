"""Work on many cases side by side, in the order in which they were given."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing.process import BaseProcess
from typing import Any

from ..errors import InputError

HINT = "too little memory for so many, or a script that starts them without `if __name__ == '__main__':`"


@contextmanager
def processes(count: int) -> Iterator[Callable[..., Iterator[Any]]]:
    """Yield a `map` over that many processes; over none but this one where one is enough. InputError where one dies."""
    if count <= 1:
        yield map
        return
    others = multiprocessing.active_children()
    with pool(count, signal.SIG_DFL) as workers:
        try:
            yield workers.map
        except BrokenProcessPool:
            raise InputError(f"a worker process died: {HINT}") from None
        except BaseException:
            workers.shutdown(wait=False, cancel_futures=True)
            for child in multiprocessing.active_children():  # in the midst of a case, which may take minutes
                if child not in others:
                    child.terminate()
            raise


def pool(count: int, interrupted: signal.Handlers = signal.SIG_IGN) -> ProcessPoolExecutor:
    """Processes started afresh (spawned), as threads and forking do not go together; they end with this one.

    interrupted: what Ctrl-C does to them: nothing, which leaves it to this one, or their end, in the midst of a case.
    """
    return ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), _begin, (interrupted,))


def _begin(interrupted: signal.Handlers) -> None:
    """In a new process: end with the parent, even when that is killed."""
    signal.signal(signal.SIGINT, interrupted)
    parent = multiprocessing.parent_process()
    assert parent is not None  # this is a child
    threading.Thread(target=_end_with, args=(parent,), daemon=True).start()


def _end_with(parent: BaseProcess) -> None:
    parent.join()
    os._exit(1)
