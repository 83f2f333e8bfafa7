"""Readers of everything that comes from outside, against what is spoilt: each case is read, or refused in one message.

`make fuzz` tries ten times as many cases. The draws are the same every time.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import tomllib
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fuzz import (
    HABITS,
    LOGS,
    LONGEST,
    SPOILING,
    WORDS,
    Files,
    bounded,
    check_message,
    files_of,
    put,
    reads_or_refuses,
    spoil,
    taken,
)
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vtank.cli import main
from vtank.diagnose import read_model
from vtank.diagnose.simulator_file import read_simulator
from vtank.errors import InputError
from vtank.estimate import observe
from vtank.estimate.observed import stretches
from vtank.experiment import load_scenario, plan_run
from vtank.experiment.whole_scenario import load_whole_scenario
from vtank.library import load
from vtank.logs import import_log
from vtank.plant import load_truth, load_vehicle
from vtank.plant.formula import ACTS, KEPT, formula_of, law_lines, read_formula
from vtank.plant.law import KINDS, OPERATIONS, VARIABLES
from vtank.plant.parameters import null_vector, vector
from vtank.plant.surge import surge_acceleration
from vtank.present.identified import known_truth
from vtank.record import DataSetWarning, read_dataset, read_run
from vtank.record.table import Table, open_table
from vtank.studies.blind.answer import check_data
from vtank.studies.blind.seal import read_index
from vtank.studies.blind.verify import open_all
from vtank.studies.campaign import Campaign, Tally, Threads, fly_campaign, load_campaign
from vtank.tank.whole import load_whole
from vtank.tank.world import load_world

MORE = int(os.environ.get("VTANK_FUZZ", "1"))  # times the cases


def observed(folder: Path) -> None:
    """A run as far as an estimator takes it."""
    for run in stretches(load(folder / "run_1.csv")):
        seen = observe(run)
        assert np.isfinite(seen.value).all() and np.isfinite(seen.input).all()


def planned(folder: Path) -> None:
    scenario = load_scenario(folder / "dive.toml")
    if scenario.samples < 1e5:
        assert np.isfinite(plan_run(scenario).truth.vector()[:2]).all()


def campaign(folder: Path) -> Campaign:
    found = load_campaign(folder / "many.toml")
    found.choice(0)
    return found


def truths(folder: Path) -> None:
    for name in ("paper-ii.toml", "bluerov2.toml"):
        assert not np.isnan(load_truth(folder / name).vector()).any()


def nominal(folder: Path) -> None:
    _, _, simulator, mass_kg = read_simulator(folder / "mine.toml")
    assert not np.isnan(simulator.p).any() and (mass_kg is None or mass_kg > 0.0)


def predictor(folder: Path) -> None:
    models = read_model(folder / "model.toml")
    for one in (models.nominal, models.refit, models.diagnosed):
        assert not np.isnan(one.p).any()


def cases(folder: Path) -> None:
    index = read_index(folder / "cases")
    for entry in index.entries:
        check_data(folder / "cases", entry)


def imported(folder: Path, name: str) -> None:
    """A log, told in words."""
    found = import_log(folder / name)
    assert found.run.time_s.size and len(str(found)) < 1e5


# Kind -> how it is read, and cases of a test
READERS: dict[str, tuple[Callable[[Path], object], int]] = {
    "run": (observed, 400),
    "whole run": (lambda folder: read_run(folder / "run.csv"), 150),
    "data set": (read_dataset, 200),
    "truth.json": (lambda folder: known_truth(folder / "truth.json"), 80),
    "truth": (truths, 150),
    "scenario": (planned, 250),
    "whole scenario": (lambda folder: load_whole_scenario(folder / "bluerov2-multisine.toml"), 120),
    "campaign": (campaign, 150),
    "model": (predictor, 150),
    "nominal": (nominal, 150),
    "vehicle": (lambda folder: load_vehicle(folder / "bluerov2.toml"), 150),
    "trials": (lambda folder: open_all(folder / "cases", folder / "truth", folder / "answers.json"), 100),
    "cases": (cases, 50),
    "MJCF": (lambda folder: load_world(load_vehicle(folder / "bluerov2.toml"), folder / "basin.xml"), 100),
    "table": (lambda folder: import_log(folder / "dive.csv"), 150),
    **{kind: (partial(imported, name=name), 60) for kind, name in LOGS.items()},
    "fins": (lambda folder: load_whole(load_vehicle(folder / "remus100.toml")), 60),
}


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Files]:
    """The sound files of a kind, made once."""
    kept: dict[str, Files] = {}

    def files(kind: str) -> Files:
        if kind not in kept:
            kept[kind] = files_of("trials" if kind == "cases" else kind, tmp_path_factory.mktemp("sound"))
            if kind == "MJCF":
                kept[kind] |= {"bluerov2.toml": files_of("vehicle", Path())["bluerov2.toml"]}
        return kept[kind]

    return files


def examples(count: int) -> Any:
    return settings(
        max_examples=count * MORE, derandomize=True, database=None, deadline=None,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("kind", READERS)
def test_a_spoilt_file_is_read_or_refused_in_one_message(
    kind: str, sound: Callable[[str], Files], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read, count = READERS[kind]
    files, folder = sound(kind), tmp_path / "files"
    monkeypatch.chdir(tmp_path)
    put(folder, files)
    read(folder)  # sound files are read

    @examples(count)
    @given(SPOILING)
    def case(orders: list[tuple[int, str, int, str]]) -> None:
        put(folder, spoil(files, orders))
        reads_or_refuses(read, folder)

    case()
    assert not list(tmp_path.glob("MUJOCO_LOG*"))


# --- laws ------------------------------------------------------------------------------------------------------------
NUMBERS = st.sampled_from(
    [*(f"{k / 4}" for k in range(-40, 41)), "1e300", "-1e300", "nan", "inf", "1e-320", "0x1", "", "1,5"]
)
STRANGE = [*WORDS, "eval", "u;import os", "u.__class__", "(u)", "u**2", "power(u)", "lambda"]


def word(known: tuple[str, ...]) -> st.SearchStrategy[str]:
    """A word of the grammar, one time in ten or so another."""
    return st.sampled_from([*known * (10 * len(STRANGE) // len(known)), *STRANGE])


def phrase(*choices: tuple[str, ...], numbers: int) -> st.SearchStrategy[str]:
    """Words of these choices, then numbers."""
    return st.tuples(*map(word, choices), *[NUMBERS] * numbers).map(" ".join)


LAWS = st.fixed_dictionaries(
    {
        "acts": word(tuple(ACTS)),
        "factors": st.lists(phrase(VARIABLES[1:], OPERATIONS, numbers=2), min_size=1, max_size=4),
        "size": NUMBERS,
    },
    optional={
        "memory": phrase(KINDS[1:], KEPT, ("power", "signed"), numbers=3),
        "input": word(("n_rev_s", "command", "thrust_N")),
    },
)


def test_a_law_is_read_and_obeyed_or_refused_and_never_run(
    sound: Callable[[str], Files], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Phrases of the grammar of laws: what is read is written again as it was, and moves a hull."""
    head, _, rest = sound("model")["model.toml"].partition("[law]")
    tail, read = "[nominal]" + rest.partition("[nominal]")[2], [0]
    folder = tmp_path / "files"
    monkeypatch.chdir(tmp_path)
    surge_acceleration(0.0, 0.0, 0.0, 0.03, 0.0, 0.0, 3.0, 0.0, null_vector())  # compiled before the clock runs

    @examples(400)
    @given(LAWS)
    def case(law: dict[str, Any]) -> None:
        lines = [f"{key} = {value if key == 'size' else json.dumps(value)}" for key, value in law.items()]
        text = "\n".join(lines).encode("utf-8", "replace").decode("latin-1")
        put(folder, {"model.toml": f"{head}[law]\n{text}\n{tail}"})
        with bounded():
            try:
                formula = read_formula(open_table(folder / "model.toml"))
            except InputError as reason:
                check_message(str(reason), folder)
                return
            assert formula is not None and formula.text() and formula.unit
            again = tomllib.loads("\n".join(law_lines(formula)))["law"]
            copy = read_formula(Table(folder / "model.toml", "", {"law": again}))
            assert copy is not None and law_lines(copy) == law_lines(formula)  # to the twelve digits that are written
            assert not formula.size or formula_of(formula.values(), formula.fed) == formula
            p = vector({"alpha": -2.5, "beta": 5e-4, **formula.values()})
            for t, x, u, n in ((0.0, 0.0, 0.0, 0.0), (3.0, 0.4, -0.25, 9.0), (1e3, -2.0, 3.0, -20.0)):
                surge_acceleration(t, x, u, 0.03, 0.0, n, 3.0 - x, 0.0, p)
        read[0] += 1

    case()
    assert read[0] > 20 * MORE and list(tmp_path.iterdir()) == [folder]


