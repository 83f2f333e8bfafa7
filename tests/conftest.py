"""Shared by all tests: where the foreign recordings lie, and a skip where they are absent."""

from __future__ import annotations

from pathlib import Path

import pytest

REPOSITORY = Path(__file__).resolve().parents[1]
RECORDINGS = REPOSITORY.parent / "shared" / "data"


@pytest.fixture(scope="session")
def recordings() -> Path:
    """The folder of recordings made by others; it is not part of the repository."""
    if not RECORDINGS.is_dir():
        pytest.skip("the foreign recordings are not here")
    return RECORDINGS
