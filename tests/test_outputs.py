"""What is written never takes the place of what is read, whatever the command and however the two are named."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.record import Manifest, Run, write_dataset
from vtank.resources import scenarios_dir

COMMANDS = (
    "diagnose data --json data/run_1.csv",
    "diagnose data/run_1.csv --report data/run_1.csv",
    "diagnose data --nominal v.toml --model v.toml",
    "diagnose data --against other --json other/run_1.csv",
    "diagnose data --nominal v.toml --json hull.xml",
    "predict m.toml data/run_1.csv --json data/run_1.csv",
    "predict m.toml data/run_1.csv --json ./m.toml",
    "identify data --json data/run_1.csv",
    "identify data --json data/manifest.json",
    "identify data --json link.csv",
    "identify data --json hard.csv",
    "identify linked --json data/run_1.csv",
    "identify data --truth t.json --json t.json",
    "identify data --nominal v.toml --json v.toml",
    "import log.csv --out log.csv",
    "import log.csv --map m.toml --out m.toml",
    "import log.csv --vehicle v.toml --out v.toml",
    "import log.csv --vehicle v.toml --out curve.csv",
    "import other/log.csv --out other/log.csv",
    "blind answer cases --out cases/cases.json",
    "blind answer cases --out cases/case_0001/run_1.csv",
    "view data/run_1.csv --film data/run_1.csv",
    "explore data --nominal v.toml --write-plan v.toml",
    "run s.toml --set vehicle=v.toml --out set",
    "run set/s.toml --out set",
    "campaign set/s.toml --out set",
    "identifiability s.toml --json s.toml",
)
FILES = ("data/run_1.csv", "data/manifest.json", "other/run_1.csv", "other/log.csv", "v.toml", "hull.xml", "curve.csv",
         "m.toml", "t.json", "log.csv", "cases/cases.json", "cases/case_0001/run_1.csv", "s.toml",
         "set/s.toml")  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS)
def test_what_is_read_is_not_overwritten(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in FILES:
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text('mjcf = "hull.xml"\ncurve = "curve.csv"\n' if name == "v.toml" else "")
    Path("link.csv").symlink_to("data/run_1.csv")
    os.link("data/run_1.csv", "hard.csv")
    Path("linked").symlink_to("data")
    before = {name: Path(name).read_bytes() for name in FILES}
    found = main(command.split())
    said = capsys.readouterr().err
    assert found == 2 and said.count("\n") == 1
    assert {name: Path(name).read_bytes() for name in FILES} == before
    assert "input" in said or command.startswith(("run", "campaign"))


def test_what_was_written_before_is_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Findings may lie beside the recordings, and be written again."""
    run, out = tmp_path / "run.csv", tmp_path / "found.json"
    run.write_text("time_s,n_rev_s,range_m\n" + "".join(f"{0.1 * k:g},{k % 7},{3 - 0.01 * k:g}\n" for k in range(99)))
    for _ in range(2):
        assert main(["identify", str(tmp_path), "--model", "I", "--method", "ml", "--json", str(out)]) == 0
    capsys.readouterr()
    assert out.is_file()


@pytest.mark.parametrize(
    "command", ["run .hid.toml --out out", "run .whole.toml --out out", "import .log.csv log.csv --out out"]
)
def test_no_run_is_written_that_would_be_hidden(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, scenario in ((".hid.toml", "paper-ds1.toml"), (".whole.toml", "whole/zigzag.toml")):
        Path(name).write_bytes((scenarios_dir() / scenario).read_bytes())
    assert main(command.split()) == 2
    assert "expected a name without a dot first" in capsys.readouterr().err
    assert not Path("out").exists()
    with pytest.raises(InputError, match="hidden file"):
        write_dataset("out", [Run(".hid", np.arange(2.0), {"n_rev_s": np.ones(2)})], Manifest.__new__(Manifest))
