"""The same bytes from threads, processes and a cluster; what happens when workers die."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Executor as Pool
from concurrent.futures import Future
from functools import partial
from pathlib import Path

import pytest
from campaigns import SURGE, campaign_of, digests

from vtank.errors import InputError
from vtank.studies.campaign import Executor, Processes, Threads, fly_campaign
from vtank.studies.campaign.executors import flow
from vtank.studies.campaign.flying import chunk_size
from vtank.studies.processes import processes

TANK = """
seed = 3
[grid]
scenario = ["paper-ds1", "open-loop-sine"]
duration_s = 1.5
effects = [{}, { command_delay = { d_s = 0.13 } }, { wall_proximity = { drag = 0.1 } }]
[draw]
sonar.noise_m = { uniform = [0.001, 0.01] }
"""


@pytest.mark.parametrize("text", [SURGE, TANK], ids=["surge", "tank"])
@pytest.mark.slow
def test_threads_and_processes_give_the_same_bytes(tmp_path: Path, text: str) -> None:
    """One thread with one chunk, two threads and two processes with chunks of other sizes."""
    campaign = campaign_of(tmp_path, text)
    executors: list[tuple[Executor, int]] = [(Threads(1), 100), (Threads(2), 4), (Processes(2), 5)]
    folders = []
    for i, (executor, chunk) in enumerate(executors):
        folders.append(tmp_path / f"out{i}")
        fly_campaign(campaign, folders[-1], executor, chunk=chunk)
    first = digests(folders[0])
    assert len([name for name in first if name.startswith("data/run_")]) == (12 if text == SURGE else 6)
    assert digests(folders[1]) == first and digests(folders[2]) == first


def test_chunks_fill_all_workers_and_stay_small_enough_for_memory(tmp_path: Path) -> None:
    text = 'model = "{}"\nrepeats = {}\n[grid]\nscenario = "chirp"\nduration_s = {}'
    sizes = {
        ("tank", 10_000, 120.0, 2): 64,
        ("tank", 24, 120.0, 2): 3,
        ("surge", 100_000, 12.0, 4): 256,
        ("surge", 100_000, 3600.0, 4): 11,
        ("surge", 3, 120.0, 16): 1,
    }
    for (model, repeats, duration, workers), size in sizes.items():
        assert chunk_size(campaign_of(tmp_path, text.format(model, repeats, duration)), workers) == size


class Lazy(Pool):
    """Computes when the result is asked for, and counts what is under way."""

    def __init__(self) -> None:
        self.submitted = 0

    def submit(self, work, /, *args, **kwargs):  # type: ignore[no-untyped-def]
        self.submitted += 1
        future: Future[int] = Future()
        future.set_result(work(*args))
        return future


def test_only_a_few_chunks_are_under_way() -> None:
    """However many chunks there are, no more are submitted than were asked for and fit the window."""
    pool = Lazy()
    results = flow(pool, lambda number: number, deque(range(1000)), 4)
    for taken in range(1, 50):
        next(results)
        assert pool.submitted - taken <= 4
    assert pool.submitted < 60


def test_after_an_exception_nothing_is_forgotten() -> None:
    """What was not yielded is still to be done."""

    def work(number: int) -> int:
        if number == 5:
            raise ArithmeticError
        return number

    class Failing(Lazy):
        def submit(self, work, /, *args, **kwargs):  # type: ignore[no-untyped-def]
            future: Future[int] = Future()
            try:
                future.set_result(work(*args))
            except ArithmeticError as error:
                future.set_exception(error)
            return future

    left, done = deque(range(10)), []
    with pytest.raises(ArithmeticError):
        for number in flow(Failing(), work, left, 3):
            done.append(number)
    assert sorted([*done, *left]) == list(range(10)) and 5 in left


def test_a_chunk_that_never_ends_is_asked_about_and_not_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vtank.studies.campaign.executors.SILENCE_S", 0.01)

    class Deaf(Lazy):
        def submit(self, work, /, *args, **kwargs):  # type: ignore[no-untyped-def]
            return Future() if args == (2,) else super().submit(work, *args, **kwargs)

    asked: list[int] = []

    def silent() -> None:
        asked.append(len(asked))
        if len(asked) == 3:
            raise ConnectionError

    left, done = deque(range(10)), []
    with pytest.raises(ConnectionError):
        for number in flow(Deaf(), lambda number: number, left, 3, silent):
            done.append(number)
    assert len(asked) == 3 and sorted(done) == [0, 1, 3, 4, 5, 6, 7, 8, 9] and list(left) == [2]


def fall_once(flag: Path, number: int) -> int:
    """The number; whoever is the first to be given 3 is killed."""
    if number == 3 and not flag.exists():
        flag.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def fall(number: int) -> int:
    """Every worker is killed."""
    os.kill(os.getpid(), signal.SIGKILL)
    return number


@pytest.mark.slow
def test_a_process_that_is_killed_costs_nothing_but_time(tmp_path: Path) -> None:
    results: Iterator[int] = Processes(2).results(partial(fall_once, tmp_path / "flag"), list(range(8)))
    assert sorted(results) == list(range(8))
    assert (tmp_path / "flag").exists()


@pytest.mark.slow
def test_a_case_whose_process_dies_ends_the_work_with_a_reason() -> None:
    with pytest.raises(InputError, match="a worker process died: too little memory"), processes(2) as work:
        list(work(fall, [1, 2]))


@pytest.mark.slow
def test_processes_that_always_die_are_given_up() -> None:
    with pytest.raises(InputError, match="worker processes die again and again"):
        list(Processes(1).results(fall, [1]))


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="looks for the process in /proc")
@pytest.mark.parametrize(
    "parent_does",
    [
        "import vtank.studies.campaign as v; list(v.Processes(1).results(c.note_and_sleep, sys.argv[1:]))",
        "import vtank.studies.processes as p\nwith p.processes(2) as work: list(work(c.note_and_sleep, sys.argv[1:]))",
    ],
    ids=["of a campaign", "of cases"],
)
def test_workers_end_with_their_parent(parent_does: str, tmp_path: Path) -> None:
    """The parent is killed and can tell nobody."""
    code = f"import sys, campaigns as c\n{parent_does}"
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    note = tmp_path / "pid"
    with subprocess.Popen([sys.executable, "-c", code, str(note)], env=os.environ | {"PYTHONPATH": path}) as parent:
        until(lambda: note.exists() and note.read_text())
        parent.kill()
    worker = int(note.read_text())
    until(lambda: not Path(f"/proc/{worker}").exists() or "Z" in Path(f"/proc/{worker}/stat").read_text().split()[2])


@pytest.mark.skipif(not hasattr(os, "fork"), reason="sends the signal of Ctrl-C")
def test_an_interruption_does_not_wait_for_the_cases_under_way(tmp_path: Path) -> None:
    """Of the parent alone, as by kill -INT; each case would take a minute."""
    code = "import signal, sys, campaigns as c, vtank.studies.processes as p\n"
    code += (
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # which whoever runs the tests may have ignored
    )
    code += "with p.processes(2) as work: list(work(c.note_and_sleep, sys.argv[1:]))"
    path = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    note = tmp_path / "pid"
    command, environment = [sys.executable, "-c", code, str(note)], os.environ | {"PYTHONPATH": path}
    with subprocess.Popen(command, env=environment, stderr=subprocess.PIPE, text=True) as parent:
        until(lambda: note.exists() and note.read_text())
        parent.send_signal(signal.SIGINT)
        _, said = parent.communicate(timeout=30.0)
    assert said.strip().endswith("KeyboardInterrupt") and said.count("Traceback") == 1


def until(holds: Callable[[], object], patience_s: float = 60.0) -> None:
    """Wait for something to hold."""
    end = time.monotonic() + patience_s
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_versions_of_all_workers_must_agree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker with another numpy could compute other numbers."""
    campaign = campaign_of(tmp_path)
    monkeypatch.setattr("vtank.studies.campaign.chunk.versions", lambda: {"numpy": "0.1"})
    with pytest.raises(InputError, match=r"a worker computes with .*numpy 0\.1 \(here"):
        fly_campaign(campaign, tmp_path / "out", Threads(1))
