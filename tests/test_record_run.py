"""Runs as CSV: what is read, what is refused and how it is said, and that writing is exact and repeatable."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vtank.errors import InputError
from vtank.record import Run, read_run, write_run

HEADER = "time_s,n_rev_s,range_m"
ROWS = [f"{0.1 * k:.1f},{k % 3},{3 - 0.01 * k:.2f}" for k in range(20)]


def csv(tmp_path: Path, *lines: str, end: str = "\n") -> Path:
    path = tmp_path / "run.csv"
    path.write_bytes((end.join(lines) + end).encode())
    return path


def changed(row: int, line: str) -> list[str]:
    """The sound rows with one of them replaced; row r is line r + 2 of the file."""
    return [*ROWS[:row], line, *ROWS[row + 1 :]]


def a_run(**columns: np.ndarray) -> Run:
    time_s = np.arange(12) * 0.1
    return Run("a", time_s, {"n_rev_s": np.linspace(-5, 5, 12), "range_m": np.full(12, 3.0)} | columns)


def test_a_sound_file_is_read_as_it_stands(tmp_path: Path) -> None:
    run = read_run(csv(tmp_path, HEADER, *ROWS))
    assert run.name == "run"
    assert run.input == "n_rev_s"
    assert run.outputs == ("range_m",)
    assert run.duration_s == 1.9
    np.testing.assert_array_equal(run.time_s, [float(f"{0.1 * k:.1f}") for k in range(20)])
    np.testing.assert_array_equal(run.columns["range_m"], [float(f"{3 - 0.01 * k:.2f}") for k in range(20)])


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends_blanks_quotes_and_byte_order_mark_make_no_difference(tmp_path: Path, end: str) -> None:
    plain = read_run(csv(tmp_path, HEADER, *ROWS))
    dressed = [ROWS[0].replace(",", " , "), '"0.1","1","2.99"', *ROWS[2:]]
    run = read_run(csv(tmp_path, '\ufeff"time_s", n_rev_s,range_m', *dressed, "", end=end))
    for name, values in plain.columns.items():
        np.testing.assert_array_equal(run.columns[name], values)


def test_empty_cells_are_missing_samples_so_channels_have_their_own_rates(tmp_path: Path) -> None:
    rows = [f"{0.1 * k:.1f},{k},{'' if k % 5 else k / 10}" for k in range(60)]
    run = read_run(csv(tmp_path, HEADER, *rows))
    time_s, range_m = run.samples("range_m")
    np.testing.assert_allclose(time_s, np.arange(12) * 0.5)
    np.testing.assert_allclose(range_m, np.arange(12) * 0.5)
    assert run.samples("n_rev_s")[0].size == 60


def test_channels_are_laid_on_the_union_of_their_times() -> None:
    fast, slow = np.arange(20) * 0.1, np.arange(15) * 0.25
    run = Run.from_channels("a", {"n_rev_s": (slow, -slow), "surge_m_s": (fast, fast**2)})
    assert np.all(np.diff(run.time_s) > 0)
    assert set(run.time_s) == set(fast) | set(slow)
    for name, (time_s, values) in {"n_rev_s": (slow, -slow), "surge_m_s": (fast, fast**2)}.items():
        np.testing.assert_array_equal(run.samples(name)[0], time_s)
        np.testing.assert_array_equal(run.samples(name)[1], values)


# What is wrong -> the lines of the file, the parts that the message must hold.
FAULTY = {
    "truncated": ([HEADER, *ROWS, "2.0,1"], ["line 22", "2 of 3 cells", "truncated"]),
    "no rows": ([HEADER], ["no rows"]),
    "empty": ([""], ["empty"]),
    "no header": (ROWS, ["line 1", "header", "'0.0,0,3.00'"]),
    "text": ([HEADER, *changed(7, "0.7,fast,2.9")], ["line 9", "column n_rev_s", "'fast'", "number"]),
    "nan": ([HEADER, *changed(3, "0.3,NaN,2.9")], ["line 5", "column n_rev_s", "'NaN'"]),
    "inf": ([HEADER, *changed(3, "0.3,1,-inf")], ["line 5", "column range_m", "'-inf'"]),
    "overflow": ([HEADER, *changed(3, "0.3,1,1e999")], ["line 5", "column range_m", "'1e999'"]),
    "underscore": ([HEADER, *changed(3, "0.3,1_0,2.9")], ["line 5", "column n_rev_s", "'1_0'"]),
    "other digits": ([HEADER, *changed(3, "0.3,١,2.9")], ["line 5", "column n_rev_s"]),
    "half a number": ([HEADER, *changed(3, "0.3,1e,2.9")], ["line 5", "column n_rev_s", "'1e'"]),
    "decimal comma": ([HEADER, *changed(3, "0.3,1,2,9")], ["line 5", "4 cells", "expected 3"]),
    "blank line": ([HEADER, *changed(3, "")], ["line 5", "empty line"]),
    "short line": ([HEADER, *changed(3, "0.3,1")], ["line 5", "2 cells", "expected 3"]),
    "time stands": ([HEADER, *changed(9, "0.8,1,2.9")], ["line 11", "time_s", "0.8 after 0.8", "increasing"]),
    "time falls": ([HEADER, *changed(9, "0.2,1,2.9")], ["line 11", "time_s", "0.2 after 0.8", "increasing"]),
    "time missing": ([HEADER, *changed(9, ",1,2.9")], ["line 11", "time_s", "missing"]),
    "column empty": ([HEADER, *(f"{k},1," for k in range(20))], ["column range_m", "no value"]),
    "no time": (["t,n_rev_s,range_m", *ROWS], ["time_s", "t, n_rev_s, range_m"]),
    "no input": (["time_s,rpm,range_m", *ROWS], ["n_rev_s, command, thrust_N", "time_s, rpm, range_m"]),
    "two inputs": (["time_s,n_rev_s,command,range_m", *ROWS], ["exactly one", "n_rev_s and command"]),
    "no output": (["time_s,n_rev_s,range_cm", *ROWS], ["range_m, position_m, surge_m_s", "range_cm"]),
    "column twice": (["time_s,n_rev_s,range_m,range_m", *ROWS], ["range_m appears more than once"]),
    "nameless": (["time_s,n_rev_s,range_m,", *ROWS], ["column 4 has no name"]),
    "command": (
        ["time_s,command,surge_m_s", *(f"{k},{0.1 * k:.1f},0" for k in range(20))],
        ["line 13", "command", "1.1", "-1..1"],
    ),
    "too short": ([HEADER, *ROWS[:9]], ["9 samples", "at least 10"]),
    "too few samples": ([HEADER, *(f"{k},1,{'' if k % 5 else k}" for k in range(20))], ["4 samples", "at least 10"]),
}


@pytest.mark.parametrize("fault", FAULTY)
def test_a_faulty_file_is_refused_with_its_place(tmp_path: Path, fault: str) -> None:
    lines, parts = FAULTY[fault]
    path = csv(tmp_path, *lines)
    with pytest.raises(InputError) as caught:
        read_run(path)
    for part in [str(path), *parts]:
        assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_not_text_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    path.write_bytes(b"time_s,n_rev_s,range_m\n0,1,\xff\n")
    with pytest.raises(InputError, match="line 2: not UTF-8 text .byte 0xff"):
        read_run(path)


def test_a_folder_and_an_absent_file_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder"):
        read_run(tmp_path)
    with pytest.raises(InputError, match=r"absent\.csv: cannot be read"):
        read_run(tmp_path / "absent.csv")


def test_any_cut_of_a_file_is_read_or_refused_but_never_fails_otherwise(tmp_path: Path) -> None:
    whole = csv(tmp_path, HEADER, *ROWS).read_bytes()
    path, refused = tmp_path / "cut.csv", 0
    for size in range(0, len(whole), 3):
        path.write_bytes(whole[:size])
        try:
            read_run(path)
        except InputError:
            refused += 1
    assert refused > len(whole) / 9  # at least every cut within the first ten rows


def test_what_is_written_comes_back_to_the_stated_digits(tmp_path: Path) -> None:
    draw = np.random.default_rng(1)
    values = draw.normal(size=12) * 10.0 ** draw.integers(-8, 8, size=12)
    run = a_run(range_m=np.where(np.arange(12) == 4, np.nan, np.abs(values)))
    run.columns["position_m"] = values
    write_run(tmp_path / "a.csv", run)
    back = read_run(tmp_path / "a.csv")
    assert list(back.columns) == list(run.columns)
    for name, written in run.columns.items():
        np.testing.assert_array_equal(np.isnan(back.columns[name]), np.isnan(written))
        np.testing.assert_allclose(back.columns[name], written, rtol=1e-15, atol=0.5e-6)


def test_reading_and_writing_again_gives_the_same_bytes(tmp_path: Path) -> None:
    draw = np.random.default_rng(2)
    first = write_run(tmp_path / "a.csv", a_run(position_m=draw.normal(size=12)))
    second = write_run(tmp_path / "b.csv", read_run(tmp_path / "a.csv"))
    assert first == second == (tmp_path / "b.csv").read_bytes()


def test_cells_are_short_and_zero_has_no_sign() -> None:
    from vtank.record.writer import run_bytes

    run = a_run(
        position_m=np.array([0.1 + 0.2, -0.0, -1e-9, 1e-7, 12.5, 100.0, *[np.nan] * 5, -3.0]), surge_m_s=np.ones(12)
    )
    cells = [line.split(",")[3] for line in run_bytes(run).decode().splitlines()[1:]]
    assert cells == ["0.3", "0", "0", "0", "12.5", "100", "", "", "", "", "", "-3"]


def test_more_decimals_carry_a_finer_recording(tmp_path: Path) -> None:
    fine = np.arange(12) * 1e-8
    write_run(tmp_path / "a.csv", a_run(range_m=fine), decimals=9)
    np.testing.assert_allclose(read_run(tmp_path / "a.csv").columns["range_m"], fine, atol=1e-16)


@pytest.mark.parametrize(
    ("run", "message"),
    [
        (a_run(range_m=np.full(12, np.inf)), "infinite"),
        (a_run(range_m=np.full(12, np.nan)), "no value"),
        (a_run(command=np.zeros(12)), "exactly one"),
        (Run("a", np.zeros(12), a_run().columns), "increasing"),
        (Run("a", np.arange(12) * 1e-7, a_run().columns), "both written as 0 s"),
    ],
)
def test_a_run_that_could_not_be_read_back_is_not_written(tmp_path: Path, run: Run, message: str) -> None:
    with pytest.raises(InputError, match=message):
        write_run(tmp_path / "a.csv", run)
    assert list(tmp_path.iterdir()) == []


def test_a_failed_write_leaves_what_was_there(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        write_run(tmp_path / "file" / "a.csv", a_run())
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_columns_of_another_length_are_a_programming_error() -> None:
    with pytest.raises(ValueError, match="shape"):
        Run("a", np.arange(12.0), {"n_rev_s": np.zeros(11)})


def test_asking_for_an_unknown_channel_names_those_there_are() -> None:
    with pytest.raises(InputError, match="run a: no column surge_m_s; it has n_rev_s, range_m"):
        a_run().samples("surge_m_s")


def test_foreign_recordings_are_read_whole(recordings: Path) -> None:
    catamaran = read_run(recordings / "kingfisher_2017" / "run_01.csv")
    assert (catamaran.input, catamaran.outputs, catamaran.time_s.size) == ("command", ("surge_m_s",), 1079)
    drive = read_run(recordings / "emps_estimation" / "run_1.csv")
    assert (drive.input, drive.outputs, drive.time_s.size) == ("thrust_N", ("position_m",), 2485)
    reference = np.loadtxt(recordings / "emps_estimation" / "run_1.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(drive.columns["position_m"], reference[:, 2])


def test_a_table_that_is_not_a_run_is_refused(recordings: Path) -> None:
    with pytest.raises(InputError, match="no column time_s"):
        read_run(recordings / "t200_static.csv")


@pytest.mark.parametrize(
    ("rows", "line", "words"),
    [
        (["0.5,1200,2.95" if k == 5 else row for k, row in enumerate(ROWS)], 7, "found 1200, expected rev/s within"),
        (["0.5,2,-2.95" if k == 5 else row for k, row in enumerate(ROWS)], 7, "found -2.95, expected a distance of 0"),
        ([f"{100 * k},{row.split(',', 1)[1]}" for k, row in enumerate(ROWS)], 3, "rows 100 s apart, expected 10 s"),
    ],
)
def test_values_of_another_unit_are_refused(tmp_path: Path, rows: list[str], line: int, words: str) -> None:
    path = csv(tmp_path, HEADER, *rows)
    with pytest.raises(InputError) as found:
        read_run(path)
    assert str(found.value).startswith(f"{path}, line {line}: column ") and words in str(found.value)
