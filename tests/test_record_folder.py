"""Folders that vtank writes: nothing of the user's is lost, whichever command writes, and that is said before work."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from campaigns import campaign_of

from vtank.cli import main
from vtank.errors import InputError
from vtank.record import read_dataset
from vtank.record.folder import Kind, new_folder, results_folder
from vtank.studies.campaign import Threads, fly_campaign

KIND = Kind("a trial", "trial.json", "trial/1")
QUICK = ["--model", "surge", "--set", "duration_s=4"]

# Every command that writes a folder; OUT is the folder
WRITERS = {
    "run": ["run", "paper-ds1", *QUICK, "--out", "OUT"],
    "campaign": ["campaign", "paper-noise", "--out", "OUT"],
    "reproduce": ["reproduce", "--quick", "--out", "OUT"],
    "demo": ["demo", "--out", "OUT"],
    "identify": ["identify", "no-data-is-read", "--out", "OUT"],
    "bandwidth": ["bandwidth", "paper-ds1", "--out", "OUT"],
    "identifiability": ["identifiability", "--out", "OUT"],
    "a plan": ["identifiability", "--design", "--write-plan", "OUT"],
    "blind make": ["blind", "make", "--trials", "1", "--seed", "1", "--out", "OUT"],
    "the truth of blind make": [
        "blind",
        "make",
        "--trials",
        "1",
        "--seed",
        "1",
        "--out",
        "cases",
        "--truth-out",
        "OUT",
    ],
    "blind score": ["blind", "score", "cases", "--truth", "truth", "--out", "OUT"],
}


def everything(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("writer", WRITERS)
@pytest.mark.parametrize("place", ["OUT", "."])
def test_no_command_takes_the_place_of_files_that_are_not_its_own(
    writer: str, place: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Dotfiles are files too: a repository of the user's stands in the folder."""
    out = tmp_path / "mine"
    (out / ".git").mkdir(parents=True)
    (out / ".git" / "HEAD").write_text("ref: refs/heads/main\n")
    monkeypatch.chdir(out)
    folder = str(out) if place == "OUT" else place
    assert main([folder if word == "OUT" else word for word in WRITERS[writer]]) == 2
    said = capsys.readouterr().err
    assert folder in said and ".git" in said and "choose another folder" in said
    assert everything(out) == {".git/HEAD": b"ref: refs/heads/main\n"}
    assert [path.name for path in tmp_path.iterdir()] == ["mine"]


