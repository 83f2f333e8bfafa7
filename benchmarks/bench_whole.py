"""The diagnosis of a whole vehicle: five minutes of a BlueROV2 at 10 Hz, nineteen columns, eight thrusters.

One of them lacks part of its force. By the clock, in processor time over that of scipy's fit (peers.py), and in memory.

    make bench
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from time import process_time

import pytest
from bench_diagnosis import shell
from peers import START, four_runs, scipy_fit

import vtank as vt

WANTED_S = 20.0  # by the clock, on two idle cores
SETTINGS = (
    "vehicle=bluerov2", "duration_s=300", 'effects."thruster_dead@thruster_1".share=0.3', "sensor.imu.rate_hz=10",
    "sensor.dvl.rate_hz=10", "sensor.mocap.rate_hz=10",
)  # fmt: skip


@pytest.fixture(scope="module")
def flight(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole") / "zigzag"
    vt.run("whole/zigzag", settings=SETTINGS, seed=3, out=folder)
    return folder


def test_five_minutes_of_a_whole_vehicle(flight: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The second of two, lest the first compiles."""
    out = flight.parent / "gap.json"
    for _ in range(2):
        seconds, processor, peak = shell("diagnose", flight, "--nominal", "bluerov2", "--json", out)
    runs = four_runs()
    scipy_fit(runs, START)
    begin = process_time()
    scipy_fit(runs, START)
    fits = processor / (process_time() - begin)
    verdict = json.loads(out.read_text(encoding="utf-8"))["verdict"]
    assert verdict["places"] == ["thruster_1"]
    with capsys.disabled():
        print(f"\nwhole vehicle, 300 s at 10 Hz: {seconds:.1f} s (wanted {WANTED_S:g}), processor {processor:.1f} s, "
              f"{fits:.0f} fits of scipy, {peak:.0f} MB", file=sys.stderr)  # fmt: skip