# --- mistakes that people make ---------------------------------------------------------------------------------------
MISTAKES: dict[str, tuple[str, ...]] = {  # what is done to a sound run -> words of the message; none where it is read
    "semicolons": ("line 1", "separated by semicolons, expected commas"),
    "decimal commas": ("line 1", "separated by semicolons, expected commas, and decimal points"),
    "tabs": ("line 1", "separated by tabs"),
    "mark": (),
    "CRLF": (),
    "CR": (),
    "blanks": (),
    "quoted": (),
    "UTF-16": ("line 1", "is it UTF-16?"),
    "blank lines": ("line 2", "empty line"),
    "blank end": ("line 62", "empty line"),
    "comma at the end": ("line 1", "column 4 has no name"),
    "header twice": ("line 2, column time_s", "expected a number"),
    "twice": ("line 62, column time_s", "expected a number"),
    "no header": ("line 1", "expected a header"),
    "header alone": ("no rows below the header",),
    "one row": ("1 sample of range_m", "expected at least 10"),
    "backwards": ("line 2", "empty line"),
    "nothing": ("the file is empty",),
    "zeros": ("line 1", "no column time_s"),
    "ms": ("line 3: column time_s", "are they seconds?"),
    "us since 1970": ("line 3: column time_s", "are they seconds?"),
}


