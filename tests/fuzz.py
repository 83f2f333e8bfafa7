"""Shared by the fuzzed readers: sound files of every kind, and the ways in which strangers, slips and kills spoil them.

A spoilt file is made by a few operations, each drawn with a place and a word: hypothesis makes them smaller when a
reader fails. Files are bytes shown as Latin-1, so that every byte can be spoilt.
"""

from __future__ import annotations

import json
import re
import resource
import shutil
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st

from vtank.errors import InputError
from vtank.record import Manifest, Run, write_dataset
from vtank.resources import models_dir, scenarios_dir
from vtank.studies.blind.answer import answer
from vtank.studies.blind.seal import Entry, digest, seal_truth, write_index, write_runs

Files = dict[str, str]  # path within a folder -> content, a character for each byte
PATIENCE_S = 10.0  # [s] for one case, a hundred times what the slowest takes; a choice
ROOM = 6 * 2**30  # bytes that one case may ask for beyond what is taken; a choice
LONGEST = 1500  # characters of a message

WORDS = [
    *("0", "-1", "1", "7", "1e300", "-1e300", "1e999", "1e-320", "nan", "inf", "-inf", "NaN", "Infinity", "1e12"),
    *("9" * 400, "9" * 5000, "0x10", "1_000", "1,5", "0.1.2", "--1", "\u0663", "1e8", "3600000", "18000", "-0.0"),
    *("", " ", "true", "null", "[]", "{}", '""', '"a"', '"nan"', '"../../x"', '"/dev/zero"', '"a\\u0000b"'),
    *("[" * 3000, "{a=" * 3000, "[[]]", "[1, 2]", "[[1], 2]", '["a", 3]', "{ value = [] }", '{"a": 1}', '"\\ud800"'),
    *("<script>", "\0", "\xff", "\u2028", "#", "=", ",", ";", "\n", '"""', "'", "nan nan nan", "__import__('os')"),
    *("100000000", '"phoenix"', '"paper-ii"', '"surge"', '"u power nan 0"', "1979-05-27", "{ from = 0, to = 1 }"),
]
VALUE = re.compile(r'"(?:[^"\\\n]|\\.)*"|[-+]?\d[\d.]*(?:[eE][-+]?\d+)?|\btrue\b|\bfalse\b|\bnull\b')
NAME = re.compile(r"[A-Za-z_]\w+")
PAIRS = {"{": "}", "[": "]"}


