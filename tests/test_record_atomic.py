"""Files and folders that are written: as a set, in one step, and what a killed process leaves is cleared away."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from vtank.errors import InputError
from vtank.record import atomic
from vtank.record.atomic import exchanged, left_rooms, room, write_bytes, write_files, write_text
from vtank.record.files import MOST_BYTES, read_bytes
from vtank.record.folder import Kind, new_folder, results_folder
from vtank.record.lock import Held, locked

KIND = Kind("a trial", "trial.json", "trial/1")
KILLED_IN_A_ROOM = """
import os, signal, sys
from pathlib import Path
from vtank.record.atomic import room
with room(Path(sys.argv[1])) as beside:
    (beside / "half").write_text("half")
    print(beside, flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def text_of(folder: Path) -> str:
    return (folder / "a.txt").read_text()


def write(out: Path, text: str) -> None:
    with results_folder(out, KIND) as folder:
        (folder / "a.txt").write_text(text)


def test_a_set_of_files_is_written_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    paths = [tmp_path / name for name in ("a.json", "b.toml", "c.html")]
    write_files(dict.fromkeys(paths, b"old"))
    write = Path.write_bytes

    def full(path: Path, data: bytes) -> int:
        if path.name == "c.html":
            raise OSError(28, "No space left on device")
        return write(path, data)

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(InputError, match=r"c.html: cannot be written \(No space left"):
        write_files(dict.fromkeys(paths, b"new"))
    assert {path.read_bytes() for path in paths} == {b"old"} and len(os.listdir(tmp_path)) == 3


def test_text_with_a_name_that_is_no_text_can_be_written(tmp_path: Path) -> None:
    write_text(tmp_path / "a.json", json.dumps({"run": "\udcff"}, ensure_ascii=False))
    assert json.loads((tmp_path / "a.json").read_text()) == {"run": "\udcff"}


def test_what_a_killed_process_left_is_cleared_away_by_the_next(tmp_path: Path) -> None:
    target, stranger = tmp_path / "a.csv", tmp_path / ".a.csv-backup"
    stranger.mkdir()
    killed = subprocess.run(
        [sys.executable, "-c", KILLED_IN_A_ROOM, str(target)], capture_output=True, text=True, check=False
    )
    assert killed.returncode == -signal.SIGKILL and Path(killed.stdout.strip()).is_dir()
    write_bytes(target, b"whole")
    assert sorted(os.listdir(tmp_path)) == [".a.csv-backup", "a.csv"] and target.read_bytes() == b"whole"


def test_the_room_of_another_who_still_writes_is_left_alone(tmp_path: Path) -> None:
    with room(tmp_path / "a.csv") as other:
        write_bytes(tmp_path / "a.csv", b"mine")
        assert other.is_dir() and not list(left_rooms(tmp_path / "a.csv"))


def test_a_folder_is_there_at_every_moment_while_it_is_replaced(tmp_path: Path) -> None:
    out, gone, stop = tmp_path / "out", [], threading.Event()
    write(out, "0")
    if not exchanged(out, Path(out)):
        pytest.skip("this file system cannot exchange two names")

    def watch() -> None:
        while not stop.is_set():
            if not (out / "a.txt").exists():
                gone.append(1)

    watcher = threading.Thread(target=watch)
    watcher.start()
    for k in range(200):
        write(out, str(k))
    stop.set()
    watcher.join()
    assert not gone and text_of(out) == "199" and os.listdir(tmp_path) == ["out"]


def test_without_exchange_a_kill_between_two_renamings_is_taken_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    write(out, "old")
    program = f"""
import os, signal
from pathlib import Path
import sys; sys.path.insert(0, {str(Path(__file__).parent)!r})
from vtank.record import atomic
from test_record_atomic import write
atomic.exchanged = lambda one, other: False
rename = Path.rename
def killed(path, target):
    rename(path, target)
    os.kill(os.getpid(), signal.SIGKILL)
Path.rename = killed
write(Path({str(out)!r}), "new")
"""
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == -signal.SIGKILL
    assert not out.exists()
    monkeypatch.setattr(atomic, "exchanged", lambda one, other: False)
    with pytest.raises(ZeroDivisionError), new_folder(out, KIND):
        1 / 0  # noqa: B018
    assert text_of(out) == "old"  # what was moved aside is back, whatever became of the next go
    write(out, "new")
    assert text_of(out) == "new" and os.listdir(tmp_path) == ["out"]


def test_a_lock_is_held_by_one_alone(tmp_path: Path) -> None:
    with locked(tmp_path), pytest.raises(Held), locked(tmp_path):
        pass
    with locked(tmp_path):
        pass
    with pytest.raises(FileNotFoundError), locked(tmp_path / "nothing"):
        pass


def test_a_file_of_gigabytes_is_not_read(tmp_path: Path) -> None:
    with (tmp_path / "sparse.csv").open("wb") as file:
        file.truncate(10 * 2**30)
    with pytest.raises(InputError, match="holds 10,240 MB, expected 256 MB at most"):
        read_bytes(tmp_path / "sparse.csv")
    assert MOST_BYTES == 2**28


def test_where_there_are_no_locks_nothing_of_others_is_cleared_away(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(number: int, how: int) -> None:
        raise OSError(37, "No locks available")

    monkeypatch.setattr("fcntl.flock", none)
    with locked(tmp_path) as sure:
        assert not sure
    with room(tmp_path / "a.csv") as other:
        write_bytes(tmp_path / "a.csv", b"mine")
        assert other.is_dir()
