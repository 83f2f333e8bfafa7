"""The examples run as they are, in an empty folder, and say what they promise."""

from __future__ import annotations

import ast
import re
import runpy
import sys
from pathlib import Path
from types import ModuleType

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
SAID = {  # example -> words of its output, files it leaves
    "first_hour": (("The gap is caused by linear drag.", "a second recording"), ("gap.html", "gap.toml")),
    "fly_and_identify": (("thrust_lag.tau", "truth 0.7074"), ("data/truth.json",)),
    "diagnose_and_correct": (("The gap is caused by linear drag.", "a run never seen"), ("gap.html", "gap.toml")),
    "own_log": (("thrust_lag.tau",), ("log.csv",)),
    "before_the_tank": (("no unbiased estimator gets below",), ("plan/identifiability.html",)),
    "robots_in_water": (("cassie: ", "anymal_c: ", "panda: "), ()),
    "control_loop": (("dived 0.500 m", "to starboard by the current"), ()),
    "campaign": (("8 runs", "linear drag 0."), ("many/runs.csv",)),
}


def test_all_examples_are_here_and_short() -> None:
    paths = sorted(EXAMPLES.glob("*.py"))
    assert {path.stem for path in paths} == set(SAID)
    assert all(len(path.read_text(encoding="utf-8").splitlines()) < 60 for path in paths)


CELL = re.compile(r"^# %%(?: \[markdown\])?(.*)$", re.MULTILINE)


def test_the_last_line_of_each_cell_shows_itself(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cells as a notebook runs them: a name alone in a cell's last line is a result, with a picture or a table."""
    monkeypatch.chdir(tmp_path)
    cells = CELL.split((EXAMPLES / "first_hour.py").read_text(encoding="utf-8"))[2::2]
    space, shown = {"__name__": "__main__"}, []
    for cell in cells:
        body = ast.parse(cell).body
        last = body.pop() if body and isinstance(body[-1], ast.Expr) and isinstance(body[-1].value, ast.Name) else None
        exec(compile(ast.Module(body, []), "first_hour.py", "exec"), space)
        if last:
            result = eval(compile(ast.Expression(last.value), "first_hour.py", "eval"), space)
            shown.append(result._repr_html_())
    assert len(cells) >= 6 and len(shown) >= 4
    assert "<polyline" in shown[0] and "<table>" in shown[1] and "linear drag" in shown[2]


@pytest.mark.parametrize("name", SAID)
def test_an_example_runs(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    words, files = SAID[name]
    shown = capsys.readouterr().out
    assert all(word in shown for word in words), shown
    assert all((tmp_path / file).exists() for file in files)


ROBOTS = {  # stand-ins with a free body, jointed legs on one, and an arm to be carried
    "cassie": '<body name="x2"><freejoint/><geom type="box" size="0.2 0.1 0.05" mass="1"/></body>',
    "anymal_c": """<body name="base"><freejoint/><geom type="box" size="0.3 0.1 0.05" mass="7"/>
      <body name="leg" pos="0.2 0.1 0"><joint axis="0 1 0" damping="1"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.02" mass="1"/></body></body>""",
    "panda": """<body name="link0"><geom size="0.05" mass="0.5"/><body name="link1"><joint axis="0 1 0" damping="1"/>
      <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03" mass="1"/></body></body>""",
}


def test_robots_of_robot_descriptions_sink_as_they_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With stand-ins under the names that robot_descriptions gives its modules."""
    for name, body in ROBOTS.items():
        module = ModuleType(f"robot_descriptions.{name}_mj_description")
        module.MJCF_PATH = str(tmp_path / f"{name}.xml")  # type: ignore[attr-defined]
        (tmp_path / f"{name}.xml").write_text(f"<mujoco><worldbody>{body}</worldbody></mujoco>")
        monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setitem(sys.modules, "robot_descriptions", ModuleType("robot_descriptions"))
    runpy.run_path(str(EXAMPLES / "robots_in_water.py"), run_name="__main__")
    shown = capsys.readouterr().out
    assert "skipped" not in shown and "panda: 3 wet bodies, 7 degrees of freedom" in shown
