"""Made, answered and scored: nothing leaks, every change is caught, and the score is that of the answers."""

from __future__ import annotations

import json
import shutil
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.present.document import markdown
from vtank.record import Run, jsonable, read_dataset, read_run, sha256
from vtank.studies.blind.answer import answer, refusal
from vtank.studies.blind.case import tied
from vtank.studies.blind.closed import Closed, closed
from vtank.studies.blind.make import Order, make
from vtank.studies.blind.questions import measures
from vtank.studies.blind.rows import Row, visible
from vtank.studies.blind.score import _row, grouped, score, write_score
from vtank.studies.blind.seal import EPOCH_S, canonical, commitment, digest, fixed_csv, json_bytes, read_index
from vtank.studies.blind.tables import tables
from vtank.studies.blind.verify import open_all

ORDER = Order(3, 48, ("none", "parameters", "single"), ("supply_sag",), familiar=True, threads=1)


def stand_in(folder: Path, seed: int, withheld: tuple[str, ...], nominal: str) -> dict[str, Any]:
    """An answer without a diagnosis: a fixed opinion, and no opinion on the second case."""
    runs = read_dataset(folder)
    if folder.name == "case_0002":
        raise ValueError("cannot say")
    chances = {"none": 0.2, "supply_sag": 0.7, "unknown": 0.1}
    verdict = {"kind": "effect", "effects": ["supply_sag"], "class": ["supply_sag", "clock_skew"], "probability": 0.7}
    document = {"verdict": verdict, "probabilities": chances, "runs": len(runs)}
    return {"document": document, "seen": float(np.nanmean(runs.runs[0].columns["range_m"]))}


UNSURE = {"verdict": {"kind": "undecided"}, "probabilities": {"none": 1.0}}


