"""The table of all benchmarks, printed after the last of them."""

from __future__ import annotations

from collections.abc import Callable

import pytest

Row = tuple[str, str, str, str]
HEAD: Row = ("what", "reached", "beside", "bar")
ROWS: list[Row] = []


@pytest.fixture(scope="session")
def note() -> Callable[[str, str, str, str], None]:
    """Put a row into the table: what was measured, what was reached, beside what, and the bar."""
    return lambda *row: ROWS.append(row)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Print the table."""
    if not ROWS:
        return
    table = [HEAD, *ROWS]
    width = [max(len(row[i]) for row in table) for i in range(len(HEAD))]
    terminalreporter.section("side by side")
    for row in table:
        terminalreporter.write_line("  ".join(cell.ljust(w) for cell, w in zip(row, width, strict=True)).rstrip())
