"""Every command and code block of the documents and of public docstrings works as it is written."""

from __future__ import annotations

import ast
import os
import re
import shlex
import shutil
import subprocess
import sys
import textwrap
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import logfiles
import numpy as np
import pytest
from documents import DOCUMENTS, LANGUAGES, ROOT, blocks, commands, follow, obey

import vtank as vt
from vtank.cli import main
from vtank.experiment.scenario import load_scenario
from vtank.experiment.whole_scenario import is_whole, load_whole_scenario
from vtank.logs import import_log, read_mapping
from vtank.plant.vehicle import load_vehicle
from vtank.record import read_run
from vtank.record.table import Table
from vtank.studies.campaign import load_campaign
from vtank.tank.places import read_placed

README, HOWTO, BENCHMARKS = (ROOT / name for name in ("README.md", "models/HOWTO.md", "benchmarks/README.md"))
SCENARIOS = ROOT / "scenarios" / "README.md"
EFFECT = "An effect, in fifteen minutes"
RUN_BY = {  # document -> its blocks of TOML that are no file, each of which a test below reads
    "README.md": 0,
    "models/HOWTO.md": 1,
    "scenarios/README.md": 3,
    "scenarios/campaigns/README.md": 1,
    "benchmarks/README.md": 0,
}
ELSEWHERE = {  # command that takes minutes, or needs what is not always here -> the test that runs it on little effort
    "vtank bandwidth --out waves": 'test_bandwidth_station.py: main(["bandwidth"',
    "vtank bandwidth mine-sway.toml --out bandwidth": 'test_bandwidth_station.py: main(["bandwidth"',
    "vtank reproduce --out paper": 'test_reproduce.py: main(["reproduce"',
    "vtank view data/paper-ds1.csv --film gap.mp4": 'test_view.py: main(["view"',
    "vtank identifiability whole/zigzag --nominal remus100": "test_documents.py: WHOLE",
    "vtank explore zigzag --nominal bluerov2 --write-plan next.toml": "test_documents.py: WHOLE",
    "vtank diagnose zigzag --nominal bluerov2 --axes yaw --against mine": "test_documents.py: WHOLE",
    "vtank identifiability --seeds 400 --design --out page --write-plan plan": 'test_identifiability_plan.py: "plan"',
}


def dives(*names: str, header: str = "Time (ms);Propeller (rpm);Distance to wall (cm)") -> None:
    """Tables as a logger writes them, of flights of the surge model: half the echoes, decimal commas."""
    for k, name in enumerate(names):
        run = vt.run("multisine", seed=k, simulator="surge", settings=["duration_s=60"])[0]
        lines = [header]
        for row, time_s in enumerate(run.time_s):
            echo = f"{100.0 * run.columns['range_m'][row]:.1f}".replace(".", ",") if row % 2 == 0 else ""
            lines.append(f"{1000.0 * time_s:.0f};{60.0 * run.columns['n_rev_s'][row]:.0f};{echo}")
        Path(f"{name}.csv").write_text("\n".join(lines) + "\n")


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_block_is_passed_over(document: Path) -> None:
    text, found = document.read_text(encoding="utf-8"), blocks(document)
    assert text.count("\n```") == 2 * len(found), f"{document}: a fence that does not end"
    assert all(block.language in LANGUAGES for block in found)
    left = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    assert not re.search(r"\n\n    \S", left), f"{document}: a block without its language"
    loose = sum(block.language == "toml" and not block.file for block in found)
    assert not found or RUN_BY[str(document.relative_to(ROOT))] == loose