def cells(change: Callable[[list[list[str]]], list[list[str]]]) -> Callable[[str], str]:
    """A change of the cells of a run: time, propeller speed, range; the header is row 0."""
    return lambda text: "\n".join(map(",".join, change([line.split(",") for line in text.strip().split("\n")]))) + "\n"


def times(column: int, factor: float) -> Callable[[str], str]:
    """A column in another unit."""

    def change(rows: list[list[str]]) -> list[list[str]]:
        for row in rows[1:]:
            row[column] = row[column] and f"{float(row[column]) * factor:.9g}"
        return rows

    return cells(change)


CELLS: dict[str, tuple[Callable[[str], str], tuple[str, ...]]] = {
    "rpm": (times(1, 60.0), ("line 2: column n_rev_s", "is it rpm?")),
    "a time twice": (cells(lambda rows: rows[:10] + rows[9:]), ("line 11: column time_s", "strictly increasing")),
    "a mark for what is lost": (
        cells(lambda rows: [*rows[:9], [rows[9][0], "-999", ""], *rows[10:]]), ("line 10: column n_rev_s", "-999")
    ),
    "NaN": (cells(lambda rows: [*rows[:9], [rows[9][0], "NaN", ""], *rows[10:]]), ("line 10, column n_rev_s", "'NaN'")),
    "feet": (cells(lambda rows: [["time_s", "n_rev_s", "range_ft"], *rows[1:]]), ("line 1", "range_m", "range_ft")),
    "dates": (
        cells(lambda rows: [rows[0], *([f"2024-05-01T10:00:{k:02d}", *row[1:]] for k, row in enumerate(rows[1:]))]),
        ("line 2, column time_s", "'2024-05-01T10:00:00'"),
    ),
}  # fmt: skip
DOUBTFUL = {"mm": (times(2, 1000.0), "range_m: typically .*mm or cm"), "days": (times(0, 1 / 86400), "hours or days")}


@pytest.mark.parametrize("mistake", [*MISTAKES, *CELLS])
def test_a_mistake_in_a_recording_is_told_by_place_and_cause(
    mistake: str, sound: Callable[[str], Files], tmp_path: Path
) -> None:
    change, words = (HABITS[mistake], MISTAKES[mistake]) if mistake in MISTAKES else CELLS[mistake]
    put(tmp_path, {"run_1.csv": change(sound("run")["run_1.csv"])})
    if not words:
        assert observe(read_run(tmp_path / "run_1.csv")).value.size == 30
        return
    with pytest.raises(InputError, match="run_1.csv") as told:
        observed(tmp_path)
    assert all(word in str(told.value) for word in words), told.value


@pytest.mark.parametrize("unit", DOUBTFUL)
def test_a_unit_that_looks_wrong_is_doubted(unit: str, sound: Callable[[str], Files], tmp_path: Path) -> None:
    change, words = DOUBTFUL[unit]
    put(tmp_path, {"run_1.csv": change(sound("run")["run_1.csv"])})
    with pytest.warns(DataSetWarning, match=words):
        read_run(tmp_path / "run_1.csv")


