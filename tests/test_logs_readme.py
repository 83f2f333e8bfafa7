"""What the README says of one's own log works as it is written."""

from __future__ import annotations

import shlex
from pathlib import Path

import logfiles
import numpy as np
import pytest

from vtank.cli import main
from vtank.record import read_run

README = Path(__file__).parents[1] / "README.md"


def test_the_section_on_ones_own_log_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    section = README.read_text(encoding="utf-8").split("## My own log\n")[1].split("\n## ")[0]
    code = [line.removeprefix("    ") for line in section.splitlines() if line.startswith("    ")]
    commands = [shlex.split(line.partition("#")[0])[1:] for line in code if line.startswith("vtank ")]
    mapping = code[next(k for k, line in enumerate(code) if line.startswith("preset")) :]
    assert len(commands) == 2 and len(code) <= 10
    logfiles.dataflash(tmp_path / "dive.BIN")
    logfiles.bag2(tmp_path / "bag")
    (tmp_path / "thrusters.toml").write_text("\n".join(mapping))
    for command in commands:
        assert main(command) == 0
    logfiles.check(read_run(tmp_path / "dive.csv"), ("thruster_1_command", "depth_m"), 2e-4)
    assert main([*commands[1][:-1], "--out", "bag.csv"]) == 0
    run = read_run(tmp_path / "bag.csv")
    assert np.allclose(run.samples("port_rev_s")[1], 10.0 * logfiles.COMMAND) and "surge_m_s" in run.columns
