"""`vtank blind make` interrupted: the same command takes up the cases that were made, and mixes them with no others."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from campaigns import digests

import vtank.studies.blind.kept as keeping
import vtank.studies.blind.make as making
import vtank.studies.blind.seal as seal
from vtank.cli import main
from vtank.errors import InputError
from vtank.record import Run
from vtank.studies.blind.make import Made, Order, make
from vtank.studies.blind.seal import EPOCH_S

ORDER = Order(4, 48, ("none", "parameters", "single"), ("supply_sag",), familiar=True, threads=1)


def nothing_flown(order: Order, frequencies: Any, number: int) -> Made:
    """A case that can be told from others by its number and seed."""
    run = Run(
        "run", 0.1 * np.arange(9), {"n_rev_s": np.full(9, float(order.seed)), "range_m": np.full(9, 1.0 + number)}
    )
    return Made([run, run], [run], {"kind": "none", "number": number}, "paper-ii", ())


def interrupted(monkeypatch: pytest.MonkeyPatch, at: int) -> list[int]:
    """Numbers of the cases that are begun from now on; the one that comes `at` that place is interrupted."""
    numbers: list[int] = []

    def made(order: Order, frequencies: Any, number: int) -> Made:
        numbers.append(number)
        if len(numbers) == at + 1:
            raise KeyboardInterrupt
        return nothing_flown(order, frequencies, number)

    monkeypatch.setattr(making, "_made", made)
    return numbers


def salted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Salts in an order that is known, from the first."""
    monkeypatch.setattr(seal, "new_salt", partial(next, (f"{k:064x}" for k in range(100))))


def test_the_same_command_makes_the_bytes_of_a_go_that_was_not_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cases that are flown: test_same_bytes.py."""
    one, two = tmp_path / "one", tmp_path / "two"
    numbers = interrupted(monkeypatch, at=99)
    salted(monkeypatch)
    make(ORDER, one / "cases", one / "truth")
    assert numbers == [0, 1, 2, 3]
    numbers = interrupted(monkeypatch, at=2)
    salted(monkeypatch)
    with pytest.raises(KeyboardInterrupt):
        make(ORDER, two / "cases", two / "truth")
    assert [path.name for path in two.iterdir()] == [".truth.vtank.cases"]
    assert (two / ".truth.vtank.cases").stat().st_mode & 0o077 == 0  # holds truths: for nobody else to read
    make(ORDER, two / "cases", two / "truth")
    assert numbers == [0, 1, 2, 2, 3]  # none that was made is flown again
    assert digests(one) == digests(two) and len(digests(one)) == 19
    assert {path.stat().st_mtime for folder in two.iterdir() for path in folder.rglob("*")} == {EPOCH_S}
    modes = [[path.stat().st_mode for path in sorted(folder.rglob("*"))] for folder in (one, two)]
    assert modes[0] == modes[1]


@pytest.fixture
def begun(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Numbers of cases; `tmp_path` holds two of them, of a go that was interrupted."""
    numbers = interrupted(monkeypatch, at=2)
    with pytest.raises(KeyboardInterrupt):
        make(ORDER, tmp_path / "cases", tmp_path / "truth")
    numbers.clear()
    return interrupted(monkeypatch, at=99)


@pytest.mark.parametrize("other", [{"seed": 49}, {"familiar": False}, {"kinds": ("none",)}, {"separations": False}])
def test_cases_of_another_order_are_neither_mixed_in_nor_lost(
    other: dict[str, Any], begun: list[int], tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=r"\.truth\.vtank\.cases: holds cases of another seed"):
        make(replace(ORDER, **other), tmp_path / "cases", tmp_path / "truth")
    make(ORDER, tmp_path / "cases", tmp_path / "truth")
    assert begun == [2, 3]


@pytest.mark.parametrize("name", ["current_versions", "sources"])
def test_cases_of_another_version_are_not_mixed_in(
    name: str, begun: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping, name, lambda: {"vtank": "0"})
    with pytest.raises(InputError, match="or another version, whose making was interrupted"):
        make(ORDER, tmp_path / "cases", tmp_path / "truth")
    make(ORDER, tmp_path / "cases", tmp_path / "elsewhere")
    assert begun == [0, 1, 2, 3]


def test_more_cases_or_threads_take_up_what_is_kept(begun: list[int], tmp_path: Path) -> None:
    make(replace(ORDER, trials=3), tmp_path / "cases", tmp_path / "truth")
    assert begun == [2]
    assert json.loads((tmp_path / "truth" / "seal.json").read_text())["order"]["trials"] == 3
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cases", "truth"]


@pytest.mark.parametrize("spoil", ["page.json", "cases/case_0001/run_2.csv", "sealed/case_0001.json"])
def test_a_case_that_was_changed_is_made_again(spoil: str, begun: list[int], tmp_path: Path) -> None:
    path = tmp_path / ".truth.vtank.cases" / "case_0001" / spoil
    path.write_bytes(path.read_bytes()[:-9] + b"7")
    make(ORDER, tmp_path / "cases", tmp_path / "truth")
    assert begun == [0, 2, 3]


def test_two_do_not_make_the_same_cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def second(order: Order, frequencies: Any, number: int) -> Made:
        with pytest.raises(InputError, match="another process makes cases for it"):
            make(ORDER, tmp_path / "other", tmp_path / "truth")
        return nothing_flown(order, frequencies, number)

    monkeypatch.setattr(making, "_made", second)
    make(ORDER, tmp_path / "cases", tmp_path / "truth")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["cases", "truth"]


def test_a_go_that_kept_nothing_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    interrupted(monkeypatch, at=0)
    with pytest.raises(KeyboardInterrupt):
        make(ORDER, tmp_path / "cases", tmp_path / "new" / "truth")
    assert not list(tmp_path.iterdir())


def test_an_interrupted_command_says_that_it_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    interrupted(monkeypatch, at=1)
    command = ["blind", "make", "--trials", "2", "--seed", "1", "--threads", "1", "--out", str(tmp_path / "cases")]
    assert main(command) == 130
    assert "cases: unfinished; the same command goes on from here" in capsys.readouterr().err
    assert main(command) == 0
