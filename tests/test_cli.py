"""The command: exit codes, one clear message for bad input, progress, a fast and quiet start."""

from __future__ import annotations

import importlib
import io
import os
import pty
import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from select import select
from types import SimpleNamespace

import numpy as np
import pytest

import vtank
import vtank.cli as cli
from vtank.cli.progress import percent, progress
from vtank.errors import InputError
from vtank.record import Manifest, Run, write_dataset


@pytest.fixture
def data(tmp_path: Path) -> Path:
    time_s = np.arange(30) * 0.1
    range_m = np.where(np.arange(30) % 2, np.nan, 3.0)
    runs = [Run(name, time_s, {"n_rev_s": np.sin(time_s), "range_m": range_m}) for name in ("run_1", "run_2")]
    write_dataset(tmp_path / "data", runs, Manifest(seed=3))
    return tmp_path / "data"


def test_version(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        cli.main(["--version"])
    assert caught.value.code == 0
    assert capsys.readouterr().out == f"vtank {vtank.__version__}\n"


def test_every_command_is_in_the_help(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["--help"])
    shown = capsys.readouterr().out
    for name in cli._modules():
        assert re.search(rf"^ +{name}\b", shown, re.MULTILINE)


def test_every_file_of_a_command_is_listed() -> None:
    files = {path.stem for path in Path(cli.__file__).parent.glob("*.py")} - {"__init__", "progress", "checks", "shown"}
    assert {file.replace("_", "-") for file in files} == set(cli._modules())


@pytest.mark.parametrize("arguments", [[], ["no-such-command"], ["check-data"], ["check-data", "a", "b"]])
def test_wrong_arguments_give_exit_code_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        cli.main(arguments)
    assert caught.value.code == 2
    assert "usage: vtank" in capsys.readouterr().err


def test_check_data_lists_every_channel_with_its_rate(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["check-data", str(data)]) == 0
    output = capsys.readouterr().out
    assert f"2 runs, written by vtank {vtank.__version__}, seed 3" in output
    rows = [line.split() for line in output.splitlines()]
    assert ["run_1", "n_rev_s", "input", "30", "10", "0", "2.9", "0", "0.99957"] in rows
    assert ["run_2", "range_m", "output", "15", "5", "0", "2.8", "3", "3"] in rows


def test_a_changed_run_is_told_and_still_used(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = data / "run_2.csv"
    path.write_text(path.read_text() + "3,0,3\n")
    assert cli.main(["check-data", str(data)]) == 0
    assert capsys.readouterr().err == f"vtank: warning: {path}: changed since the data set was written\n"


def test_bad_input_gives_one_line_and_exit_code_2(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = data / "run_1.csv"
    path.write_text(path.read_text().replace("\n", "\nx,", 1))
    assert cli.main(["check-data", str(data)]) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith(f"vtank: error: {path}, line 2: ")
    assert captured.err.count("\n") == 1


@pytest.mark.parametrize(
    ("raised", "code", "message"),
    [
        (InputError("a.toml: no key n_rev_s"), 2, "vtank: error: a.toml: no key n_rev_s\n"),
        (PermissionError(13, "Permission denied", "/a/b"), 2, "vtank: error: /a/b: Permission denied\n"),
        (OSError(28, "No space left"), 2, "vtank: error: standard output: No space left\n"),
        (OSError(11, "Try again"), 2, "vtank: error: the system: Try again\n"),
        (KeyboardInterrupt(), 130, "\nvtank: interrupted\n"),
    ],
)
def test_exit_codes(
    raised: BaseException, code: int, message: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(args: object) -> int:
        raise raised

    command = SimpleNamespace(add_parser=lambda subparsers: subparsers.add_parser("fail"), run=run)
    monkeypatch.setattr(cli, "_modules", lambda: {"fail": command})
    assert cli.main(["fail"]) == code
    assert capsys.readouterr().err == message


def test_a_law_that_does_not_compile_is_told_by_file_and_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "stiction.py"
    file.write_text("from vtank.compiled import law\n\n@law\ndef force(u):\n    return u.magnitude + 1.0\n")
    monkeypatch.syspath_prepend(tmp_path)

    def run(args: object) -> int:
        return int(importlib.import_module("stiction").force(1.0))

    command = SimpleNamespace(add_parser=lambda subparsers: subparsers.add_parser("fail"), run=run)
    monkeypatch.setattr(cli, "_modules", lambda: {"fail": command})
    assert cli.main(["fail"]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"vtank: error: {file}:5: does not compile: Unknown attribute 'magnitude' of type float64")
    assert told.count("\n") == 1


def test_a_reader_that_stops_early_is_no_error(data: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "vtank", "check-data", str(data)]
    with os.fdopen(writer, "w") as closed:
        done = subprocess.run(command, stdout=closed, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (141, "")


def test_a_command_computes_with_one_thread_of_linear_algebra() -> None:
    """Two threads add up in another order: the same command would print other last digits on another machine."""
    code = "import os, sys, vtank.cli; print('numpy' in sys.modules, os.environ['OPENBLAS_NUM_THREADS'])"
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    assert subprocess.check_output([sys.executable, "-c", code], text=True, env=environment) == "False 1\n"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_what_cannot_be_printed_is_told(data: Path) -> None:
    command = [sys.executable, "-m", "vtank", "check-data", str(data)]
    with open("/dev/full", "w") as full:
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (done.returncode, done.stderr) == (2, "vtank: error: standard output: No space left on device\n")


def test_a_file_whose_name_is_no_text_is_shown(data: Path, capsys: pytest.CaptureFixture[str]) -> None:
    os.rename(data / "run_2.csv", os.fsencode(data) + b"/run_\xff.csv")
    assert cli.main(["check-data", str(data)]) == 0
    assert "run_\\udcff" in capsys.readouterr().out
    os.rename(data, os.fsencode(data) + b"\xfe")
    out = data.parent / "found"
    assert cli.main(["identify", f"{data}\udcfe", "--model", "I", "--method", "ml", "--out", str(out)]) in (0, 2)
    assert "Traceback" not in capsys.readouterr().err


def test_a_terminated_command_clears_its_half_written_folder(tmp_path: Path) -> None:
    program = f"""
import sys, time
from types import SimpleNamespace
import vtank.cli as cli
from vtank.record.folder import new_folder
def run(args):
    with new_folder({str(tmp_path / "data")!r}):
        print("started", flush=True)
        time.sleep(60)
cli._modules = lambda: {{"wait": SimpleNamespace(add_parser=lambda sub: sub.add_parser("wait"), run=run)}}
sys.exit(cli.main(["wait"]))
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    with process.stdout:
        assert process.stdout.readline() == "started\n"
        assert len(list(tmp_path.iterdir())) == 1
        process.send_signal(signal.SIGTERM)
        assert process.wait(timeout=30) == 143
    assert list(tmp_path.iterdir()) == []


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_progress_on_a_terminal_tells_counts_and_the_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    for name, size in (("COLUMNS", "120"), ("LINES", "30")):
        monkeypatch.setenv(name, size)
    stream = Terminal()
    with progress("runs", 2, stream) as advance:
        advance("a long note")
        advance("b")
    shown = stream.getvalue().split("\r")
    assert shown[1].startswith("runs 0/2 |") and shown[1].rstrip().endswith("left")
    assert re.fullmatch(r"runs 2/2 \|\S{20}\| 00:0\d, 00:0\d left, b\s*", shown[-1])
    assert stream.getvalue().endswith("\n")


def test_progress_is_shown_on_a_terminal_that_does_not_tell_its_size() -> None:
    ours, theirs = pty.openpty()
    with os.fdopen(theirs, "w") as stream, progress("runs", 1, stream) as advance:
        advance("a")
        shown = b""
        while b"runs 1/1 |" not in shown and select([ours], [], [], 5.0)[0]:
            shown += os.read(ours, 4096)
    os.close(ours)
    assert b"runs 1/1 |" in shown


def test_what_is_being_done_is_told_and_wiped_on_a_terminal_and_listed_elsewhere() -> None:
    terminal, file = Terminal(), io.StringIO()
    for stream in (terminal, file):
        with progress(stream=stream) as say:
            say("where the gap lies")
            say("next experiment")
    assert "\rwhere the gap lies ... 00:0" in terminal.getvalue() and terminal.getvalue().endswith(" \r")
    assert file.getvalue() == "where the gap lies ...\nnext experiment ...\n"


def test_shares_are_counted_in_percent() -> None:
    stream = io.StringIO()
    with percent("flying", stream) as report:
        for share in (0.2, 0.999, 1.0):
            report(share)
    assert stream.getvalue() == "flying, percent 100/100 (0 s, 0 s left)\n"


def test_progress_is_sparing_elsewhere(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = iter(range(0, 1000, 4))
    monkeypatch.setattr(time, "monotonic", lambda: float(next(clock)))
    stream = io.StringIO()
    with progress("runs", 20, stream) as advance:
        for _ in range(20):
            advance("")
    lines = stream.getvalue().splitlines()
    assert 2 <= len(lines) < 12
    assert lines[-1].startswith("runs 20/20 (")


SLIPS = {  # command line -> what is said of the slip in it
    "diagnos data": "unknown 'diagnos'; did you mean 'diagnose'?",
    "run paper-ds1 --out d --sed 3": "unknown '--sed'; did you mean '--seed'?",
    "diagnose d --nominl x": "unknown '--nominl'; did you mean '--nominal'?",
    "campaign paper-nois --out d": "no campaign named 'paper-nois'; did you mean 'paper-noise'?",
    "run paper-ds5 --out d": "no scenario named 'paper-ds5'; did you mean 'paper-ds",
    "run whole/zigzg --out d": "no scenario named 'whole/zigzg'; did you mean 'whole/zigzag'?",
    "run paper-ds1 --set sonar.nois_m=0.1 --out d": "unknown key; did you mean 'noise_m'?",
    "run paper-ds1 --set excitation.kind=multisin --out d": "found 'multisin', did you mean 'multisine'?",
    "run paper-ds1 --set effects.linear_drg.c_per_s=1 --out d": "did you mean 'linear_drag'?",
    "run paper-ds1 --set effects.linear_drag.c_s=1 --out d": "expected 'c_per_s'",
    "run paper-ds1 --truth paper-iv --out d": "did you mean 'paper-ii",
    "run zigzag --out d": "no scenario named 'zigzag'; did you mean 'whole/zigzag'?",
    "run whole/zigzag --set walls=basn --out d": "zigzag.toml): no walls named 'basn'; did you mean 'basin'?",
    "run whole/zigzag --set excite[0].axis=yew --out d": "--set excite[0].axis (over ",
    "run whole/zigzag --set excite.7.axis=yaw --out d": "'excite' is an array; expected one of its parts: excite[0]",
    "run whole/zigzag --set excite.axis=yaw --out d": "'excite' is an array; expected one of its parts: excite[0]",
    "run whole/zigzag --set vehicle=bluerov --out d": "did you mean 'bluerov2'?",
    "effects linear_drg": "no effect 'linear_drg'; did you mean 'linear_drag'?",
    "blind make --trials 1 --seed 1 --effects linar_drag --out d": "did you mean 'linear_drag'?",
    "blind mak": "unknown 'mak'; did you mean 'make'?",
    "check-data mispelt.csv": "(No such file or directory); did you mean 'misspelt.csv'?",
    "check-data nowhere/near/it.csv": "(No such file or directory); there is no folder nowhere",
    "import lgo.csv --out d": "did you mean 'log.csv'?",
    "check-data misspelt.csv": "did you mean 'heading_rad'?",
    "import log.csv --map slip.toml --preview": "did you mean 'Drehzahl'?",
}


@pytest.mark.parametrize("line", SLIPS)
def test_a_slip_is_told_with_what_was_meant(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("misspelt.csv").write_text("time_s,port_command,headng_rad\n" + "".join(f"{k},0.1,0.2\n" for k in range(12)))
    Path("log.csv").write_text("t;Drehzahl\n" + "".join(f"{k};{k}\n" for k in range(12)))
    Path("slip.toml").write_text('[[channel]]\nmessage = "table"\nfield = "Drezahl"\ncolumn = "n_rev_s"\n')
    try:
        code: object = cli.main(line.split())
    except SystemExit as ended:
        code = ended.code
    assert code == 2 and SLIPS[line] in capsys.readouterr().err


@pytest.mark.parametrize(
    "line", ["run paper-ds1 --out loop", "run paper-ds1 --out loop/d", "import log.csv --out loop"]
)
def test_links_that_go_round_in_a_circle_are_told(
    line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("loop").symlink_to("loop")
    Path("log.csv").write_text("t;n_rev_s\n" + "".join(f"{k};{k}\n" for k in range(12)))
    assert cli.main(line.split()) == 2
    assert "its links go round in a circle" in capsys.readouterr().err


def test_a_way_to_draw_that_is_none_is_told() -> None:
    command = [sys.executable, "-m", "vtank", "run", "paper-ds1", "--out", "nowhere/d"]
    run = subprocess.run(command, capture_output=True, text=True, env=os.environ | {"MUJOCO_GL": "nonsense"})
    assert run.returncode == 2 and "MUJOCO_GL=nonsense: nothing here can draw by that" in run.stderr
    assert "Traceback" not in run.stderr


@pytest.mark.parametrize(
    ("option", "said"),
    [
        (["--depth", "nan"], "--depth nan: expected a number from 0 to 1e4 m"),
        (["--depth", "-5"], "--depth -5: expected a number from 0 to 1e4 m"),
        (["--walls", "nothere"], "--walls: no walls named 'nothere'; there are: basin, sea"),
    ],
)
def test_a_plan_that_cannot_be_is_refused_before_any_work(
    option: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["explore", str(tmp_path / "runs"), "--nominal", "bluerov2", *option]) == 2
    assert said in capsys.readouterr().err