@pytest.mark.slow
def test_the_readme_works(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    logfiles.dataflash(tmp_path / "dive.BIN")
    logfiles.bag2(tmp_path / "bag")
    dives("monday", "tuesday")
    (tmp_path / "robot.xml").write_text(
        "<mujoco><worldbody><body name='hull'><freejoint/><geom size='0.2' mass='40'/></body></worldbody></mujoco>"
    )
    follow(blocks(README), ELSEWHERE)
    assert "Thruster 1 lacks 30 % of its force" in capsys.readouterr().out
    logfiles.check(read_run(tmp_path / "dive.csv"), ("thruster_1_command", "depth_m"), 2e-4)
    bag = import_log(tmp_path / "bag", mapping=tmp_path / "thrusters.toml").run
    assert np.allclose(bag.samples("port_rev_s")[1], 10.0 * logfiles.COMMAND) and "surge_m_s" in bag.columns


@pytest.mark.slow
def test_the_way_to_ones_own_recording_and_vehicle_works(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    dives("dive1", "dive2")
    dives("logger", header="tick;drive;echo")
    follow([block for block in blocks(HOWTO) if block.chapter != EFFECT], ELSEWHERE)
    for name, column in (("dives/dive1", "n_rev_s"), ("logger-run", "range_m")):
        assert column in read_run(tmp_path / f"{name}.csv").columns
    assert "Verdict     Linear drag at surge" in capsys.readouterr().out  # of mine-trial


@pytest.mark.slow
def test_the_way_to_ones_own_effect_works(tmp_path: Path) -> None:
    """In a copy of the package, which compiles its equations anew."""
    for folder in ("src", "models", "scenarios"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    effect, after = [block for block in blocks(HOWTO) if block.chapter == EFFECT]
    assert len(effect.text.splitlines()) <= 30
    (tmp_path / effect.file).write_text(effect.text)
    said = ""
    environment = os.environ | {"PYTHONPATH": str(tmp_path / "src"), "VTANK_CACHE_DIR": str(tmp_path / "cache")}
    for command in commands(after):
        program, *words = shlex.split(command)
        if program == "vtank":
            line = [sys.executable, "-m", "vtank", *words]
            said = subprocess.run(
                line, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True
            ).stdout
        else:
            obey(command, after.place, ELSEWHERE)
    assert "The gap is caused by wave making." in " ".join(said.split()), said


def test_the_blocks_of_the_scenarios_are_read(tmp_path: Path) -> None:
    single, whole, effects = [block.text for block in blocks(SCENARIOS) if block.language == "toml"]
    for text in (single, whole):
        (tmp_path / "trial.toml").write_text(text)
        assert is_whole(tmp_path / "trial.toml") == (text is whole)
        (load_whole_scenario if text is whole else load_scenario)(tmp_path / "trial.toml")
    kingfisher = replace(load_vehicle("bluerov2"), thrusters=(replace(THRUSTER, name="bow_port", input="rev_s"),))
    table = Table(tmp_path / "trial.toml", "effects", tomllib.loads(effects)["effects"])
    assert len(read_placed(table, kingfisher)) == 4


@pytest.mark.slow
def test_the_commands_of_the_figures_are_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    follow(blocks(BENCHMARKS), ELSEWHERE)


def test_all_keys_of_the_how_to_are_read(tmp_path: Path) -> None:
    files = {block.file: block.text for block in blocks(HOWTO) if block.file}
    (keys,) = [block.text for block in blocks(HOWTO) if block.language == "toml" and not block.file]
    text = files["mine.toml"].split("[[thruster]]")[0] + keys
    (tmp_path / "mine.toml").write_text(
        text.replace("sites = {", "sites = { bow_port_m = [0, 0, 0], rudder_m = [0, 0, 0],")
    )
    vehicle = load_vehicle(tmp_path / "mine.toml")
    assert (vehicle.thrusters[0].name, vehicle.fins[0].name, vehicle.sensors[0].dropout) == ("bow_port", "rudder", 0.02)


def shown(module: str) -> list[str]:
    """The indented blocks of code or TOML in the docstrings of a module and of what it defines."""
    tree, found = ast.parse(Path(module).read_text(encoding="utf-8")), []
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.FunctionDef | ast.ClassDef):
            text = ast.get_docstring(node) or ""
            for block in re.findall(r"\n\n((?:    .*\n(?:\n(?=    ))?)+)", text + "\n"):
                code = textwrap.dedent(block)
                if is_code(code):
                    found.append(code)
    return found


def is_code(text: str) -> bool:
    """Whether a block is TOML, or Python that does something."""
    try:
        return bool(tomllib.loads(text))
    except tomllib.TOMLDecodeError:
        pass
    try:
        return any(isinstance(node, ast.Import) for node in ast.walk(ast.parse(text)))
    except SyntaxError:
        return False


def follow_python(code: str, folder: Path) -> None:
    logfiles.dataflash(folder / "dive.BIN")
    vt.run("paper-ds1", "paper-ds4", seed=1, settings=["duration_s=60"], out="data")
    exec(compile(code, "docstring", "exec"), {})


def follow_mapping(code: str, folder: Path) -> None:
    (folder / "map.toml").write_text(code)
    assert read_mapping(folder / "map.toml").channels


def follow_campaign(code: str, folder: Path) -> None:
    entries = code.splitlines()
    sweep = [line for line in entries if "uniform" not in line]
    text = "[grid]\nscenario = ['paper-ds1']\n" + "\n".join(sweep) + "\n[draw]\n"
    (folder / "c.toml").write_text(text + "\n".join(line for line in entries if line not in sweep))
    assert len(load_campaign(folder / "c.toml")) == 8


def follow_places(code: str, folder: Path) -> None:
    vehicle = replace(load_vehicle("bluerov2"), thrusters=(replace(THRUSTER, name="bow_port", input="rev_s"),))
    assert read_placed(Table(folder / "t.toml", "effects", tomllib.loads(code)["effects"]), vehicle)


THRUSTER = load_vehicle("bluerov2").thrusters[0]
DOCSTRINGS: dict[str, Callable[[str, Path], None]] = {
    "__init__.py": follow_python,
    "logs/map_file.py": follow_mapping,
    "studies/campaign/axes.py": follow_campaign,
    "tank/places/__init__.py": follow_places,
}


def test_every_module_whose_docstrings_show_code_is_known() -> None:
    package = ROOT / "src" / "vtank"
    found = {str(path.relative_to(package)) for path in package.rglob("*.py") if shown(str(path))}
    assert found == set(DOCSTRINGS)


@pytest.mark.parametrize("module", DOCSTRINGS)
def test_the_code_of_docstrings_works(module: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for code in shown(str(ROOT / "src" / "vtank" / module)):
        DOCSTRINGS[module](code, tmp_path)


WHOLE = (  # in their order, in one folder
    "run whole/zigzag --set vehicle=bluerov2 --set duration_s=20 --out zigzag",
    "identifiability whole/zigzag --nominal remus100",
    "explore zigzag --nominal bluerov2 --write-plan next.toml",
    "run whole/zigzag --set vehicle=kingfisher --set duration_s=20 --out boat",
    "run whole/zigzag --set vehicle=kingfisher --set duration_s=20 --seed 5 --out mine",
    "diagnose boat --nominal kingfisher --axes yaw --against mine",
)


@pytest.mark.slow
def test_commands_on_whole_vehicles_end_well(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Those of the README, on shorter flights, the longest of a smaller vehicle; none prints a number that is none."""
    monkeypatch.chdir(tmp_path)
    for line in WHOLE:
        assert main(line.split()) == 0, line
    assert "nan" not in capsys.readouterr().out
    assert (tmp_path / "next.toml").is_file()
