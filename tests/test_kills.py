"""Commands killed at any moment leave the old files or the new ones, and the same command then ends as if nothing was.

Each of run, campaign, diagnose, blind make, blind answer, import of several logs and of one has six goes, and sixty in
`make fuzz`: four (forty), or as many as there are, end at a change of the disk, the others after some time, unless they
were done before. That makes more than 30 kills, and more than 250.
"""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Callable, Iterator
from pathlib import Path

import logfiles
import numpy as np
import pytest
from campaigns import SURGE, write_campaign
from fuzz import surge_run
from kills import begun, child, ended, hidden, seen

import vtank.library
import vtank.studies.blind.answer as answering
import vtank.studies.blind.make as making
from vtank.cli import main
from vtank.diagnose import selection
from vtank.effects.catalogue import BY_NAME
from vtank.record import Run, read_dataset
from vtank.studies.blind.answer import answer
from vtank.studies.blind.make import Made
from vtank.studies.blind.verify import open_all

KILLS = 4 * int(os.environ.get("VTANK_FUZZ", "1"))  # of each command
Trial = tuple[list[str], Callable[[Path], None]]

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not hasattr(os, "fork"), reason="forks its children")]


def moments(command: list[str], place: Path, kept: Path, seed: int) -> Iterator[dict[str, float]]:
    """When to kill: before changes of the disk, drawn among all it makes from `kept`, and at times within its run."""
    restore(place, kept)
    code, changes = child(command)
    assert code == 0 and changes > 0
    random = np.random.default_rng(seed)
    drawn = random.permutation(changes)[:KILLS]
    yield from ({"at": int(k)} for k in drawn)
    yield from ({"after_s": float(s)} for s in random.uniform(0.001, 0.2, KILLS - min(KILLS, drawn.size) + KILLS // 2))


def restore(place: Path, kept: Path) -> None:
    shutil.rmtree(place)
    shutil.copytree(kept, place)


def kill_again_and_again(
    command: list[str], place: Path, kept: Path, check: Callable[[], None], whole: Callable[[], None], seed: int
) -> None:
    """Kill a command at many moments, from the same beginning: `check` what is left, and the next go's `whole`."""
    killed = 0
    for moment in moments(command, place, kept, seed):
        restore(place, kept)
        code, _ = child(command, **moment)
        assert code in (0, -signal.SIGKILL, -signal.SIGALRM)
        killed += code != 0
        check()
        assert child(command)[0] == 0, moment
        whole()
        assert not hidden(place), moment
    assert killed >= min(KILLS, 4)


@pytest.fixture
def place(tmp_path: Path) -> Path:
    (tmp_path / "place").mkdir()
    return tmp_path / "place"


def test_kills_of_run(place: Path, tmp_path: Path) -> None:
    command = ["run", "paper-ds1", "open-loop-sine", "--model", "surge", "--set", "duration_s=6", "--out", f"{place}/d"]
    assert main([*command, "--seed", "1"]) == 0
    old, kept = seen(place), tmp_path / "kept"
    shutil.copytree(place, kept)
    command += ["--seed", "2"]
    assert main(command) == 0
    new = seen(place)
    assert old.keys() == new.keys() and old != new

    def check() -> None:
        assert seen(place) in (old, new)

    def whole() -> None:
        assert seen(place) == new

    kill_again_and_again(command, place, kept, check, whole, seed=1)


def test_kills_of_campaign(place: Path, tmp_path: Path) -> None:
    path, out, kept = write_campaign(tmp_path, SURGE), place / "out", tmp_path / "kept"
    command = ["campaign", str(path), "--threads", "1", "--out", str(out)]
    shutil.copytree(place, kept)
    assert main(command) == 0
    new = seen(place)

    def check() -> None:
        if (out / "campaign.json").is_file() and not (out / "journal" / "campaign.json").is_file():
            assert len(read_dataset(out)) == 12

    def whole() -> None:
        assert seen(place) == new

    kill_again_and_again(command, place, kept, check, whole, seed=2)


SAID = {"verdict": {"kind": "none", "probability": 1.0}, "probabilities": {"none": 1.0}}


def seal_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let `blind make` fly nothing: every case is the same."""
    run = surge_run(rows=20)
    sealed = Run("run", run.time_s, run.columns)
    truth = {"schema": "vtank.blind-truth/2", "kind": "none", "label": "none", "causes": []}
    monkeypatch.setattr(making, "_made", lambda *order: Made([run, run], [sealed], truth, "paper-ii", ()))


def test_kills_of_blind_make(place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is flown: what a case holds does not matter here."""
    seal_nothing(monkeypatch)
    cases, truths, kept = place / "cases", place / "truths", tmp_path / "kept"
    command = ["blind", "make", "--trials", "2", "--seed", "1", "--threads", "1"]
    command += ["--out", str(cases), "--truth-out", str(truths)]
    shutil.copytree(place, kept)

    def check() -> None:
        assert truths.exists() or not cases.exists()  # never cases that nobody can open

    def whole() -> None:
        (tmp_path / "answers.json").unlink(missing_ok=True)
        answer(cases, tmp_path / "answers.json", count=1, answer_case=lambda *given: {"document": SAID})
        assert len(open_all(cases, truths, tmp_path / "answers.json").truths) == 2

    # a go that was whole before it was killed is not made again: the command says so, with exit code 2
    killed = 0
    for moment in moments(command, place, kept, seed=3):
        restore(place, kept)
        code, _ = child(command, **moment)
        killed += code != 0
        check()
        was_whole = cases.exists()
        assert child(command)[0] == (2 if was_whole else 0), moment
        whole()
        assert not hidden(place), moment
    assert killed >= min(KILLS, 4)


@pytest.fixture(scope="module")
def diagnoses(tmp_path_factory: pytest.TempPathFactory) -> dict[int, vtank.library.Diagnosis]:
    """Two diagnoses of a recording, with other seeds, of two effects."""
    time = 0.1 * np.arange(300)
    heard = 3.0 - 0.4 * np.sin(time) + 0.01 * np.cos(7 * time)
    run = Run("run", time, {"n_rev_s": 10.0 * np.cos(time), "range_m": heard})
    chosen = [BY_NAME[name] for name in ("linear_drag", "wall_proximity")]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(selection, "candidates", lambda nominal, runs, names: chosen)
        return {seed: vtank.library.diagnose([run], seed=seed) for seed in (1, 2)}


def test_kills_of_diagnose(
    place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, diagnoses: dict[int, vtank.library.Diagnosis]
) -> None:
    """While it writes: before that it changes nothing. Each file is whole, and the next go writes all of them."""
    monkeypatch.setattr(vtank.library, "diagnose", lambda runs, nominal, seed, **_: diagnoses[seed])
    monkeypatch.setattr(vtank.library, "load", lambda path: ())
    command = ["diagnose", "data", "--json", f"{place}/d.json", "--model", f"{place}/d.toml"]
    command += ["--report", f"{place}/d.html", "--seed"]
    kill_writers([*command, "1"], [*command, "2"], place, tmp_path, seed=4)


def kill_writers(
    first: list[str] | None, second: list[str], place: Path, tmp_path: Path, seed: int, part: str = ""
) -> None:
    """Kill the second of two commands that write the same files: each of these is the first's or the second's.

    first: None where there is none, so that a file is not there, or the second's. part: file of a work that goes on,
    which may be there besides.
    """
    assert first is None or main(first) == 0
    old, kept = seen(place), tmp_path / "kept"
    shutil.copytree(place, kept)
    assert main(second) == 0
    new = seen(place)
    assert (first is None or old.keys() == new.keys()) and old != new

    def check() -> None:
        found = {name: digest for name, digest in seen(place).items() if name != part}
        assert old.keys() <= found.keys() <= new.keys()
        assert all(digest in (old.get(name), new[name]) for name, digest in found.items())

    def whole() -> None:
        assert seen(place) == new

    kill_again_and_again(second, place, kept, check, whole, seed)


@pytest.mark.parametrize("out", ["dives", "dives/one.csv"])
def test_kills_of_import(out: str, place: Path, tmp_path: Path) -> None:
    """Of tables and a log into a folder, and of a table into a file, over those of an earlier import."""
    commands = []
    for day, off in enumerate((0, 5)):
        (tmp_path / str(day)).mkdir()
        lines = ["ms;Propeller (rpm);Distance to wall (cm)", *(f"{100 * k};{60 * k};{300 + off}" for k in range(40))]
        tables = [tmp_path / str(day) / f"{name}.csv" for name in ("one", "two")]
        for table in tables:
            table.write_text("\n".join(lines))
        log = logfiles.tlog(tmp_path / str(day) / "dive.tlog")
        logs = tables[:1] if Path(out).suffix else [*tables, log]
        commands.append(["import", *map(str, logs), "--out", str(place / out)])
    kill_writers(*commands, place, tmp_path, seed=5)


def test_kills_of_blind_answer(place: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """None, or all. Nothing is diagnosed: what is answered does not matter here."""
    seal_nothing(monkeypatch)
    assert main(["blind", "make", "--trials", "3", "--seed", "1", "--threads", "1", "--out", f"{tmp_path}/cases"]) == 0
    monkeypatch.setattr(answering, "diagnose_case", lambda folder, seed, *_: {"document": SAID, "seed": seed})
    command = ["blind", "answer", f"{tmp_path}/cases", "--processes", "1", "--out", f"{place}/answers.json", "--seed"]
    kill_writers(None, [*command, "2"], place, tmp_path, seed=6, part="answers.json.part")


@pytest.mark.parametrize("command", ["run", "campaign", "diagnose"])
def test_a_full_disk_leaves_what_was_there(
    command: str,
    place: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    diagnoses: dict[int, vtank.library.Diagnosis],
) -> None:
    """As the system says it, here by a limit on the size of files: exit code 2, and a next go with room ends well."""
    monkeypatch.setattr(vtank.library, "diagnose", lambda runs, nominal, seed, **_: diagnoses[1])
    monkeypatch.setattr(vtank.library, "load", lambda path: ())
    words = {
        "run": ["run", "paper-ds1", "--model", "surge", "--set", "duration_s=6", "--out", f"{place}/d"],
        "campaign": ["campaign", str(write_campaign(tmp_path)), "--threads", "1", "--out", f"{place}/d"],
        "diagnose": ["diagnose", "data", "--json", f"{place}/d.json", "--report", f"{place}/d.html"],
    }[command]
    assert child(words, most_bytes=1000)[0] == 2
    assert command == "campaign" or not seen(place)
    assert child(words)[0] == 0 and seen(place) and not hidden(place)


def test_two_who_write_into_one_folder_at_once_leave_the_files_of_one_of_them(place: Path) -> None:
    command = ["run", "paper-ds1", "--model", "surge", "--set", "duration_s=6", "--out", f"{place}/d", "--seed"]
    whole = {}
    for seed in ("1", "2"):
        assert main([*command, seed]) == 0
        whole[seed] = seen(place)
    for _ in range(KILLS):
        codes = {ended(one)[0] for one in [begun([*command, seed]) for seed in whole]}
        assert 0 in codes and codes <= {0, 2}
        assert seen(place) in whole.values() and not hidden(place)