@pytest.mark.parametrize("stranger", [".env", "notes.txt", "sub/.hidden", "link", "empty"])
def test_one_file_beside_its_own_is_enough_to_refuse(stranger: str, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with results_folder(out, KIND) as folder:
        (folder / "sub").mkdir()
        (folder / "sub" / "a.txt").write_text("one")
    with results_folder(out, KIND) as folder:  # its own goes, whole
        (folder / "b.txt").write_text("two")
    assert everything(out).keys() == {"b.txt", "trial.json"}
    (out / stranger).parent.mkdir(exist_ok=True)
    if stranger == "link":
        (out / stranger).symlink_to(tmp_path)
    elif stranger == "empty":
        (out / stranger).mkdir()
    else:
        (out / stranger).write_text("mine")
    with pytest.raises(InputError, match=f"holds {stranger}, no part of a trial"), new_folder(out, KIND):
        pytest.fail("the work was begun")
    assert (out / stranger).exists() and (out / "b.txt").exists()


def test_what_is_put_there_during_the_work_is_kept(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with pytest.raises(InputError, match="holds mine"), new_folder(out, KIND) as folder:
        (folder / "a").write_text("new")
        out.mkdir()
        (out / "mine").write_text("mine")
    assert everything(out) == {"mine": b"mine"} and os.listdir(tmp_path) == ["out"]


@pytest.mark.parametrize(
    "text", ["{", "[]", '{"schema": "other"}', '{"schema": "trial/1"}', '{"schema":"trial/1","files":3}']
)
def test_a_marker_that_lists_nothing_marks_nothing(text: str, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "trial.json").write_text(text)
    with pytest.raises(InputError, match="trial.json"), new_folder(tmp_path / "out", KIND):
        pass


def test_the_folder_one_is_in_is_not_taken_away(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "sub").mkdir()
    monkeypatch.chdir(tmp_path / "sub")
    with pytest.raises(InputError, match="is the folder you are in"), new_folder(".", KIND):
        pass


@pytest.mark.parametrize("out", [".", "/"])
def test_blind_make_and_score_refuse_folders_without_a_name(
    out: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    monkeypatch.chdir(tmp_path)
    assert main(["blind", "make", "--trials", "1", "--seed", "1", "--out", out]) == 2
    assert main(["blind", "score", out, "--truth", "truth"]) == 2
    assert "vtank: error: " in capsys.readouterr().err and everything(tmp_path) == {"mine.txt": b"mine"}


def test_the_truth_does_not_lie_with_the_cases(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make = ["blind", "make", "--trials", "1", "--seed", "1", "--out", str(tmp_path / "a"), "--truth-out"]
    for place in (tmp_path / "a", tmp_path / "a" / "truth", tmp_path):
        assert main([*make, str(place)]) == 2
        assert "apart from" in capsys.readouterr().err


def test_a_folder_called_journal_is_no_campaign(tmp_path: Path) -> None:
    diary = tmp_path / "out" / "journal" / "monday.txt"
    diary.parent.mkdir(parents=True)
    diary.write_text("mine")
    with pytest.raises(InputError, match="not a campaign begun by vtank"):
        fly_campaign(campaign_of(tmp_path), tmp_path / "out", Threads(1))
    assert everything(tmp_path / "out") == {"journal/monday.txt": b"mine"}


def test_a_campaign_is_read_where_its_runs_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """And what somebody puts into a finished campaign is left to him."""
    out, campaign = tmp_path / "out", campaign_of(tmp_path)
    fly_campaign(campaign, out, Threads(1))
    assert [run.name for run in read_dataset(out)] == [run.name for run in read_dataset(out / "data")]
    assert main(["check-data", str(out)]) == 0 and "12 runs" in capsys.readouterr().out
    told = (out / "data" / "manifest.json").read_text()
    assert not [word for word in ("scenario =", "grid", "linear_drag", "truth", "noise") if word in told]
    assert json.loads((out / "campaign.json").read_text())["scenarios"]
    (out / "journal").mkdir()
    (out / "journal" / "monday.txt").write_text("mine")
    fly_campaign(campaign, out, Threads(1))
    assert (out / "journal" / "monday.txt").read_text() == "mine"
    for half in ("hdf5", "begun"):
        (tmp_path / half / "journal").mkdir(parents=True)
    (tmp_path / "hdf5" / "campaign.json").write_text("{}")
    (tmp_path / "begun" / "journal" / "campaign.json").write_text("{}")
    for half, words in {"hdf5": "without CSV runs", "begun": "not finished"}.items():
        with pytest.raises(InputError, match=words):
            read_dataset(tmp_path / half)


@pytest.mark.parametrize(
    "page", ["[]", "{}", '{"rows": []}', '{"rows": 1, "sizes": {}}', "{", '{"sizes": {"a": 1}, "rows": []}']
)
def test_a_broken_page_of_a_journal_is_flown_again(page: str, tmp_path: Path) -> None:
    class Stop(Exception):
        pass

    def stop(tally: object) -> None:
        if any(out.glob("journal/0*.json")):
            raise Stop

    out, campaign = tmp_path / "out", campaign_of(tmp_path)
    with pytest.raises(Stop):
        fly_campaign(campaign, out, Threads(1), progress=stop, chunk=9)
    next(out.glob("journal/0*.json")).write_text(page)
    assert fly_campaign(campaign, out, Threads(1)).flown == 18
