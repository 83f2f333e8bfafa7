"""The examples run as they are, in an empty folder, and say what they promise."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
SAID = {  # example -> words of its output, files it leaves
    "fly_and_identify": (("thrust_lag.tau", "truth 0.7074"), ("data/truth.json",)),
    "diagnose_and_correct": (("The gap is caused by linear drag.", "a run never seen"), ("gap.html", "gap.toml")),
    "own_log": (("thrust_lag.tau",), ("log.csv",)),
    "before_the_tank": (("no unbiased estimator gets below",), ("plan/identifiability.html",)),
    "campaign": (("8 runs", "linear drag 0."), ("many/runs.csv",)),
}


def test_all_examples_are_here_and_short() -> None:
    paths = sorted(EXAMPLES.glob("*.py"))
    assert {path.stem for path in paths} == set(SAID)
    assert all(len(path.read_text(encoding="utf-8").splitlines()) < 40 for path in paths)


@pytest.mark.parametrize("name", SAID)
def test_an_example_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    words, files = SAID[name]
    shown = capsys.readouterr().out
    assert all(word in shown for word in words), shown
    assert all((tmp_path / file).exists() for file in files)
