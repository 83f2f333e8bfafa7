"""The picture of a vehicle from above: every place by its name, none on another, and filled where an effect is."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree

import pytest

import vtank as vt
from vtank.present.vehicle_picture import LETTER, WIDTH, vehicle_picture


@pytest.mark.parametrize("name", ["phoenix", "bluerov2", "remus100", "kingfisher"])
def test_every_place_has_its_name_and_no_name_lies_on_another(name: str) -> None:
    vehicle = vt.load_vehicle(name)
    marks = ElementTree.fromstring(vehicle_picture(vehicle, {}))
    texts = [mark for mark in marks.iter() if mark.tag.endswith("text")]
    shown = ", ".join(str(text.text) for text in texts).split(", ")
    places = [*(t.name or t.site for t in vehicle.thrusters), *(f.name for f in vehicle.fins)]
    places += [s.name for s in vehicle.sensors]
    assert sorted(shown) == sorted([*(place.replace("_", " ") for place in places),
                                    *("surge", "sway", "heave", "roll", "pitch", "yaw", "vehicle")])  # fmt: skip
    boxes = [(float(t.get("x", "")), float(t.get("y", "")), LETTER * len(str(t.text))) for t in texts]
    assert all(x - wide / 2 >= -1.0 and x + wide / 2 <= WIDTH + 1.0 for x, _, wide in boxes)
    for k, (x, y, wide) in enumerate(boxes):
        assert not any(abs(x - a) < (wide + w) / 2 - 1.0 and abs(y - b) < 15.0 for a, b, w in boxes[:k])


def test_what_is_named_is_filled_and_told() -> None:
    svg = vehicle_picture(vt.load_vehicle("bluerov2"), {"thruster_4": 0.98, "yaw": 0.5})
    filled = re.findall(r'class="place" style="--lit:(0\.[1-9]\d)"', svg)
    assert filled == ["0.98", "0.25"] and "<title>thruster_4: 98 %</title>" in svg
    assert "thruster_4 98 %, yaw 50 %" in svg


def test_what_all_thrusters_have_in_common_fills_all_of_them() -> None:
    vehicle = vt.load_vehicle("bluerov2")
    svg = vehicle_picture(vehicle, {"thrusters": 0.97})
    assert all(f"<title>{t.name}: 97 %</title>" in svg for t in vehicle.thrusters if t.direction[2] == 0.0)
    assert "thrusters 97 %" in svg
