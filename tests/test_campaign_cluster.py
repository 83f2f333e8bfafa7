"""A Dask scheduler and workers in processes of their own on loopback, one of them killed in flight."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from campaigns import campaign_of, digests

from vtank.errors import InputError
from vtank.studies.campaign import Cluster, LocalCluster, Tally, Threads, fly_campaign

pytest.importorskip("distributed")

PATIENCE_S = 60.0  # [s] for processes to start on a busy machine


class Machines:
    """A scheduler and two workers, each a process."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.file = folder, folder / "scheduler.json"
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = str(free.getsockname()[1])
        self.begin()

    def begin(self) -> None:
        """Start all of them, at the same address every time."""
        self.scheduler = self.start("scheduler", "--host", "127.0.0.1", "--port", self.port, "--no-dashboard")
        self.workers = [self.start("worker", "--nthreads", "1", "--no-nanny", "--no-dashboard") for _ in range(2)]

    def start(self, kind: str, *options: str) -> subprocess.Popen[bytes]:
        module = f"distributed.cli.dask_{kind}"
        command = [sys.executable, "-m", module, "--scheduler-file", str(self.file), *options]
        source = str(Path(__file__).parents[1] / "src")
        with (self.folder / f"{kind}.log").open("ab") as log:
            environment = os.environ | {"PYTHONPATH": source}
            return subprocess.Popen(command, stdout=log, stderr=log, env=environment, cwd=self.folder)

    def connect(self) -> Cluster:
        """The cluster, once all workers that live are there."""
        end = time.monotonic() + PATIENCE_S
        while not self.file.exists() or not self.file.read_text().strip():
            assert time.monotonic() < end, (self.folder / "scheduler.log").read_text()
            time.sleep(0.05)
        cluster = Cluster(json.loads(self.file.read_text())["address"])
        cluster.workers = sum(worker.poll() is None for worker in self.workers)
        cluster.client.wait_for_workers(cluster.workers, timeout=PATIENCE_S)
        return cluster

    def stop(self) -> None:
        for process in [*self.workers, self.scheduler]:
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def machines(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machines]:
    """Whole at first; the tests below, in their order, leave one worker and then nothing."""
    machines = Machines(tmp_path_factory.mktemp("machines"))
    try:
        yield machines
    finally:
        machines.stop()


@pytest.mark.slow
def test_a_worker_killed_in_flight_costs_no_run(tmp_path: Path, machines: Machines) -> None:
    """Bytes as from one thread, although one of two workers is killed after the first chunk."""
    campaign = campaign_of(tmp_path)
    fly_campaign(campaign, tmp_path / "threads", Threads(1))
    flown: list[int] = []

    def kill_one(tally: Tally) -> None:
        flown.append(tally.flown)
        if len(flown) == 2:
            machines.workers[0].kill()
            machines.workers[0].wait()

    with machines.connect() as cluster:
        assert cluster.workers == 2
        tally = fly_campaign(campaign, tmp_path / "cluster", cluster, "csv", kill_one, chunk=2)
        assert len(cluster.client.nthreads()) == 1
    assert tally.flown == 18 and len(flown) == 10 and flown[-1] == 18
    assert digests(tmp_path / "cluster") == digests(tmp_path / "threads")


def silent_when_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """Dask tells nobody of a result that is lost: as happens when it was just being fetched as the scheduler went."""
    from distributed import cfexecutor

    tell = cfexecutor._cascade_future

    async def tell_unless_lost(future: Any, told: Any) -> None:
        await future._state.wait()
        if not future.cancelled():
            await tell(future, told)

    monkeypatch.setattr(cfexecutor, "_cascade_future", tell_unless_lost)


