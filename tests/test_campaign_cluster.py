"""A Dask scheduler and workers in processes of their own on loopback, one of them killed in flight."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

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
        self.scheduler = self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
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
    left_s: list[float] = []

    def kill_one(tally: Tally) -> None:
        left_s.append(tally.left_s)
        if len(left_s) == 2:
            machines.workers[0].kill()
            machines.workers[0].wait()

    with machines.connect() as cluster:
        assert cluster.workers == 2
        tally = fly_campaign(campaign, tmp_path / "cluster", cluster, "csv", kill_one, chunk=2)
        assert len(cluster.client.nthreads()) == 1
    assert tally.flown == 18 and len(left_s) == 10 and left_s[-1] == 0.0
    assert digests(tmp_path / "cluster") == digests(tmp_path / "threads")


def test_a_campaign_whose_scheduler_goes_can_go_on_elsewhere(tmp_path: Path, machines: Machines) -> None:
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
