"""Machine code never outlives what it was made from: a changed law, or a constant that is baked into it."""

from __future__ import annotations

import ast
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import vtank

PACKAGE = Path(vtank.__file__).parent
SLOWED = """
from vtank.plant.parameters import vector
from vtank.plant.surge import SURGE
p, laws = vector({"linear_drag.c": 0.5}), SURGE.laws
print(1.0 - laws["advance"](0.0, 0.01, (0.0, 1.0, 0.0, 0.0), (0.0,), (0.0,), laws["fades"](0.01, p), p)[1])
"""  # speed lost in 10 ms, by an equation of motion that calls the law of linear drag from another file


def imported(tree: ast.Module, path: Path) -> dict[str, Path]:
    """Name -> folder of this package from which a file has it."""
    found = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level:
            home = path.parents[node.level - 1] / (node.module or "").replace(".", "/")
            found |= {a.asname or a.name: home if home.is_dir() else home.parent for a in node.names}
    return found


def names_in(node: ast.AST) -> set[str]:
    return {name.id for name in ast.walk(node) if isinstance(name, ast.Name)}


def frozen(tree: ast.Module) -> set[str]:
    """Names that compiled functions of a file use, and those that their constants are made of."""
    laws = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    laws = [node for node in laws if {"law", "term"} & {n for d in node.decorator_list for n in names_in(d)}]
    used = {name for law in laws for name in names_in(law)}
    made = [node for node in tree.body if isinstance(node, ast.Assign | ast.AnnAssign)]
    for node in made:
        targets = node.targets if isinstance(node, ast.Assign) else [node.target]
        if node.value is not None and used & {name for target in targets for name in names_in(target)}:
            used |= names_in(node.value)
    return used


def uncovered() -> Iterator[str]:
    """What machine code would keep although its source has changed."""
    sources = {path: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    covered = {path.parent for path, text in sources.items() if "compiled import" in text}
    for path, text in sources.items():
        if "compiled import" in text:
            tree = ast.parse(text)
            homes = imported(tree, path)
            yield from (f"{path}: {name}" for name in frozen(tree) & homes.keys() if homes[name] not in covered)


def test_every_constant_of_a_law_is_part_of_the_digest() -> None:
    assert list(uncovered()) == []


@pytest.mark.slow
def test_a_changed_law_is_never_met_by_old_machine_code(tmp_path: Path) -> None:
    """Also where the installation cannot be written to and the cache lies elsewhere."""
    copy = tmp_path / "installed" / "vtank"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    law = copy / "effects" / "linear_drag.py"

    def answer() -> float:
        environment = {k: v for k, v in os.environ.items() if not k.endswith("CACHE_DIR")}
        environment |= {"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": str(copy.parent)}
        done = subprocess.run(
            [sys.executable, "-c", SLOWED], capture_output=True, text=True, env=environment, check=True
        )
        return float(done.stdout)

    law.chmod(0o444), copy.chmod(0o555)
    before = answer()
    law.chmod(0o644), copy.chmod(0o755)
    text = law.read_text(encoding="utf-8")
    changed = text.replace("return -c", "return -3.0 * c")
    assert changed != text
    law.write_text(changed, encoding="utf-8")
    os.utime(law, ns=(0, 0))  # as after an installation, whose files bear the date of the release
    law.chmod(0o444), copy.chmod(0o555)
    assert before != 0.0 and answer() == pytest.approx(3.0 * before, rel=0.02)
    copy.chmod(0o755)