@pytest.mark.parametrize("told", [True, False])
@pytest.mark.slow
def test_a_scheduler_that_is_started_again_costs_no_run(
    tmp_path: Path, machines: Machines, monkeypatch: pytest.MonkeyPatch, told: bool
) -> None:
    """It and its workers are killed after the first chunks, and started again at the same address."""
    if not told:
        silent_when_lost(monkeypatch)
    campaign, started = campaign_of(tmp_path), []
    fly_campaign(campaign, tmp_path / "threads", Threads(1))

    def start_again(tally: Tally) -> None:
        if tally.flown and not started:
            machines.stop()
            machines.file.unlink(missing_ok=True)
            machines.begin()
            started.append(tally.flown)

    def slow_down() -> None:
        """On a worker, which cannot import this file: no chunk is done as soon as it is given."""
        from vtank.studies.campaign import chunk

        at_once = chunk.fly_chunk

        def slowly(*arguments: Any) -> Any:
            time.sleep(0.5)
            return at_once(*arguments)

        chunk.fly_chunk = slowly

    with machines.connect() as cluster:
        cluster.client.run(slow_down)
        tally = fly_campaign(campaign, tmp_path / "cluster", cluster, "csv", start_again, chunk=2)
    assert started and started[0] < tally.flown == 18
    assert digests(tmp_path / "cluster") == digests(tmp_path / "threads")


def test_a_campaign_whose_scheduler_goes_can_go_on_elsewhere(
    tmp_path: Path, machines: Machines, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vtank.studies.campaign.executors.RESTART_S", 0.5)
    campaign, out = campaign_of(tmp_path), tmp_path / "cluster"
    fly_campaign(campaign, tmp_path / "threads", Threads(1))

    def kill_all(tally: Tally) -> None:
        if tally.flown:
            machines.stop()

    with machines.connect() as cluster, pytest.raises(InputError, match="the scheduler is gone"):
        fly_campaign(campaign, out, cluster, "csv", kill_all, chunk=2)
    tally = fly_campaign(campaign, out, Threads(1))
    assert tally.before >= 2 and tally.before + tally.flown == 18
    assert digests(out) == digests(tmp_path / "threads")


@pytest.mark.slow
def test_a_local_cluster_gives_the_same_bytes(tmp_path: Path) -> None:
    campaign = campaign_of(tmp_path)
    fly_campaign(campaign, tmp_path / "threads", Threads(1))
    with LocalCluster(2) as cluster:
        fly_campaign(campaign, tmp_path / "cluster", cluster)
    assert digests(tmp_path / "cluster") == digests(tmp_path / "threads")


def fill() -> None:
    """On a worker: what it writes from now on does not fit, and it writes before it computes."""
    import resource

    from vtank.studies.campaign import chunk

    sound = chunk.fly_chunk

    def written(*arguments: Any) -> Any:
        spilled = Path(f"/tmp/spilled-{os.getpid()}")
        try:
            spilled.write_bytes(b"spilled")
        finally:
            spilled.unlink(missing_ok=True)
        return sound(*arguments)

    resource.setrlimit(resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
    chunk.fly_chunk = written


@pytest.mark.slow
def test_a_full_disk_on_one_worker_costs_no_run_and_on_all_is_told(tmp_path: Path) -> None:
    campaign = campaign_of(tmp_path)
    fly_campaign(campaign, tmp_path / "threads", Threads(1))
    with LocalCluster(2) as cluster:
        first, second = cluster.client.nthreads()
        cluster.client.run(fill, workers=[first])
        tally = fly_campaign(campaign, tmp_path / "cluster", cluster, chunk=2)
        assert tally.flown == 18 and digests(tmp_path / "cluster") == digests(tmp_path / "threads")
        cluster.client.run(fill, workers=[second])
        with pytest.raises(InputError, match="no worker is left that can work: tcp.*: .*File too large"):
            fly_campaign(campaign, tmp_path / "again", cluster, chunk=2)


def test_an_address_where_nobody_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vtank.studies.campaign.executors.PATIENCE_S", 0.2)
    with pytest.raises(InputError, match="tcp://127.0.0.1:9: no Dask scheduler answers there"):
        Cluster("tcp://127.0.0.1:9")


def test_a_local_worker_that_dies_at_its_start_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    def dies(*arguments: object, **settings: object) -> None:
        raise RuntimeError("Nanny failed to start.")

    monkeypatch.setattr("distributed.LocalCluster", dies)
    with pytest.raises(InputError, match=r"did not start \(Nanny failed to start.\): too little memory"):
        LocalCluster(2)