def spoilt(text: str, operation: str, where: int, word: str) -> str:
    """The text after one operation at one place."""
    word = word.encode().decode("latin-1")
    lines = text.split("\n")
    at = where % len(lines)
    match operation:
        case "value" | "name":
            found = list((VALUE if operation == "value" else NAME).finditer(text))
            if not found:
                return text
            one = found[where % len(found)]
            new = word if operation == "value" else _slip(one[0], where)
            return text[: one.start()] + new + text[one.end() :]
        case "group":
            starts = [k for k, letter in enumerate(text) if letter in PAIRS]
            if not starts:
                return text
            start = starts[where % len(starts)]
            end = text.find(PAIRS[text[start]], start)
            return text[:start] + word + (text[end + 1 :] if end > 0 else "")
        case "line out":
            return "\n".join(lines[:at] + lines[at + 1 :])
        case "line twice":
            return "\n".join(lines[: at + 1] + lines[at:])
        case "line moved":
            other = where // len(lines) % len(lines)
            lines[at], lines[other] = lines[other], lines[at]
            return "\n".join(lines)
        case "line in":
            return "\n".join([*lines[:at], word, *lines[at:]])
        case "cut":
            return text[: where % (len(text) + 1)]
        case "byte":
            place = where % (len(text) + 1)
            return text[:place] + chr(where // 7 % 256) + text[place + 1 :]
        case "in":
            place = where % (len(text) + 1)
            return text[:place] + word + text[place:]
    return HABITS[operation](text)


def _slip(word: str, where: int) -> str:
    """A word as it is misspelt: a letter less, two in the wrong order, another unit, other capitals."""
    k = where // 11 % len(word)
    turned = word[:k] + word[k:][:2][::-1] + word[k + 2 :]
    return [word[:k] + word[k + 1 :], turned, word + "_ft", word.upper()][where % 4]


def scaled(factor: float) -> Callable[[str], str]:
    """The first number of every line in another unit."""
    return lambda text: re.sub(r"(?m)^[-+]?\d+\.?\d*", lambda one: f"{float(one[0]) * factor:.9g}", text)


HABITS: Mapping[str, Callable[[str], str]] = {  # of programs, countries and people
    "semicolons": lambda text: text.replace(",", ";"),
    "decimal commas": lambda text: text.replace(",", ";").replace(".", ","),
    "tabs": lambda text: text.replace(",", "\t"),
    "blanks": lambda text: text.replace(",", " , "),
    "quoted": lambda text: re.sub(r"([^,\n]+)", r'"\1"', text),
    "mark": lambda text: "\xef\xbb\xbf" + text,
    "two marks": lambda text: "\xef\xbb\xbf" * 2 + text,
    "UTF-16": lambda text: text.encode("utf-16").decode("latin-1"),
    "CRLF": lambda text: text.replace("\n", "\r\n"),
    "CR": lambda text: text.replace("\n", "\r"),
    "blank lines": lambda text: text.replace("\n", "\n\n"),
    "blank end": lambda text: text + "\n\n \n",
    "comma at the end": lambda text: text.replace("\n", ",\n"),
    "header twice": lambda text: text.split("\n")[0] + "\n" + text,
    "no header": lambda text: "\n".join(text.split("\n")[1:]),
    "one row": lambda text: "\n".join(text.split("\n")[:2]),
    "header alone": lambda text: text.split("\n")[0],
    "twice": lambda text: text + text,
    "backwards": lambda text: "\n".join([text.split("\n")[0], *text.split("\n")[:0:-1]]),
    "nothing": lambda text: "",
    "zeros": lambda text: "\0" * len(text),
    "ms": scaled(1000.0),
    "us since 1970": lambda text: re.sub(r"(?m)^(\d+)\.?(\d*)", lambda one: f"17{one[1]:0>8}{one[2]:0<6}", text),
    "days": scaled(1.0 / 86400.0),
    "comments": lambda text: text.replace("\n", " # as flown\n"),
}
OPERATIONS = ["value", "value", "value", "name", "group", "line out", "line twice", "line moved", "line in", "cut",
              "byte", "in", *HABITS]  # fmt: skip
SPOILING = st.lists(
    st.tuples(st.integers(0, 99), st.sampled_from(OPERATIONS), st.integers(0, 10**6), st.sampled_from(WORDS)),
    min_size=1,
    max_size=4,
)


def spoil(files: Files, orders: list[tuple[int, str, int, str]]) -> Files:
    """The files after some operations, each of them on one file."""
    out, names = dict(files), sorted(files)
    for file, *order in orders:
        name = names[file % len(names)]
        out[name] = spoilt(out[name], *order)
    return out


def put(folder: Path, files: Files) -> None:
    """These files and nothing else in a folder."""
    shutil.rmtree(folder, ignore_errors=True)
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(text.encode("latin-1"))


def taken(folder: Path, *names: str) -> Files:
    """The files of a folder, those of these names or all."""
    paths = [folder / name for name in names] or [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {path.relative_to(folder).as_posix(): path.read_bytes().decode("latin-1") for path in paths}


@contextmanager
def bounded() -> Iterator[None]:
    """Neither time nor memory without end; the numbers are those of this module."""

    def late(number: int, frame: object) -> None:
        raise TimeoutError(f"more than {PATIENCE_S:g} s")

    taken_bytes = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    before, handler = resource.getrlimit(resource.RLIMIT_AS), signal.signal(signal.SIGALRM, late)
    resource.setrlimit(resource.RLIMIT_AS, (taken_bytes + ROOM, before[1]))
    signal.setitimer(signal.ITIMER_REAL, PATIENCE_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, handler)
        resource.setrlimit(resource.RLIMIT_AS, before)


def check_message(message: str, folder: Path) -> None:
    """One message that names a file of the folder, and is no dump of it."""
    assert str(folder) in message or any(path.name in message for path in folder.rglob("*")), message
    assert "Traceback" not in message and len(message) < LONGEST, message


def reads_or_refuses(read: Callable[[Path], object], folder: Path) -> None:
    """Whether a reader takes what is in a folder, or says what is wrong with which file; nothing else may happen."""
    with bounded():
        try:
            read(folder)
        except InputError as reason:
            check_message(str(reason), folder)


# --- sound files -----------------------------------------------------------------------------------------------------
def surge_run(name: str = "run_1", rows: int = 60) -> Run:
    """A run of one axis."""
    time = 0.1 * np.arange(rows)
    range_m = np.where(np.arange(rows) % 2, np.nan, np.round(3.0 - 0.4 * np.sin(time), 4))
    return Run(name, np.round(time, 4), {"n_rev_s": np.round(10.0 * np.cos(time), 4), "range_m": range_m})


def data_set(folder: Path) -> Files:
    """Two runs with a manifest and a truth."""
    truth: dict[str, Any] = {"model": "surge", "runs": [{"run": "run_1", "parameters": {"alpha": -2.5, "beta": 5e-4}}]}
    write_dataset(folder, [surge_run(), surge_run("run_2")], Manifest({"run_1": "duration_s = 6.0\n"}), truth)
    return taken(folder)


def whole_run(folder: Path) -> Files:
    """The recording of a whole vehicle, as text."""
    time = 0.1 * np.arange(40)
    columns = {"time_s": time, "thruster_1_command": 0.5 * np.cos(time), "dvl.surge_m_s": 0.2 * np.sin(time),
               "heading_rad": 0.1 * time, "gyro.yaw_rate_rad_s": 0.1 * time, "battery_V": 15.0 - time}  # fmt: skip
    lines = [",".join(columns), *(",".join(f"{v:.4f}" for v in row) for row in zip(*columns.values(), strict=True))]
    return {"run.csv": "\n".join(lines) + "\n"}


def trials(folder: Path) -> Files:
    """Two blind cases of a few seconds, nothing flown: the files with all their seals, and answers."""
    cases, sealed, entries = folder / "cases", folder / "truth", []
    run = surge_run(rows=20)
    for number in (1, 2):
        name = f"case_{number:04d}"
        hashes = write_runs(cases / name, [run, run])
        held = write_runs(sealed / "held_out" / name, [run])
        truth = {"schema": "vtank.blind-truth/2", "kind": "none", "label": "none", "causes": [], "case": name,
                 "data": digest(hashes), "held_out_files": held}  # fmt: skip
        entries.append(Entry(name, "paper-ii", hashes, (), seal_truth(sealed / f"{name}.json", truth)))
    write_index(cases, sealed, entries, {"seed": 1, "trials": 2})
    said = {"verdict": {"kind": "none", "probability": 1.0}, "probabilities": {"none": 1.0}}
    answer(cases, folder / "answers.json", count=1, answer_case=lambda *given: {"document": said})
    return taken(folder)


def model(folder: Path) -> Files:
    """A diagnosed model with a law."""
    own = "alpha_per_m = -2.5\nbeta_m_per_rev2 = 5e-4\ngamma_per_rev = 0.0\ntau_s = 0.7\n"
    law = 'acts = "force"\ninput = "n_rev_s"\nsize = 0.01\nfactors = ["u signed 1 0", "t decay 20 0"]\n'
    law += 'memory = "follows u signed 1 8 0"\n'
    text = 'schema = "vtank.model/1"\nname = "diagnosed"\nsource = "by hand"\ninput = "n_rev_s"\n'
    text += f"n_limit_rev_s = 20.0\n[lumped]\n{own}"
    text += f"[effects.linear_drag]\nc_per_s = 0.02\n[law]\n{law}[nominal]\n{own}[refit]\n{own}"
    text += "[noise]\nrange_m = 0.004\nturbulence_m_s2 = 0.0\nturbulence_time_s = 1.0\n"
    return {"model.toml": text + '[verdict]\nkind = "effect"\neffects = ["linear_drag"]\nprobability = 0.9\n'}


NOMINAL = """name = "mine"
input = "command"
moving_mass_kg = 40.0
[lumped]
alpha_per_m = -1.3
beta_m_s2 = 0.62
linear_share = 0.2
tau_s = 0.17
[effects.thrust_deadband]
n0 = 0.05
"""
LOGS = {"tlog": "dive.tlog", "BIN": "dive.BIN", "ulg": "dive.ulg", "bag": "dive.bag", "bag 2": "dive", "mcap": "dive"}


def log_of(kind: str, folder: Path) -> Files:
    """The start of a small log of a kind, or a folder of one."""
    import logfiles

    writers: dict[str, Callable[[Path], object]] = {
        "tlog": logfiles.tlog, "BIN": logfiles.dataflash, "ulg": logfiles.ulog, "bag": logfiles.bag,
        "bag 2": logfiles.bag2, "mcap": lambda path: logfiles.bag2(path, mcap=True),
    }  # fmt: skip
    writers[kind](folder / LOGS[kind])
    return taken(folder)


CAMPAIGN = """
model = "surge"
seed = 11
repeats = 3
[grid]
duration_s = 12.0
scenario = ["dive.toml", "chirp"]
excitation.amplitude_m = { from = 0.1, to = 0.3, count = 3, spacing = "log" }
[draw]
sonar.noise_m = { uniform = [0.001, 0.01] }
effects.linear_drag.c_per_s = { log_uniform = [0.001, 0.1] }
truth = { choice = ["paper-ii", "physical"] }
"""


def files_of(kind: str, folder: Path) -> Files:
    """The sound files of a kind."""
    models, scenarios = models_dir(), scenarios_dir()
    scenario = {"dive.toml": (scenarios / "paper-ds1.toml").read_bytes().decode("latin-1")}
    made = {"data set": data_set, "whole run": whole_run, "trials": trials, "model": model}
    if kind in made:
        return made[kind](folder)
    if kind in LOGS:
        return log_of(kind, folder)
    return {
        "table": lambda: {"dive.csv": data_set(folder)["run_1.csv"].replace("range_m", "Distance to wall (m)")},
        "run": lambda: taken(folder, "run_1.csv") if data_set(folder) else {},
        "scenario": lambda: scenario,
        "whole scenario": lambda: taken(scenarios / "whole", "bluerov2-multisine.toml"),
        "campaign": lambda: scenario | {"many.toml": CAMPAIGN},
        "truth": lambda: taken(models / "truths", "paper-ii.toml", "bluerov2.toml"),
        "nominal": lambda: {"mine.toml": NOMINAL},
        "truth.json": lambda: taken(folder, "truth.json") if data_set(folder) else {},
        "vehicle": lambda: taken(models, "bluerov2.toml", "bluerov2.xml", "t200.csv"),
        "MJCF": lambda: taken(models, "bluerov2.xml", "basin.xml"),
        "fins": lambda: taken(models, "remus100.toml", "remus100.xml"),
    }[kind]()


def json_of(files: Files, name: str) -> Any:
    """A sound JSON file."""
    return json.loads(files[name].encode("latin-1"))