def test_a_million_rows_are_read(tmp_path: Path) -> None:
    lines = "".join(f"{k / 100},{k % 7},{3 + k % 5 / 100}\n" for k in range(1_000_000))
    (tmp_path / "long.csv").write_text(f"time_s,n_rev_s,range_m\n{lines}")
    with bounded():
        assert read_run(tmp_path / "long.csv").time_s.size == 1_000_000


def test_links_in_a_loop_and_files_that_may_not_be_read_are_named(tmp_path: Path) -> None:
    (tmp_path / "run_1.csv").symlink_to(tmp_path / "run_2.csv")
    (tmp_path / "run_2.csv").symlink_to(tmp_path / "run_1.csv")
    with pytest.raises(InputError, match=r"run_1.csv: cannot be read \(Too many levels"):
        read_dataset(tmp_path)


# --- commands --------------------------------------------------------------------------------------------------------
COMMANDS = [
    ["check-data", "files"],
    ["check-data", "files/run_1.csv"],
    ["run", "paper-ds1", "--model", "surge", "--set", "duration_s=4", "--seed", "1", "--threads", "1", "--out", "out"],
    ["run", "files/dive.toml", "--model", "surge", "--truth", "paper-ii", "--set", "duration_s=4", "--out", "out"],
    ["predict", "files/model.toml", "files/run_1.csv", "--json", "gaps.json"],
    ["effects", "tether", "--json"],
    ["campaign", "files/many.toml", "--threads", "1", "--out", "many"],
    ["blind", "score", "files", "--truth", "files", "--published", "0" * 64],
    ["blind", "answer", "files", "--seed", "0", "--processes", "1"],
]
ARGUMENTS = [word for word in WORDS if "\0" not in word]  # no system passes that one


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_spoilt_command_line_ends_in_one_message(
    sound: Callable[[str], Files], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files = {name: text for kind in ("data set", "campaign", "model") for name, text in sound(kind).items()}
    files["many.toml"] = files["many.toml"].replace("repeats = 3", "repeats = 1")
    place = tmp_path / "a" / "b"

    @examples(150)
    @given(st.sampled_from(COMMANDS), st.integers(0, 99), st.sampled_from(ARGUMENTS), st.booleans())
    def case(command: list[str], where: int, word: str, whole: bool) -> None:
        put(place / "files", files)
        monkeypatch.chdir(place)
        for folder in ("out", "many"):
            shutil.rmtree(place / folder, ignore_errors=True)
        words = list(command)
        at = where % (len(words) - 1) + 1
        words[at] = word if whole else words[at] + word
        said = io.StringIO()
        with bounded(), redirect_stdout(io.StringIO()), redirect_stderr(said):
            try:
                code = main(words)
            except SystemExit as told:
                code = told.code
        lines = [line for line in said.getvalue().splitlines() if line.startswith(("vtank: error: ", "vtank "))]
        refused = code == 2 and lines and len(lines[-1]) < LONGEST + 3 * len(word)
        assert code == 0 or refused, said.getvalue()[-LONGEST:]
        assert "Traceback" not in said.getvalue()

    case()


@pytest.mark.parametrize("form", ["csv", "hdf5"])
def test_a_spoilt_journal_is_flown_again_or_refused(form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is in the journal of a campaign that was killed; in the end all runs are there, or one message."""
    text = 'model = "surge"\nrepeats = 3\n[grid]\nscenario = "paper-ds1"\nduration_s = [4.0, 5.0]\n'
    (tmp_path / "few.toml").write_text(text)
    found, out = load_campaign(tmp_path / "few.toml"), tmp_path / "out"

    class Killed(BaseException):
        pass

    def kill(tally: Tally) -> None:
        if tally.flown >= 4:
            raise Killed

    with pytest.raises(Killed):
        fly_campaign(found, out, Threads(1), form, kill, chunk=2)
    begun = taken(out)

    @examples(40)
    @given(SPOILING)
    def case(orders: list[tuple[int, str, int, str]]) -> None:
        journal = {name: data for name, data in begun.items() if name.endswith(".json")}
        put(out, begun | spoil(journal, orders))
        with bounded():
            try:
                tally = fly_campaign(found, out, Threads(1), form, chunk=2)
            except InputError as reason:
                check_message(str(reason), out)
            else:
                assert tally.before + tally.flown == 6 and not (out / "journal").exists()

    case()
