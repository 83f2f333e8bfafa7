"""What drives a run: when its inputs change, and when those before were told last."""

from __future__ import annotations

import numpy as np
import pytest

import vtank as vt
from vtank.record.run import Run
from vtank.rigid.driven import EVENTS_S, Driven, driven
from vtank.rigid.layout import Layout
from vtank.rigid.push import pushes
from vtank.rigid.recordings import record

CRAFT = vt.load_vehicle("kingfisher")


def of(time_s: list[float], port: list[float]) -> Driven:
    columns = {"port_command": np.array(port), "starboard_command": np.zeros(len(port))}
    layout = Layout(CRAFT, pushes(CRAFT, list(columns)), (), ())
    return driven(Run("run", np.array(time_s), columns), layout)


def test_an_input_is_told_of_again_before_it_changes() -> None:
    found = of([0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6], [0.0, 0.0, 0.0, 0.5, 0.7, 0.7, 0.2])
    np.testing.assert_allclose(found.stamps, [0.0, 0.3, 0.4, 0.6])
    stamps, inputs, angles = found.told()
    np.testing.assert_allclose(stamps, [0.0, 0.2, 0.3, 0.4, 0.5, 0.6])
    np.testing.assert_allclose(inputs[:, 0], [0.0, 0.0, 0.5, 0.7, 0.7, 0.2])
    assert angles.shape == (6, len(CRAFT.fins)) and found.tick_s == pytest.approx(0.1)


@pytest.mark.parametrize("time_s, tick_s", [([0.0, 4.0, 9.0], EVENTS_S), ([0.0], 0.0)])
def test_a_log_of_events_has_no_instants(time_s: list[float], tick_s: float) -> None:
    found = of(time_s, [0.1 * k for k in range(len(time_s))])
    np.testing.assert_allclose(found.told()[0], time_s)
    assert found.tick_s == pytest.approx(tick_s)


def test_rows_without_an_input_are_none() -> None:
    rows = np.linspace(0.0, 20.0, 401)
    command = np.where(np.arange(401) % 4 == 0, np.sin(rows), np.nan)
    columns = {"port_command": command, "starboard_command": command, "compass.heading_rad": 0.1 * rows}
    _, (seen,), _ = record([Run("run", rows, columns)], CRAFT)
    assert seen.tick_s == pytest.approx(0.2) and seen.stamps.size == 101
