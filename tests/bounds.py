"""Constraints for pip: `oldest`, the oldest versions that pyproject.toml allows, or `newest`, which are none."""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

BOUND = re.compile(r"([\w-]+)>=([\d.]+)")


def oldest(pyproject: Path) -> Iterator[str]:
    """name==version of each dependency that has a lower bound, those of the extras among them."""
    project = tomllib.loads(pyproject.read_text(encoding="utf-8"))["project"]
    extras = [needed for name, needed in project["optional-dependencies"].items() if name not in ("dev", "test")]
    for requirement in [*project["dependencies"], *(one for extra in extras for one in extra)]:
        found = BOUND.match(requirement)
        assert found, f"{requirement}: expected a lower bound"
        yield f"{found[1]}=={found[2]}"


if __name__ == "__main__" and sys.argv[1] == "oldest":
    print("\n".join(oldest(Path(__file__).parents[1] / "pyproject.toml")))
