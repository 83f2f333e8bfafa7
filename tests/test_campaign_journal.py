"""Interrupted campaigns: nothing lost, nothing done twice, the same bytes in the end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from campaigns import campaign_of, digests, write_campaign

import vtank.studies.campaign.journal
from vtank.errors import InputError
from vtank.studies.campaign import Tally, Threads, fly_campaign

CHUNK = 4  # runs: five chunks of 18 runs
KILLED_AFTER_TWO_CHUNKS = """
import os, signal, sys
from pathlib import Path
from vtank.studies.campaign import Threads, fly_campaign, load_campaign
def progress(tally):
    if tally.flown >= 8:
        os.kill(os.getpid(), signal.SIGKILL)
fly_campaign(load_campaign(sys.argv[1]), Path(sys.argv[2]), Threads(2), sys.argv[3], progress, chunk=4)
"""


class Killed(BaseException):
    """Stands for the end of the process."""


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, str]]:
    """What undisturbed campaigns leave, by form."""
    folder = tmp_path_factory.mktemp("finished")
    for form in ("csv", "hdf5"):
        fly_campaign(campaign_of(folder), folder / form, Threads(2), form, chunk=CHUNK)
    return {form: digests(folder / form) for form in ("csv", "hdf5")}


@pytest.mark.parametrize("form", ["csv", "hdf5"])
def test_a_campaign_killed_in_the_middle_goes_on(
    tmp_path: Path, form: str, finished: dict[str, dict[str, str]]
) -> None:
    """SIGKILL after two chunks of five, with others under way; those two are not done again."""
    path, out = write_campaign(tmp_path), tmp_path / "out"
    command = [sys.executable, "-c", KILLED_AFTER_TWO_CHUNKS, str(path), str(out), form]
    assert subprocess.run(command, capture_output=True).returncode == -signal.SIGKILL
    pages = {page: page.stat().st_mtime_ns for page in (out / "journal").glob("0*.json")}
    assert len(pages) == 2 and not (out / "campaign.json").exists()
    seen: list[Tally] = []
    kept: dict[Path, int] = {}

    def progress(tally: Tally) -> None:
        seen.append(tally)
        kept.update({page: page.stat().st_mtime_ns for page in pages})

    tally = fly_campaign(campaign_of(tmp_path), out, Threads(2), form, progress, chunk=7)
    assert kept == pages  # as they were
    assert len(seen) == 4 and tally.before in (6, 8) and tally.before + tally.flown == 18
    assert digests(out) == finished[form]


def interrupt(monkeypatch: pytest.MonkeyPatch, at: int) -> Callable[[], int]:
    """Let the process end instead of the at-th renaming; returns a count of those done."""
    count = 0
    replace = os.replace

    def renaming(source: Path, target: Path) -> None:
        nonlocal count
        if count == at:
            raise Killed
        count += 1
        replace(source, target)

    monkeypatch.setattr(vtank.studies.campaign.journal.os, "replace", renaming)
    return lambda: count


@pytest.mark.parametrize("form", ["csv", "hdf5"])
def test_the_end_may_come_at_any_renaming(
    tmp_path: Path, form: str, monkeypatch: pytest.MonkeyPatch, finished: dict[str, dict[str, str]]
) -> None:
    """Files take their names one after the other; whichever is the last, the next go ends with the same bytes."""
    campaign = campaign_of(tmp_path)
    at = 0
    while True:
        out = tmp_path / f"out{at}"
        with monkeypatch.context() as patch:
            renamed = interrupt(patch, at)
            try:
                fly_campaign(campaign, out, Threads(1), form, chunk=CHUNK)
                break
            except Killed:
                assert renamed() == at
        fly_campaign(campaign, out, Threads(1), form, chunk=CHUNK)
        assert digests(out) == finished[form], f"after {at} renamings"
        at += 1
    assert at == {"csv": 9, "hdf5": 14}[form]  # beginning, five chunks (two files each for HDF5), results, end


def test_a_recording_cut_short_is_done_again(tmp_path: Path, finished: dict[str, dict[str, str]]) -> None:
    """As after a loss of power, when a page of the journal can be there without its recordings."""
    campaign, out = campaign_of(tmp_path), tmp_path / "out"

    def stop(tally: Tally) -> None:
        if tally.flown >= 12:
            raise Killed

    with pytest.raises(Killed):
        fly_campaign(campaign, out, Threads(1), "csv", stop, chunk=CHUNK)
    (out / "data" / "run_01.csv").write_bytes(b"time_s,n_rev_s,range_m\n0,")
    (out / "journal" / "000008.json").write_text("")
    tally = fly_campaign(campaign, out, Threads(1))
    assert (tally.before, tally.flown) == (4, 14)
    assert digests(out) == finished["csv"]


def test_what_is_done_is_not_done_again(tmp_path: Path) -> None:
    campaign, out = campaign_of(tmp_path), tmp_path / "out"
    first = fly_campaign(campaign, out, Threads(1))
    before = {path: path.stat().st_mtime_ns for path in out.rglob("*")}
    second = fly_campaign(campaign, out, Threads(1))
    assert (first.flown, second.before, second.flown) == (18, 18, 0)
    assert first.failed == second.failed == 6
    assert {path: path.stat().st_mtime_ns for path in out.rglob("*")} == before


def test_another_campaign_is_not_written_over(tmp_path: Path) -> None:
    out = tmp_path / "out"
    fly_campaign(campaign_of(tmp_path), out, Threads(1))
    before = digests(out)
    other = campaign_of(tmp_path, '[grid]\nscenario = "chirp"')
    with pytest.raises(InputError, match="holds another campaign"):
        fly_campaign(other, out, Threads(1))
    with pytest.raises(InputError, match="in another form"):
        fly_campaign(campaign_of(tmp_path), out, Threads(1), "hdf5")
    assert digests(out) == before


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match=r"not a campaign begun by vtank, holds notes\.txt"):
        fly_campaign(campaign_of(tmp_path), tmp_path / "out", Threads(1))
    assert digests(tmp_path / "out").keys() == {"notes.txt"}


def test_other_versions_do_not_go_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of the runs with one numpy and half with another would not be one data set."""
    fly_campaign(campaign_of(tmp_path), tmp_path / "out", Threads(1))
    here = vtank.studies.campaign.journal.versions()
    monkeypatch.setattr(vtank.studies.campaign.journal, "versions", lambda: here | {"numpy": "9.9"})
    with pytest.raises(InputError, match=rf"numpy {here['numpy']} \(here 9\.9\)"):
        fly_campaign(campaign_of(tmp_path), tmp_path / "out", Threads(1))


def test_two_processes_do_not_fly_into_one_folder(tmp_path: Path) -> None:
    campaign, out = campaign_of(tmp_path), tmp_path / "out"

    def second(tally: Tally) -> None:
        with pytest.raises(InputError, match="another process is flying this campaign"):
            fly_campaign(campaign, out, Threads(1))

    assert fly_campaign(campaign, out, Threads(1), "csv", second).flown == 18