@pytest.fixture(scope="module")
def trials(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with cases, truth and answers."""
    root = tmp_path_factory.mktemp("blind")
    make(ORDER, root / "cases", root / "truth")
    with pytest.warns(UserWarning, match="case_0002"):
        answer(root / "cases", root / "answers.json", count=1, answer_case=stand_in)
    return root


@pytest.fixture
def copy(trials: Path, tmp_path: Path) -> Path:
    """A copy to tamper with."""
    shutil.copytree(trials, tmp_path / "copy")
    return tmp_path / "copy"


def verify(root: Path) -> None:
    open_all(root / "cases", root / "truth", root / "answers.json")


# --- nothing leaks -----------------------------------------------------------------------------------------------
def test_files_differ_in_nothing_but_their_numbers(trials: Path) -> None:
    files = sorted((trials / "cases").rglob("*.csv"))
    assert [str(f.relative_to(trials / "cases")) for f in files] == [
        f"case_{case:04d}/run_{run}.csv" for case in (1, 2, 3) for run in (1, 2, 3, 4)
    ]
    assert {path.stat().st_mtime for path in (trials / "cases").rglob("*")} == {EPOCH_S}
    assert len({f.stat().st_size for f in files}) == 1
    widths = {tuple(len(cell) for cell in line.split(",")) for f in files for line in f.read_text().splitlines()[1:]}
    assert len(widths) == 1
    assert {f.read_text().splitlines()[0] for f in files} == {"time_s,n_rev_s,range_m"}


def test_the_index_says_nothing_but_names_hashes_and_what_is_withheld(trials: Path) -> None:
    text = (trials / "cases" / "cases.json").read_text()
    content = json.loads(text)
    assert set(content) == {"schema", "cases", "order"} and {case["nominal"] for case in content["cases"]} == {
        "paper-ii"
    }
    assert all(set(case) == {"case", "nominal", "runs", "withheld", "commitment"} for case in content["cases"])
    assert "48" not in json.dumps([case["withheld"] for case in content["cases"]]) and "seed" not in text


@pytest.mark.parametrize("seed", range(4))
def test_any_run_takes_the_same_bytes(seed: int) -> None:
    random = np.random.default_rng(seed)
    size, time = 50, 0.1 * np.arange(50)
    range_m = np.where(random.random(size) < 0.3 * seed, np.nan, random.normal(3.0, 0.5, size))
    run = Run("run", time, {"n_rev_s": random.normal(0.0, 5.0 * seed, size), "range_m": range_m})
    assert len(fixed_csv(run)) == len("time_s,n_rev_s,range_m\n") + size * (10 + 11 + 9 + 3)


def test_a_written_run_is_read_back(tmp_path: Path) -> None:
    columns = {"n_rev_s": np.linspace(-20.0, 20.0, 20), "range_m": np.where(np.arange(20) % 4, 3.0, np.nan)}
    (tmp_path / "run.csv").write_bytes(fixed_csv(Run("run", 0.1 * np.arange(20), columns)))
    back = read_run(tmp_path / "run.csv")
    assert back.columns["n_rev_s"] == pytest.approx(columns["n_rev_s"], abs=5.1e-6)
    assert np.array_equal(np.isnan(back.columns["range_m"]), np.isnan(columns["range_m"]))


def test_a_commitment_hides_and_binds() -> None:
    truth, salt = {"kind": "none", "d": 0.0}, "0a" * 32
    assert commitment(salt, truth) != commitment("0b" * 32, truth)
    assert commitment(salt, truth) != commitment(salt, truth | {"d": 1e-9})
    for forged in (None, "", 7, salt[:-2], salt + '{"kind":', salt.upper()):
        assert commitment(forged, truth) == ""
    assert commitment(salt, {"d": float("inf")}) == ""
    assert canonical({"b": 1, "a": [1.5]}) == b'{"a":[1.5],"b":1}' == canonical({"a": [1.5], "b": 1})
    with pytest.raises(ValueError):
        canonical({"d": float("nan")})


# --- what was made -----------------------------------------------------------------------------------------------
def test_the_tank_flew_what_the_truth_says(trials: Path) -> None:
    """Ranges scatter about the noise-free ones by the sonar's noise, where nothing else disturbs the hull."""
    quiet = 0
    for entry in read_index(trials / "cases").entries:
        truth = json.loads((trials / "truth" / f"{entry.case}.json").read_text())["truth"]
        experiment = truth["experiment"]
        if experiment["turbulence"] == "still":
            quiet += 1
            for k in (1, 3):
                run = read_run(trials / "truth" / "held_out" / entry.case / f"run_{k}.csv")
                error = run.columns["range_m"] - run.columns["clean_m"]
                expected = np.hypot(experiment["sonar_noise_m"], experiment["resolution_m"] / np.sqrt(12.0))
                assert np.nanstd(error) == pytest.approx(expected, rel=0.08)
                assert abs(np.nanmean(error)) < 4.0 * expected / np.sqrt(error.size)
    assert quiet


def test_truths_carry_what_the_score_needs(trials: Path) -> None:
    for path in sorted((trials / "truth").glob("case_*.json")):
        truth = json.loads(path.read_text())["truth"]
        assert truth["label"] in ("none", "parameters", "supply_sag")
        assert sum(truth["budget"].values()) == pytest.approx(1.0)
        assert len(truth["held_out"]["oracle"]) == len(truth["held_out_files"]) == 3
        if truth["kind"] == "single":
            assert truth["d"] == pytest.approx(truth["d_each"][0], rel=1e-3) and truth["d"] > 2.0
            assert truth["causes"][0]["channel"] == "actuator"
            assert np.mean(truth["held_out"]["oracle"]) < np.mean(truth["held_out"]["refit"])
        else:
            assert truth["d"] < 0.05


def test_make_refuses_a_folder_that_is_there(trials: Path) -> None:
    with pytest.raises(InputError, match=r"holds case_0001, case_0002, .*vtank deletes nothing of yours"):
        make(ORDER, trials / "cases", trials / "elsewhere")


# --- every change is caught and named ------------------------------------------------------------------------------
def test_untouched_trials_verify(trials: Path) -> None:
    verify(trials)


def change(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def test_a_changed_recording_is_named(copy: Path) -> None:
    change(copy / "cases" / "case_0002" / "run_3.csv", "    0.1000,", "    0.2000,")
    with pytest.raises(InputError, match="case_0002/run_3.csv: the recording was changed"):
        verify(copy)
    with pytest.raises(InputError, match="run_3.csv: not the recording"):
        answer(copy / "cases", copy / "new.json", count=1, answer_case=stand_in)


def test_a_changed_truth_is_named(copy: Path) -> None:
    change(copy / "truth" / "case_0001.json", '"label": "', '"label": "x')
    with pytest.raises(InputError, match="case_0001.json: the truth is not the one that was sealed"):
        verify(copy)


def test_a_truth_of_another_case_is_named(copy: Path) -> None:
    shutil.copy(copy / "truth" / "case_0001.json", copy / "truth" / "case_0003.json")
    with pytest.raises(InputError, match="case_0003.json: the truth is not"):
        verify(copy)


def test_a_truth_with_a_new_commitment_is_caught_by_the_seal(copy: Path) -> None:
    path = copy / "truth" / "case_0001.json"
    sealed = json.loads(path.read_text())
    sealed["truth"]["label"] = "supply_sag"
    path.write_text(json.dumps(sealed))
    index = json.loads((copy / "cases" / "cases.json").read_text())
    index["cases"][0]["commitment"] = commitment(sealed["salt"], sealed["truth"])
    (copy / "cases" / "cases.json").write_text(json.dumps(index))
    with pytest.raises(InputError, match="seal.json: made for other cases") as found:
        verify(copy)
    assert "answers to other cases" in str(found.value)


@pytest.mark.parametrize(
    ("key", "value"), [("seed", 49), ("trials", 2), ("kinds", ["single"]), ("familiar", False), ("threads", 2)]
)
def test_a_changed_seed_or_order_is_named(key: str, value: object, copy: Path) -> None:
    path = copy / "truth" / "seal.json"
    seal = json.loads(path.read_text())
    seal["order"][key] = value
    path.write_text(json.dumps(seal))
    with pytest.raises(InputError, match="seal.json: seed, order or versions are not those that were sealed"):
        verify(copy)


@pytest.mark.parametrize("salt", ["00" * 32, "", 7])
def test_a_changed_salt_is_named(salt: object, copy: Path) -> None:
    for file, words in {"case_0001.json": "the truth is not the one", "seal.json": "seed, order or versions"}.items():
        path = copy / "truth" / file
        path.write_text(json.dumps(json.loads(path.read_text()) | {"salt": salt}))
        with pytest.raises(InputError, match=f"{file}: {words}"):
            verify(copy)


@pytest.mark.parametrize("name", ["..", "", "../cases", ".", "a/b", "/etc", 7])
def test_names_that_lead_elsewhere_are_refused(name: object, copy: Path) -> None:
    for key in ("case", "nominal", "runs"):
        path = copy / "cases" / "cases.json"
        index = json.loads((path).read_text())
        index["cases"][0][key] = {str(name): "0"} if key == "runs" else name
        (copy / "forged").mkdir(exist_ok=True)
        (copy / "forged" / "cases.json").write_text(json.dumps(index))
        if (key, name) != ("runs", 7):
            with pytest.raises(InputError, match="expected the name of a case or of a run"):
                read_index(copy / "forged")


def forge(root: Path) -> None:
    """Another answer to the first case, and all hashes of the answers made anew to fit."""
    path = root / "answers.json"
    content = json.loads(path.read_text())
    content["answers"]["case_0001"]["document"]["probabilities"] = {"none": 1.0}
    data = json_bytes(content)
    path.write_bytes(data)
    lines = [f"{sha256(data)}  answers.json", *(f"{digest(a)}  {case}" for case, a in content["answers"].items())]
    path.with_suffix(".sha256").write_text("\n".join(lines) + "\n")


def test_answers_forged_with_their_hashes_are_told_by_the_published_one(
    copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    published = sha256((copy / "answers.json").read_bytes())
    command = ["blind", "score", str(copy / "cases"), "--truth", str(copy / "truth"), "--processes", "1"]
    command += ["--answers", str(copy / "answers.json"), "--out", str(copy / "score")]
    assert main([*command, "--published", published]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert (
        f"Answers: one to each case, given to these recordings with seed 0; SHA-256 {published}, as published" in said
    )
    assert "3 with 12 recordings" in said and "3 with 9 held-out runs" in said and '"seed":48' in said
    forge(copy)
    assert main([*command, "--published", published]) == 2
    assert f"but {published} was published" in capsys.readouterr().err
    assert main(command) == 0  # nobody can tell, and that is said
    assert "NOT held against a published one" in " ".join(capsys.readouterr().out.split())
    assert "NOT held against" in (copy / "score" / "score.md").read_text()
    assert main([*command, "--published", "b8206f42"]) == 2 and "64 hexadecimal" in capsys.readouterr().err


@pytest.mark.parametrize("broken", [{"label": 7}, {"experiment": []}, {"held_out": 3}, {"causes": None, "kind": None}])
def test_a_truth_that_is_none_is_no_traceback(broken: dict[str, Any], trials: Path) -> None:
    """Whoever makes cases may commit to anything."""
    opened = open_all(trials / "cases", trials / "truth", trials / "answers.json")
    opened.truths["case_0001"] = {k: v for k, v in opened.truths["case_0001"].items() if k not in broken} | {
        k: v for k, v in broken.items() if v is not None
    }
    with pytest.raises(InputError, match="case_0001: truth or answer is not as vtank writes it"):
        _row(opened, trials / "truth", "case_0001")


def test_a_changed_held_out_run_is_named(copy: Path) -> None:
    change(copy / "truth" / "held_out" / "case_0003" / "run_3.csv", "    0.1000,", "    0.2000,")
    with pytest.raises(InputError, match="case_0003/run_3.csv: the held-out run was changed"):
        verify(copy)


def test_a_changed_answer_is_named(copy: Path) -> None:
    change(copy / "answers.json", '"supply_sag": 0.7', '"supply_sag": 0.8')
    with pytest.raises(InputError, match="the answer to case_0001 is not the one that was committed to"):
        verify(copy)


def test_a_changed_commitment_to_all_answers_is_named(copy: Path) -> None:
    change(copy / "answers.json", '"seed": 0', '"seed": 1')
    with pytest.raises(InputError, match="changed since the answers were committed to"):
        verify(copy)


def test_the_command_refuses_with_exit_code_2(copy: Path, capsys: pytest.CaptureFixture[str]) -> None:
    change(copy / "answers.json", '"supply_sag": 0.7', '"supply_sag": 0.8')
    command = ["blind", "score", str(copy / "cases"), "--truth", str(copy / "truth"), "--processes", "1"]
    assert main([*command, "--answers", str(copy / "answers.json")]) == 2
    assert "the answer to case_0001" in capsys.readouterr().err
    assert main(["blind", "make", "--trials", "0", "--seed", "1", "--out", str(copy / "none")]) == 2
    assert main(["blind", "answer", str(copy)]) == 2
    assert main(["blind", "answer", str(copy / "cases"), "--seed", "-1"]) == 2
    assert "--seed -1: expected" in capsys.readouterr().err


# --- answers -----------------------------------------------------------------------------------------------------
def test_a_case_that_fails_is_a_refusal_with_uniform_probabilities_and_is_told(trials: Path, tmp_path: Path) -> None:
    def unfit(folder: Path, seed: int, withheld: tuple[str, ...], nominal: str) -> dict[str, Any]:
        raise InputError("no motion in it")

    with pytest.warns(UserWarning, match="case_0002: answered by a refusal, for vtank failed: ValueError: cannot say"):
        answer(trials / "cases", tmp_path / "again.json", count=1, answer_case=stand_in)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a case that a diagnosis refuses is not worth a warning
        answer(trials / "cases", tmp_path / "unfit.json", count=1, answer_case=unfit)
    given = json.loads((tmp_path / "unfit.json").read_text())["answers"]["case_0001"]
    assert given["refused"] == "no motion in it" and "fault" not in given
    answers = json.loads((trials / "answers.json").read_text())["answers"]
    refused = answers["case_0002"]
    assert refused["refused"] == "ValueError: cannot say"
    chances = refused["document"]["probabilities"]
    assert sum(chances.values()) == pytest.approx(1.0) and len(set(chances.values())) == 1
    assert {tied(name) for name in chances} == set(chances)
    assert "tether" not in refusal("", ("tether",))["document"]["probabilities"]


def test_answers_go_on_where_they_stopped(trials: Path, tmp_path: Path) -> None:
    asked: list[str] = []

    def interrupted(folder: Path, seed: int, withheld: tuple[str, ...], nominal: str) -> dict[str, Any]:
        asked.append(folder.name)
        if len(asked) == 3:
            raise KeyboardInterrupt
        return stand_in(folder, seed, withheld, nominal)

    out = tmp_path / "answers.json"
    with pytest.raises(KeyboardInterrupt):
        answer(trials / "cases", out, count=1, answer_case=interrupted)
    assert not out.exists()
    total = answer(trials / "cases", out, count=1, answer_case=interrupted)
    assert asked == ["case_0001", "case_0002", "case_0003", "case_0003"]
    assert out.read_bytes() == (trials / "answers.json").read_bytes()
    assert total in out.with_suffix(".sha256").read_text() and not out.with_name("answers.json.part").exists()
    asked.clear()
    answer(trials / "cases", out, count=1, answer_case=stand_in)  # the same once more
    with pytest.raises(InputError, match="of another seed, .* remove it and answers.sha256 to answer anew"):
        answer(trials / "cases", out, seed=1, count=1, answer_case=stand_in)
    assert out.read_bytes() == (trials / "answers.json").read_bytes()
    (tmp_path / "mine.json").write_text("{}")
    with pytest.raises(InputError, match="mine.json: is there already"):
        answer(trials / "cases", tmp_path / "mine.json", count=1, answer_case=stand_in)
    out.unlink()
    answer(trials / "cases", out, seed=1, count=1, answer_case=stand_in)
    assert out.read_bytes() != (trials / "answers.json").read_bytes()


def test_what_is_no_matter_of_a_case_is_no_answer(trials: Path, tmp_path: Path) -> None:
    def full(folder: Path, seed: int, withheld: tuple[str, ...], nominal: str) -> dict[str, Any]:
        raise MemoryError

    with pytest.raises(MemoryError):
        answer(trials / "cases", tmp_path / "answers.json", count=1, answer_case=full)
    assert not (tmp_path / "answers.json").exists()


def test_two_do_not_answer_into_one_file(trials: Path, tmp_path: Path) -> None:
    out = tmp_path / "answers.json"

    def second(folder: Path, seed: int, withheld: tuple[str, ...], nominal: str) -> dict[str, Any]:
        with pytest.raises(InputError, match="another process is answering into it"):
            answer(trials / "cases", out, count=1, answer_case=stand_in)
        return stand_in(folder, seed, withheld, nominal)

    with pytest.warns(UserWarning):
        answer(trials / "cases", out, count=1, answer_case=second)
    assert out.read_bytes() == (trials / "answers.json").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["answers.json", "answers.sha256"]


def test_a_kill_between_cases_and_truth_is_ended_by_the_next_go(
    trials: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cases, truth = tmp_path / "cases", tmp_path / "truth"
    left = tmp_path / ".cases.vtank-12345678"
    shutil.copytree(trials / "truth", truth)
    shutil.copytree(trials / "cases", left / "new")
    with pytest.raises(InputError, match="truth: holds"):  # another order is another matter
        make(replace(ORDER, seed=49), cases, truth)
    make(ORDER, cases, truth)
    answer(cases, tmp_path / "answers.json", count=1, answer_case=lambda *given: {"document": UNSURE})
    open_all(cases, truth, tmp_path / "answers.json")


def test_documents_are_made_plain() -> None:
    found = jsonable({"a": np.float64(1.5), "b": (np.arange(2), float("inf")), 3: None})
    assert found == {"a": 1.5, "b": [[0, 1], None], "3": None} and digest(found)


# --- score -------------------------------------------------------------------------------------------------------
def test_the_score_is_that_of_the_answers(trials: Path, tmp_path: Path, fits: Callable[[Path], bool]) -> None:
    scored = score(trials / "cases", trials / "truth", trials / "answers.json", count=1)
    rows: list[Row] = scored["rows"]
    labels = [row.label for row in rows]
    assert [row.right for row in rows] == [labels[0] == "supply_sag", rows[1].right, labels[2] == "supply_sag"]
    assert rows[0].named == ("supply_sag", "clock_skew") and rows[1].refused
    assert scored["measures"]["all"]["all"]["false alarm"].n == labels.count("none")
    assert set(scored["measures"]["family"]) == {row.kind for row in rows}
    write_score(tmp_path / "score", scored)
    written = {path.name for path in (tmp_path / "score").iterdir()}
    assert {"score.md", "score.json", "cases.csv", "measures.csv", "confusion.png", "reliability.png"} <= written
    assert fits(tmp_path / "score" / "score.html")
    document = json.loads((tmp_path / "score" / "score.json").read_text())
    assert document["cases"] == 3 and document["schema"] == "vtank.blind-score/2"


MODEL = """
schema = "vtank.model/1"
name = "diagnosed"
source = "written by hand"
input = "n_rev_s"
n_limit_rev_s = 20.0
[lumped]
{true}
[effects.supply_sag]
r_per_s = {r}
[nominal]
{nominal}
[refit]
{refit}
[noise]
range_m = {noise}
turbulence_m_s2 = 0.0
turbulence_time_s = 1.0
[verdict]
kind = "effect"
"""


def own(alpha: float, beta: float, tau: float) -> str:
    """The nominal's own parameters as a model file has them."""
    return f"alpha_per_m = {alpha}\nbeta_m_per_rev2 = {beta}\ngamma_per_rev = 0.0\ntau_s = {tau}"


def test_the_true_model_closes_the_whole_gap(trials: Path) -> None:
    paths = sorted((trials / "truth").glob("case_*.json"))
    truths = {path.stem: json.loads(path.read_text())["truth"] for path in paths}
    case = next(name for name, truth in truths.items() if truth["label"] == "supply_sag")
    truth, slots = truths[case], truths[case]["slots"][0]
    true = own(slots["alpha"], slots["beta"], slots["thrust_lag.tau"])
    off = own(1.2 * slots["alpha"], 0.9 * slots["beta"], slots["thrust_lag.tau"])
    text = MODEL.format(true=true, nominal=off, refit=off, r=slots["supply_sag.r"],
                        noise=truth["experiment"]["sonar_noise_m"])  # fmt: skip
    found = closed(case, truth, {"model": text, "document": {"shrink": {"interval90": [0.9, 1.1]}}}, trials / "truth")
    assert found.diagnosed < 1.1 * found.oracle < 0.1 * found.refit and found.fraction > 0.99
    assert found.realised == pytest.approx(1.0, abs=0.02) and found.covered
    without = closed(case, truth, {"document": {}}, trials / "truth")
    assert without.covered is None and np.isnan(without.diagnosed) and without.oracle == found.oracle


EXPERIMENT = {"vehicle": "phoenix", "noise": "white", "turbulence": "still", "family": "chirp", "rate_hz": 10,
              "runs": 4, "duration_s": 120.0}  # fmt: skip


def made_up(label: str, d: float, chances: dict[str, float], said: str = "effect", **more: Any) -> Row:
    """A row by hand; more: of the verdict, or kind, causes, budget and where of truth and document."""
    plain = {"none": "none", "parameters": "parameters", "varying": "varying", "unknown": "random"}
    several = ("single", "pair", "triple")[min(label.count("+"), 2)]
    truth = {"kind": more.pop("kind", plain.get(label, several)), "label": label, "experiment": EXPERIMENT,
             "causes": more.pop("causes", [])} | {"budget": more.pop("true", None)}  # fmt: skip
    apart = {key: more.pop(key) for key in ("budget", "where", "cause_set") if key in more}
    named = max(chances, key=lambda k: chances[k])
    verdict = {"kind": said, "class": [named], "effects": named.split("+"), "probability": max(chances.values())} | more
    closed = Closed(0.2, 0.1, 0.01, 0.019, (0.8, 1.0), 0.9)
    return Row("case", label, d, truth, {"verdict": verdict} | apart, chances, "", closed)


def asked(*rows: Row) -> dict[str, tuple[float, int]]:
    """Value and number of cases of every measure of these rows."""
    return {name: (m.value, m.n) for name, m in measures(rows).items() if m.n}


SURE, TORN = {"tether": 0.97, "seiche": 0.03}, {"tether": 0.6, "seiche": 0.4}


def test_effects_of_made_up_rows_by_hand() -> None:
    found = asked(made_up("tether", 20.0, SURE), made_up("seiche", 20.0, SURE), made_up("seiche", 5.0, TORN))
    assert found["single first"] == (0.5, 2) and found["kind right"] == (1.0, 2)
    assert found["wrong at 0.95"] == (1 / 3, 3) and found["known called unknown"] == (0.0, 3)
    assert found["gap closed, median"] == (pytest.approx(0.9), 2) and found["interval of the gap closed"] == (1.0, 3)
    triples = [made_up("a+b+c", 20.0, {"a+b+c": p, "a": 1.0 - p}, "effects") for p in (0.9, 0.3)]
    assert asked(*triples)["triple right or not confident"] == (1.0, 2)
    assert asked(made_up("a+b+c", 20.0, SURE))["triple right or not confident"] == (0.0, 1)


def test_no_gap_said_over_a_visible_one_and_alarms_by_hand() -> None:
    said = {"none": 1.0}
    found = asked(
        made_up("none", 0.0, said, "none"),
        made_up("none", 0.0, SURE),
        made_up("tether", 20.0, {"parameters": 0.9}, "parameters"),
        made_up("parameters", 20.0, {"parameters": 0.9}, "parameters"),
        made_up("parameters", 20.0, said, "none"),
        made_up("tether", 4.0, said, "none"),
    )
    assert found["false alarm"] == (0.5, 2)
    assert found["none or parameters over a visible gap"] == (2 / 3, 3)
    assert found["wrong at 0.95"] == (0.5, 6)  # the alarm, and none said twice of what is not too faint to see


def test_unknown_causes_their_channel_and_windows_by_hand() -> None:
    cause = {"name": "bump", "channel": "hydrodynamics", "windows": [[2, 10.0, 20.0]]}
    chances = {"unknown": 0.9, "tether": 0.1}

    def said(span: tuple[float, float], run: str = "run_2", channel: str = "hydrodynamics") -> Row:
        where = {"time_s": [{"run": run, "from": span[0], "to": span[1]}]}
        return made_up("unknown", 40.0, chances, "unknown", causes=[cause], where=where, channel=channel)

    assert said((12.0, 24.0)).windows_found() == (pytest.approx(0.8), pytest.approx(8.0 / 12.0))
    found = asked(said((12.0, 24.0)), said((12.0, 20.0), "run_1", "sensor"), made_up("unknown", 40.0, SURE))
    assert found["unknown called unknown"] == (2 / 3, 3)
    assert found["its channel"] == (0.5, 2) and found["its windows"] == (0.5, 2)
    assert asked(made_up("unknown", 6.0, SURE))["wrong at 0.95"] == (0.0, 1)  # known effects explain it as well


def test_varying_budget_and_stated_set_by_hand() -> None:
    causes, chances = [{"name": "beta"}], {"varying": 1.0}
    rows = [made_up("varying", 20.0, chances, "varying", causes=causes, varying=v) for v in (["beta"], ["alpha"])]
    assert asked(*rows)["varying found"] == (0.5, 2)
    assert "varying found" not in asked(made_up("varying", 12.0, chances, "varying", causes=causes))
    lines = [{"kind": "effect", "share": 0.4, "interval90": [0.3, 0.5]},
             {"kind": "noise", "share": 0.1, "interval90": [0.05, 0.15]}]  # fmt: skip
    true = {"parameters": 0.2, "cause": 0.45, "disturbance": 0.05, "noise": 0.3}
    found = asked(made_up("tether", 20.0, SURE, budget=lines, true=true, cause_set=["tether", "none"]))
    assert found["budget interval, effect"] == (1.0, 1) and found["budget interval, noise"] == (0.0, 1)
    assert found["stated set holds the truth"] == (1.0, 1)


def test_what_is_too_faint_to_see_counts_as_not_there() -> None:
    causes = [{"name": name} for name in ("linear_drag", "sonar_latency", "drag_asymmetry")]

    def seen(*d_each: float) -> tuple[str, float]:
        truth = {"label": "drag_asymmetry+linear_drag+sonar_latency", "causes": causes, "d_parameters": 50.0}
        return visible(truth | {"d_each": d_each})

    assert seen(32.0, 6.0, 0.8) == ("linear_drag+sonar_latency", 6.0)
    assert seen(2.0, 12.0, 0.8) == ("sonar_latency", 12.0)
    assert seen(2.0, 1.0, 0.8) == ("parameters", 50.0)
    assert not made_up("unknown", 6.0, SURE).fair and made_up("tether", 6.0, SURE).fair


def test_no_rows_make_no_score() -> None:
    assert "kind right" not in markdown(tables(grouped([])))


def test_who_interrupts_the_making_of_cases_is_told_that_it_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*given: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("vtank.studies.blind.make.make", interrupted)
    assert main(["blind", "make", "--trials", "2", "--seed", "7", "--out", str(tmp_path / "trials")]) == 130
    told = capsys.readouterr().err
    assert "the same command goes on from here" in told and "interrupted" in told
