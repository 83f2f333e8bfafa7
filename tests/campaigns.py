"""Shared by the tests of campaigns: small campaigns, and the bytes that they leave."""

from __future__ import annotations

import hashlib
import os
import time
from pathlib import Path

from vtank.studies.campaign import Campaign, load_campaign

# 18 runs of 12 s: two scenarios, one of three amplitudes leads into the wall, drag and noise differ from run to run
SURGE = """
model = "surge"
seed = 11
repeats = 3

[grid]
duration_s = 12.0
scenario = ["paper-ds1", "chirp"]
excitation.amplitude_m = [0.2, 0.4, 4.0]

[draw]
sonar.noise_m = { uniform = [0.001, 0.01] }
effects.linear_drag.c_per_s = { log_uniform = [0.001, 0.1] }
"""


def write_campaign(folder: Path, text: str = SURGE, name: str = "small") -> Path:
    """The campaign as a file."""
    path = folder / f"{name}.toml"
    path.write_text(text)
    return path


def campaign_of(folder: Path, text: str = SURGE) -> Campaign:
    """The campaign with this text."""
    return load_campaign(write_campaign(folder, text))


def note_and_sleep(path: str) -> None:
    """Write the number of this process into a file, and stay."""
    Path(path).write_text(str(os.getpid()))
    time.sleep(60.0)


def digests(folder: Path) -> dict[str, str]:
    """SHA-256 of every file in a folder, by its path there."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
