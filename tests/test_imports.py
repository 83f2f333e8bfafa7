"""Imports point one way, heavy packages stay in few places, and the command starts without them."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from graphlib import TopologicalSorter
from importlib import import_module
from pathlib import Path

import pytest

import vtank

ROOT = Path(vtank.__file__).parent

# A module may import from its own layer and from the layers before it.
LAYERS = (
    "errors",
    "blas",
    "facade",
    "vtank",  # the version; the public names are loaded when they are used, and stand above
    "units",
    "compiled",
    "lanes",
    "resources",
    "effects",
    "record",
    "plant",
    "channels",
    "logs",
    "rigid",
    "waves",
    "water",
    "tank",
    "experiment",
    "gym",
    "estimate",
    "diagnose",
    "present",
    "diagnosed",
    "library",
    "viewed",
    "studies",
    "cli",
    "__main__",
)

# Heavy package -> the only modules that import it.
ALLOWED = {
    "mujoco": {"vtank.water", "vtank.tank", "vtank.gym"},
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
    facade = MODULES[module].name == "__init__.py"  # loads what it names for type checkers when that is used
    later = {node for lazy in tree.body if facade and isinstance(lazy, ast.If) for node in ast.walk(lazy)}
    for node in ast.walk(tree):
        if node in later:
            continue
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


# --- studies stand on public names, and what is private stays at home -------------------------------------------------
STUDIES = [module for module in MODULES if module.startswith("vtank.studies.")]


FACADES = [module for module, path in MODULES.items() if "\n__all__ = " in path.read_text(encoding="utf-8")]


def is_package(module: str) -> bool:
    return module in MODULES and MODULES[module].name == "__init__.py"


def is_effect(module: str) -> bool:
    """Whether a module is a file of the catalogue, which is public by being there."""
    return module in MODULES and hasattr(import_module(module), "EFFECT")


def is_public(base: str, name: str) -> bool:
    """Whether `from base import name` takes what a package shows, or something of a module that it shows."""
    parent, _, last = base.rpartition(".")
    if is_package(base):
        return name in import_module(base).__all__ or is_effect(f"{base}.{name}")
    return not name.startswith("_") and (parent == "vtank" or last in import_module(parent).__all__)


@pytest.mark.parametrize("module", STUDIES)
def test_studies_use_public_names(module: str) -> None:
    own = ".".join(module.split(".")[:3])
    found = []
    for node in ast.walk(ast.parse(MODULES[module].read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (base := absolute(module, node)).startswith("vtank"):
            within = base == own or base.startswith(f"{own}.") or base.count(".") == 2 and not is_package(base)
            found += [f"{base}.{a.name}" for a in node.names if not (within or is_public(base, a.name))]
    assert not found, f"{module} imports {', '.join(found)}, which no package shows in its __all__"


def test_what_is_not_shown_is_not_public() -> None:
    assert is_public("vtank.estimate", "Problem") and is_public("vtank.experiment.flight", "ticks")
    assert not is_public("vtank.estimate", "Filter") and not is_public("vtank.estimate.problem", "Problem")
    assert not is_public("vtank.estimate", "_inverse")


@pytest.mark.parametrize("package", FACADES)
def test_every_name_that_a_package_shows_is_there(package: str) -> None:
    shown = import_module(package)
    for name in shown.__all__:
        assert getattr(shown, name) is not None
        assert name in dir(shown)


@pytest.mark.parametrize("module", MODULES)
def test_private_names_stay_in_their_module(module: str) -> None:
    tree = ast.parse(MODULES[module].read_text(encoding="utf-8"))
    nodes = list(ast.walk(tree))
    own = {node.name for node in nodes if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    own |= {node.attr for node in nodes if isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store)}
    own |= {node.target.id for node in nodes if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)}
    # of Python and of MuJoCo, which show no other way
    foreign = (
        "argparse._SubParsersAction",
        "os._exit",
        "._address",
    )
    used = {node.attr for node in nodes if isinstance(node, ast.Attribute) and not ast.unparse(node).endswith(foreign)}
    used |= {a.name for node in nodes if isinstance(node, ast.ImportFrom) for a in node.names}
    private = {name for name in used - own if name.startswith("_") and not name.startswith("__")}
    assert not private


MOST_ARGUMENTS = 8  # by position; more are given by name
COMPILED = {"law", "lean", "term"}  # decorators of kernels, which pass arrays and numbers and nothing else
MADE = {"kalman", "simulate", "step", "with_forces"}  # kernels that are made for each plant
IN_C = {"ray"}  # MuJoCo's functions, which take no names


@pytest.mark.parametrize("module", MODULES)
def test_long_calls_name_their_arguments(module: str) -> None:
    compiled = {name for path in MODULES for name in laws(path)}
    calls = [n for n in ast.walk(ast.parse(MODULES[module].read_text(encoding="utf-8"))) if isinstance(n, ast.Call)]
    long = {ast.unparse(n.func).split(".")[-1] for n in calls if len(n.args) > MOST_ARGUMENTS}
    assert not long - compiled - MADE - IN_C


@cache
def laws(module: str) -> frozenset[str]:
    """Functions of a module that numba compiles."""
    tree = ast.parse(MODULES[module].read_text(encoding="utf-8"))
    functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    decorators = {f.name: {ast.unparse(d).split("(")[0] for d in f.decorator_list} for f in functions}
    return frozenset(name for name, found in decorators.items() if found & COMPILED)
