"""Imports point one way, heavy packages stay in few places, and the command starts without them."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import vtank

ROOT = Path(vtank.__file__).parent

# A module may import from its own layer and from the layers before it.
LAYERS = (
    "vtank",  # the version
    "errors",
    "units",
    "compiled",
    "lanes",
    "resources",
    "effects",
    "record",
    "plant",
    "channels",
    "waves",
    "tank",
    "experiment",
    "estimate",
    "diagnose",
    "present",
    "studies",
    "cli",
    "__main__",
)

# Heavy package -> the only modules that import it.
ALLOWED = {
    "mujoco": {"vtank.tank"},
    "filterpy": {"vtank.estimate"},
    "matplotlib": {
        "vtank.tank.drawing",
        "vtank.present",
    },
}


def module_name(path: Path) -> str:
    parts = ("vtank", *path.relative_to(ROOT).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_name(path): path for path in sorted(ROOT.rglob("*.py"))}


@cache
def imports(module: str) -> frozenset[str]:
    """Everything a module imports anywhere in it, also inside functions, as absolute dotted names."""
    tree = ast.parse(MODULES[module].read_text(encoding="utf-8"))
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = absolute(module, node)
            found |= {f"{base}.{alias.name}" if f"{base}.{alias.name}" in MODULES else base for alias in node.names}
    return frozenset(found)


def absolute(module: str, node: ast.ImportFrom) -> str:
    """The dotted name that `from ..x import y` refers to."""
    if not node.level:
        return node.module or ""
    package = module.split(".") if MODULES[module].name == "__init__.py" else module.split(".")[:-1]
    parents = package[: len(package) - node.level + 1]
    return ".".join([*parents, *([node.module] if node.module else [])])


def layer(module: str) -> int:
    parts = module.split(".")
    name = parts[1] if len(parts) > 1 else parts[0]
    assert name in LAYERS, f"{module}: say in LAYERS where it belongs"
    return LAYERS.index(name)


@pytest.mark.parametrize("module", MODULES)
def test_imports_point_downward(module: str) -> None:
    upward = [name for name in imports(module) if name.split(".")[0] == "vtank" and layer(name) > layer(module)]
    assert not upward, f"{module} imports {', '.join(upward)}, which belong above it"


def test_there_is_no_cycle() -> None:
    graph = {module: {name for name in imports(module) if name in MODULES} for module in MODULES}
    assert len(list(TopologicalSorter(graph).static_order())) == len(MODULES)


@pytest.mark.parametrize("package", ALLOWED)
def test_heavy_packages_are_imported_in_few_places(package: str) -> None:
    users = {module for module in MODULES if any(name.split(".")[0] == package for name in imports(module))}
    strangers = {user for user in users if not any((user + ".").startswith(place + ".") for place in ALLOWED[package])}
    assert not strangers, f"{package} is imported in {', '.join(sorted(strangers))}"


def test_relative_and_absolute_imports_are_both_seen() -> None:
    assert "vtank.errors" in imports("vtank.record.reader")
    assert "vtank.record.run" in imports("vtank.record.reader")
    assert "vtank.cli" in imports("vtank.__main__")


def test_help_starts_without_the_heavy_packages() -> None:
    code = "import sys\ntry: from vtank.cli import main; main(['--help'])\nexcept SystemExit: print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert "vtank.cli" in loaded
    assert not {"numba", "mujoco", "scipy", "filterpy", "matplotlib", "numpy"} & set(loaded)
