"""What the command prints, and where it cannot."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from vtank import cli
from vtank.cli import main
from vtank.experiment.allocation import Allocation
from vtank.plant import load_vehicle
from vtank.tank import load_whole

RED = "a\x1b[31m\nvtank: error: b"


def test_control_characters_of_names_and_headers_are_spelled(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Or they would colour a terminal, clear it, and pass for lines of vtank's own."""
    run = tmp_path / f"{RED}.csv"
    run.write_text("time_s,n_rev_s,range_m,\x1b[2Jmine\n" + "".join(f"{k},{k},{k + 1},1\n" for k in range(60)))
    assert main(["check-data", str(tmp_path)]) == 0
    said = capsys.readouterr()
    assert "\x1b" not in said.out + said.err and "a\\x1b[31m" in said.out
    run.write_text("time_s,n_rev_s\x1b[2J\n0,1\n")
    for command in (["check-data", str(run)], ["effects", RED]):
        try:
            assert main(command) == 2
        except SystemExit as wrong:  # the parser's
            assert wrong.code == 2
        said = capsys.readouterr()
        assert "\x1b" not in said.err and "\\x1b[31m\\nvtank: error: b" in said.err


def test_a_closed_output_is_no_fault() -> None:
    done = subprocess.run(["sh", "-c", f"{sys.executable} -m vtank effects >&-"], capture_output=True, check=False)
    assert done.returncode == 0 and done.stderr == b""


def test_an_interruption_while_commands_load_is_told(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "_modules", interrupted)
    assert main(["effects"]) == 130 and "interrupted" in capsys.readouterr().err


def test_nothing_is_asked_of_a_linear_algebra_that_takes_no_empty_matrices(monkeypatch: pytest.MonkeyPatch) -> None:
    """As that of scipy 1.13 does not: a rudder zigzag orders no axis."""
    vehicle = load_vehicle("remus100")
    monkeypatch.setattr("vtank.experiment.allocation.null_space", None)
    free = Allocation(vehicle, load_whole(vehicle).model, [])
    assert np.array_equal(free.matrix(1.0), np.zeros((len(free.parts), 6)))
