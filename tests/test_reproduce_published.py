"""The printed numbers: complete, consistent with themselves where not marked as doubtful, and tied to the truths."""

from __future__ import annotations

import numpy as np
import pytest

from vtank.plant.lumped import to_feet
from vtank.plant.truth import load_truth
from vtank.studies.paper.evidence import steady_speed
from vtank.studies.paper.published import PARAMETERS, RESIDUALS, SETS, brutzman_a_per_ft, published

DOUBTS = [(table.number, doubt) for table in published().values() for doubt in table.doubts]


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_each_table_has_four_data_sets_of_every_row(number):
    table = published()[number]
    rows = {"I": {"a", "b"}, "II": {"a", "b", "tau"}, "III": set(PARAMETERS)}[table.model] | set(RESIDUALS)
    assert set(table.quantities) == rows
    assert all(values.shape == (SETS,) for values in table.values.values())


@pytest.mark.parametrize(("number", "doubt"), DOUBTS)
def test_doubts_name_rows_and_data_sets_that_exist(number, doubt):
    assert set(doubt.quantities) <= {"q_ii", *published()[number].quantities}
    assert set(doubt.sets) <= {1, 2, 3, 4} and doubt.mark in "*?" and doubt.reason


def test_missing_numbers_are_explained():
    """Nothing is printed only where Model I diverged, where a value was lost, and for one q_ii."""
    missing = {
        (t.number, quantity, int(i) + 1)
        for t in published().values()
        for quantity, values in t.values.items()
        for i in np.flatnonzero(np.isnan(values))
    }
    diverged = {(1, quantity, i) for quantity in RESIDUALS for i in (2, 3)}
    assert missing == diverged | {(3, "a", 4), (4, "q_ii", 4)}


def test_mean_absolute_value_is_below_the_root_mean_square_unless_marked():
    """|e| cannot exceed rms e; the one cell that does must be marked."""
    impossible = set()
    for table in published().values():
        mean, deviation, absolute = (table.values[name] for name in RESIDUALS)
        for i in np.flatnonzero(absolute > np.hypot(mean, deviation) + 1e-4).tolist():
            impossible.add((table.number, i + 1))
            assert table.mark("mean_absolute", i + 1) == "?"
    assert impossible == {(3, 2)}


def test_second_stage_holds_b_over_tau_and_copies_data_set_2():
    one, two = published()[2].values, published()[4].values
    np.testing.assert_allclose(two["b"] / two["tau"], one["b"] / one["tau"], rtol=0.04)
    for quantity in ("a", "b", "tau", *RESIDUALS):
        assert one[quantity][1] == two[quantity][1]
        assert published()[4].mark(quantity, 2) == "?"


@pytest.mark.parametrize(("truth", "number"), [("paper-ii", 2), ("paper-iii", 3)])
def test_truth_presets_are_the_printed_data_set_1(truth, number):
    table = published()[number].values
    printed = [float(table[name][0]) if name in table else 0.0 for name in PARAMETERS]
    assert to_feet(load_truth(truth).lumped) == pytest.approx(printed, rel=1e-12)


def test_brutzmans_drag_is_that_of_the_physical_truth():
    assert brutzman_a_per_ft() == pytest.approx(to_feet(load_truth("physical").lumped)[0], rel=2e-3)


def test_steady_speed_balances_drag_thrust_and_loss():
    assert steady_speed(-0.5, 0.002, 0.0, 10.0) == pytest.approx(np.sqrt(0.002 / 0.5) * 10.0)
    u = steady_speed(-1.2, 0.013, -0.17, 11.0)
    assert u > 0.0 and -1.2 * u**2 - 0.17 * 11.0 * u + 0.013 * 121.0 == pytest.approx(0.0, abs=1e-12)
