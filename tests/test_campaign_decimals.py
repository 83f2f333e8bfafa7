"""The compiled CSV text of a run against Python's own, which rounds exactly."""

from __future__ import annotations

from decimal import ROUND_HALF_EVEN, Decimal

import numpy as np
import pytest

from vtank.record import Run
from vtank.record.reader import read_run
from vtank.record.writer import run_bytes
from vtank.studies.campaign.decimals import csv_of, nearest_step, table_of


def exact(value: float) -> int:
    """The nearest millionth of the binary number itself, ties to even."""
    return int((Decimal(value) * 1_000_000).to_integral_value(ROUND_HALF_EVEN))


def test_rounding_is_exact_beside_ties() -> None:
    """Halves of a millionth and their neighbours, where a rounded product goes wrong."""
    halves = (np.arange(-4000, 4000) + 0.5) * 1e-6
    values = np.concatenate([halves, np.nextafter(halves, 9.0), np.nextafter(halves, -9.0), halves + 3.0, halves * 1e8])
    assert [nearest_step(value, 1e6) for value in values] == [exact(value) for value in values]
    naive = np.rint(values * 1e6)
    assert any(rounded != exact(value) for rounded, value in zip(naive, values, strict=True))  # the case is not idle


def test_rounding_is_exact_on_numbers_of_all_sizes() -> None:
    random = np.random.default_rng(1)
    values = random.choice([-1.0, 1.0], 20_000) * 10.0 ** random.uniform(-9.0, 9.0, 20_000)
    assert [nearest_step(value, 1e6) for value in values] == [exact(value) for value in values]


def noisy_run(size: float) -> Run:
    random = np.random.default_rng(2)
    time = np.arange(400) * 0.1
    columns = {"thrust_N": random.normal(size=400), "load_N": size * random.normal(size=400)}
    columns["position_m"] = np.round(random.normal(size=400), 2)
    columns["position_m"][::3] = np.nan
    columns["position_m"][1:40:3] = [0.0, -0.0, -1e-9, 1e-7, 5e-7, -5e-7, 1.0, -1.0, 10.0, 100.25, 0.5, -0.000001, 7e5]
    return Run("noisy", time, columns)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e8, 1e11])
def test_the_bytes_are_those_of_the_record(size: float) -> None:
    """Also beyond the size that the compiled text can hold."""
    run = noisy_run(size)
    assert csv_of(run) == run_bytes(run)


def test_the_table_holds_what_a_reader_of_the_csv_gets(tmp_path) -> None:  # type: ignore[no-untyped-def]
    run = noisy_run(20.0)
    (tmp_path / "noisy.csv").write_bytes(csv_of(run))
    read = read_run(tmp_path / "noisy.csv")
    expected = np.array([read.time_s, *read.columns.values()])
    np.testing.assert_array_equal(table_of(run), expected)
