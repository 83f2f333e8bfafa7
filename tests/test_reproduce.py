"""`vtank reproduce` end to end on little effort: tables, figures, findings, folders."""

from __future__ import annotations

import csv
import io
import json
import re
import struct
import zlib

import numpy as np
import pytest

from vtank.cli import main
from vtank.errors import InputError
from vtank.experiment import plan_all, simulate_surge
from vtank.present.document import literal, markdown
from vtank.record import read_dataset, read_truth
from vtank.record.folder import results_folder
from vtank.studies.paper import run as reproduction
from vtank.studies.paper.campaign import PIECES, SCENARIOS, identify_campaign
from vtank.studies.paper.overview import overview
from vtank.studies.paper.published import SETS, published
from vtank.studies.paper.run import REPRODUCTION
from vtank.studies.paper.tables import SOURCES, Entry, entries, paper_form, tables_csv

FIGURES = {f"figure-{n}" for n in "01a 01b 02a 02b 03 04 05 06 07a 07b 08 09a 09b 10a 10b 11a 11b 12".split()}
LITTLE = reproduction.Effort(1, 2, 1)


@pytest.fixture(scope="module")
def campaign():
    notes: list[str] = []
    found = identify_campaign(simulate_surge(plan_all(SCENARIOS, seed=1996, truth="paper-ii")), notes.append)
    assert len(notes) == PIECES
    return found


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A reproduction by the command, with one seed."""
    out = tmp_path_factory.mktemp("reproduce") / "out"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reproduction, "QUICK", LITTLE)
        assert main(["reproduce", "--out", str(out), "--truth", "paper-ii", "--quick", "--seed", "3"]) == 0
    return out


def look_at(path):
    """Number of distinct bytes in the pixels of a PNG, and its width and height [pixels]."""
    data, place, chunks = path.read_bytes(), 8, b""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    while place < len(data):
        size, kind = struct.unpack(">I4s", data[place : place + 8])
        body = data[place + 8 : place + 8 + size]
        if kind == b"IHDR":
            width, height = struct.unpack(">II", body[:8])
        chunks += body if kind == b"IDAT" else b""
        place += 12 + size
    return np.unique(np.frombuffer(zlib.decompress(chunks), np.uint8)).size, width, height


# --- what the command leaves ---------------------------------------------------------------------------------------


@pytest.mark.slow
def test_every_figure_of_the_paper_is_drawn(written):
    assert {file.stem for file in (written / "paper-ii").glob("*.png")} == FIGURES
    for file in (written / "paper-ii").glob("*.png"):
        values, width, height = look_at(file)
        assert width > 900 and height > 300 and values > 60 and file.stat().st_size > 15_000


@pytest.mark.slow
def test_study_has_its_pictures_tables_and_page(written):
    assert {file.stem for file in written.glob("*.png")} == set(reproduction.STUDY_PICTURES)
    rows = list(csv.DictReader(io.StringIO((written / "study.csv").read_text())))
    assert {row["truth"] for row in rows} == {"paper-ii", "paper-iii", "physical"}
    assert {"Q", "filter q", "filter on n", "part", "noise", "record", "Model III"} <= {r["factor"] for r in rows}
    findings = (written / "findings.md").read_text()
    assert len(re.findall(r"supported(: at T = [^*]* s| at (every|any) T)?\.\*\*", findings)) == 18
    assert "not supported" in findings and "judged together" in findings
    assert " nan " not in findings and "inf " not in findings
    page = (written / "index.html").read_text()
    assert "Identified and true (feet, as in the paper)" in page and "maximum likelihood, all four" in page


@pytest.mark.slow
def test_pages_fit_a_telephone_and_lead_to_files_that_exist(written, fits):
    for page in (written / "index.html", written / "paper-ii" / "index.html"):
        text = page.read_text()
        targets = set(re.findall(r'(?:src|href)="([^"]+)"', text)) - {"data:,"}
        assert targets and all((page.parent / target).exists() for target in targets) and fits(page)


@pytest.mark.slow
def test_data_sets_stand_apart_from_other_tables(written):
    data = read_dataset(written / "data" / "paper-ii")
    assert [run.name for run in data] == ["paper-ds1", "paper-ds2", "paper-ds3", "paper-ds4"]
    assert {run["seed"] for run in read_truth(data.path)["runs"]} == {3}


@pytest.mark.slow
def test_results_replace_earlier_results_only(written, tmp_path, capsys):
    marker = json.loads((written / REPRODUCTION.marker).read_text())
    present = {file.relative_to(written).as_posix() for file in written.rglob("*") if file.is_file()}
    assert set(marker["files"]) | {REPRODUCTION.marker} == present and marker["seed"] == 3
    (tmp_path / "notes.txt").write_text("mine")
    assert main(["reproduce", "--out", str(tmp_path)]) == 2
    assert "choose another folder" in capsys.readouterr().err and (tmp_path / "notes.txt").exists()


def test_bad_seed_is_refused(tmp_path, capsys):
    for command in ("reproduce", "demo"):
        assert main([command, "--out", str(tmp_path / "x"), "--seed", "-1"]) == 2
        assert "--seed -1" in capsys.readouterr().err


def test_folder_keeps_what_was_there_after_a_failure(tmp_path):
    with results_folder(tmp_path / "r", REPRODUCTION, {"seed": 1}) as folder:
        (folder / "a.txt").write_text("first")
    with pytest.raises(RuntimeError), results_folder(tmp_path / "r", REPRODUCTION, {"seed": 2}) as folder:
        (folder / "a.txt").write_text("second")
        raise RuntimeError
    assert (tmp_path / "r" / "a.txt").read_text() == "first"
    (tmp_path / "r" / "mine.txt").write_text("x")
    with pytest.raises(InputError, match="holds mine.txt"), results_folder(tmp_path / "r", REPRODUCTION):
        pass


# --- tables --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_tables_hold_published_true_and_estimated_values(campaign, number):
    table = paper_form(campaign, number)
    assert len(table.rows) == len(published()[number].quantities) * len(SOURCES)
    text = markdown([table])
    for quantity in published()[number].quantities:
        for i, value in enumerate(published()[number].values[quantity].tolist()):
            shown = f"{value:.4f}" if np.isfinite(value) else "-"
            assert f" {shown}{literal(published()[number].mark(quantity, i + 1))} |" in text


def test_truth_rows_tell_the_preset_and_what_a_perfect_model_leaves(campaign):
    found = {(e.quantity, e.data_set): e.value for e in entries(campaign, 2) if e.source == "truth"}
    assert found["a", "1"] == pytest.approx(-0.7791) and found["tau", "1-4"] == pytest.approx(0.7074)
    assert 0.02 < found["deviation", "1"] < 0.1
    perfect = campaign.signals(0).u_m_s - campaign.true_u_m_s(0)
    assert found["deviation", "1"] == pytest.approx(perfect.std() / 0.3048)


def test_maximum_likelihood_finds_the_truth_where_least_squares_does_not(campaign):
    found = {(e.source, e.quantity): e for e in entries(campaign, 2) if e.data_set in ("1-4", "1")}
    truth = {e.quantity: e.value for e in entries(campaign, 2) if e.source == "truth" and e.data_set == "1-4"}
    for quantity in ("a", "b", "tau"):
        joint = found["likelihood", quantity]
        assert abs(joint.value - truth[quantity]) < 4.0 * joint.sd
    assert abs(found["least_squares", "tau"].value - truth["tau"]) > 0.2


def test_csv_holds_every_number_of_the_tables(campaign):
    rows = list(csv.DictReader(io.StringIO(tables_csv(campaign))))
    assert len(rows) == sum(len(entries(campaign, number)) for number in published())
    printed = [row for row in rows if row["source"] == "published" and row["value"]]
    expected = sum(np.isfinite(t.values[q]).sum() for t in published().values() for q in t.quantities)
    assert len(printed) == expected and all(float(row["value"]) for row in printed)


def test_entries_are_printed_like_the_papers():
    assert Entry(2, "1", "a", "published", -0.7791, mark="*").text == "-0.7791*"
    assert Entry(2, "1", "a", "published", float("nan"), mark="?").text == "-?"
    assert (
        Entry(2, "1", "b", "paper", -3.7e-6).text == "-4e-06" and Entry(2, "1", "gamma", "truth", 0.0).text == "0.0000"
    )
    assert Entry(2, "1", "b", "likelihood", 0.00160021, 0.0000022).text == "0.0016002 ± 0.0000022"


def test_overview_compares_truth_and_estimates(campaign):
    table = overview({"paper-ii": campaign})
    assert [row[0] for row in table.rows if row[0]] == ["Model I, paper-ii", "Model II, paper-ii"]
    assert table.rows[4][2:] == ("-0.7791", "0.0016", "", "0.7074")


def test_campaigns_need_four_runs_of_one_truth(campaign):
    assert len(campaign.results) == SETS and campaign.truth.name == "paper-ii"
    assert set(campaign.joint) == {"I", "II", "III"}
