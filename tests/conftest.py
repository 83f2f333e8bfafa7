"""Shared by all tests: the foreign recordings, a browser, and a skip where they are absent."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from browser import find_browser, overflow

REPOSITORY = Path(__file__).resolve().parents[1]
RECORDINGS = REPOSITORY.parent / "shared" / "data"


@pytest.fixture(scope="session")
def recordings() -> Path:
    """The folder of recordings made by others; it is not part of the repository."""
    if not RECORDINGS.is_dir():
        pytest.skip("the foreign recordings are not here")
    return RECORDINGS


@pytest.fixture(scope="session")
def browser() -> str:
    """A headless browser that starts."""
    found = find_browser()
    if found is None:
        pytest.skip("no headless browser here")
    return found


@pytest.fixture
def fits(tmp_path: Path) -> Callable[[Path], bool]:
    """Whether a page fits a window of 400 pixels and complains of nothing; true where there is no browser."""
    found = find_browser()
    return lambda page: found is None or overflow(found, tmp_path, page, 400) == (0, [])
