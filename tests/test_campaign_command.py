"""`vtank campaign`, as it is typed."""

from __future__ import annotations

import io
import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from campaigns import SURGE, digests, write_campaign

from vtank.cli import main
from vtank.cli.campaign import _follow
from vtank.cli.progress import progress
from vtank.record import read_dataset
from vtank.studies.campaign.flying import Tally


def test_a_campaign_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Threads and the default are the same; the counter ends at the last run; the data set can be read."""
    path, out = str(write_campaign(tmp_path)), tmp_path / "out"
    assert main(["campaign", path, "--out", str(out), "--threads", "1"]) == 0
    said = capsys.readouterr()
    assert "18 runs, 6 of them failed (runs.csv says why)" in said.out and "runs/s" in said.out
    assert "run 18/18" in said.err and "runs/s, 6 failed (" in said.err
    assert len(read_dataset(out / "data")) == 12
    assert main(["campaign", path, "--out", str(tmp_path / "again")]) == 0
    assert digests(out) == digests(tmp_path / "again")
    assert main(["campaign", path, "--out", str(out)]) == 0
    assert "all done before" in capsys.readouterr().out


def test_an_hdf5_file_from_the_command_line(tmp_path: Path) -> None:
    pytest.importorskip("h5py")
    assert main(["campaign", str(write_campaign(tmp_path)), "--out", str(tmp_path / "out"), "--format", "hdf5"]) == 0
    assert digests(tmp_path / "out").keys() == {"campaign.json", "runs.csv", "runs.h5"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing"], "no campaign named 'nothing'; there are:"),
        (["paper-noise", "--threads", "0"], "--threads 0: expected a whole number of at least 1"),
        (["paper-noise", "--processes", "-1"], "--processes -1: expected a whole number of at least 1"),
        (["paper-noise", "--processes", "100000"], "--processes 100000: expected a whole number up to 1024"),
        (["paper-noise", "--local-cluster", "0"], "--local-cluster 0: expected a whole number of at least 1"),
    ],
)
def test_wrong_arguments_are_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    assert main(["campaign", *arguments, "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert message in said and "Traceback" not in said
    assert not (tmp_path / "out").exists()


def test_a_campaign_in_which_nothing_succeeds_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_campaign(tmp_path, SURGE.replace("[0.2, 0.4, 4.0]", "4.0"))
    assert main(["campaign", str(path), "--out", str(tmp_path / "out")]) == 2
    assert "all 6 runs failed; runs.csv says why" in capsys.readouterr().err
    assert (tmp_path / "out" / "runs.csv").read_text().count("hits the wall") > 0


def test_interrupting_says_how_to_go_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("vtank.studies.campaign.fly_campaign", interrupted)
    assert main(["campaign", str(write_campaign(tmp_path)), "--out", str(tmp_path / "out")]) == 130
    assert "the same command goes on from here" in capsys.readouterr().err


def test_rate(monkeypatch: pytest.MonkeyPatch) -> None:
    """From the runs of this go alone."""
    monkeypatch.setattr("vtank.studies.campaign.flying.monotonic", lambda: 1050.0)
    tally = Tally(total=1000, before=400, flown=200, failed=3, start=1000.0)
    assert (tally.rate, tally.note) == (4.0, "4 runs/s, 3 failed")
    assert Tally(10, 4).note == "done before"


def test_one_time_left_is_told_and_from_the_runs_of_this_go_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = SimpleNamespace(monotonic=lambda: 1000.0)
    monkeypatch.setattr("vtank.cli.progress.time", clock)
    monkeypatch.setattr("vtank.studies.campaign.flying.monotonic", lambda: 1050.0)
    stream = io.StringIO()
    advance = progress("flying x, run", 1000, stream)
    show, tally = _follow(advance), Tally(total=1000, before=400, start=1000.0)
    show(tally)
    clock.monotonic = lambda: 1050.0
    tally.flown = 200
    show(tally)
    assert re.findall(r"[\d.]+ s left", stream.getvalue().splitlines()[-1]) == ["100 s left"]
