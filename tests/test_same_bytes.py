"""The same seed gives the same bytes, whoever computes and with however many threads.

Of `vtank run` and campaigns: test_simulate_command.py, test_campaign_executors.py and test_campaign_cluster.py.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from fuzz import taken

import vtank.studies.blind.make as making
from vtank.cli import main

TRIALS = "blind make --trials 2 --seed 11 --familiar --no-separations --kinds none single --effects linear_drag"
FLY = making._made


@pytest.mark.slow
def test_sealed_trials_are_the_same_on_one_and_two_threads_interrupted_or_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    command = [*TRIALS.split(), "--threads"]
    assert main([*command, "1", "--out", str(tmp_path / "1")]) == 0
    with monkeypatch.context() as patch:
        patch.setattr(making, "_made", first_only)
        assert main([*command, "1", "--out", str(tmp_path / "2")]) == 130
    assert main([*command, "2", "--out", str(tmp_path / "2")]) == 0
    one, two = (taken(tmp_path / threads) | taken(tmp_path / f"{threads}-truth") for threads in ("1", "2"))
    assert one.keys() == two.keys() and sum(name.endswith(".csv") for name in one) > 3
    for name in one:  # salts are secret, and new every time; what depends on them differs
        assert unsalted(one[name]) == unsalted(two[name]), name


def first_only(order: making.Order, frequencies: Any, number: int) -> making.Made:
    """The first case; the second is interrupted."""
    if number:
        raise KeyboardInterrupt
    return FLY(order, frequencies, number)


def unsalted(text: str) -> str:
    """A file without salts, hashes and the number of threads, which the order states."""
    return re.sub(r'"[0-9a-f]{32,64}"|"threads": \d', "", text)


@pytest.mark.slow
def test_a_diagnosis_is_the_same_in_any_process(tmp_path: Path) -> None:
    """Other hashes of strings, threads of linear algebra and of numba, locale and time zone."""
    settings = ["--set", "effects.linear_drag.c_per_s=0.15", "--set", "duration_s=40"]
    assert main(["run", "paper-ds1", "paper-ds4", "--model", "surge", *settings, "--out", str(tmp_path / "data")]) == 0
    others = {
        "one": {"PYTHONHASHSEED": "1", "NUMBA_NUM_THREADS": "1", "LC_ALL": "C", "TZ": "UTC"},
        "two": {"PYTHONHASHSEED": "2", "NUMBA_NUM_THREADS": "2", "LC_ALL": "C.UTF-8", "TZ": "Asia/Tokyo"},
    }
    made = []
    for name, environment in others.items():
        (tmp_path / name).mkdir()
        command = [sys.executable, "-m", "vtank", "diagnose", "../data", "--nominal", "paper-ii", "--json", "gap.json"]
        done = subprocess.run(
            [*command, "--model", "gap.toml", "--report", "gap.html"],
            cwd=tmp_path / name, env=os.environ | environment, capture_output=True, text=True, check=True,
        )  # fmt: skip
        made.append((done.stdout, taken(tmp_path / name)))
    assert made[0] == made[1] and set(made[0][1]) == {"gap.json", "gap.toml", "gap.html"}
