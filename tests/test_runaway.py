"""A simulation that runs away ends with its name, the reason and the last good time, and leaves nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from vtank.cli import main

TRUTH = """name = "runaway"
source = "by hand"
n_limit_rev_s = 20.0
[lumped]
alpha_per_m = -1e12
beta_m_per_rev2 = 5e-4
gamma_per_rev = 0.0
tau_s = 0.7
"""


@pytest.mark.parametrize("model", ["surge", "tank"])
def test_a_run_that_diverges_is_named_with_its_last_good_time(
    model: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "runaway.toml").write_text(TRUTH)
    monkeypatch.chdir(tmp_path)
    short = ["--set", "duration_s=6", "--model", model, "--out", "out"]
    assert main(["run", "open-loop-sine", "open-loop-sine", "--truth", "runaway.toml", *short]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert "open-loop-sine.toml: run open-loop-sine-1: " in said and "diverged after 0" in said
    assert said.endswith(("parameters or inputs are out of range", "is too long for them"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["runaway.toml"]


def test_a_truth_at_which_nothing_moves_bounds_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = TRUTH.replace("-1e12", "-1e11").replace("5e-4", "1e-11").replace("0.7", "1e-9")
    (tmp_path / "still.toml").write_text(text)
    assert main(["identifiability", "paper-ds1", "--seeds", "0", "--truth", str(tmp_path / "still.toml")]) == 2
    assert "the plan tells nothing of alpha" in capsys.readouterr().err
