"""Tables: every kind of fault is told with line, column and how to mend it; foreign layouts come in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from workbench.files.tables import (
    Column,
    Layout,
    Table,
    column_cells,
    number_text,
    read_table,
    table_text,
)

WANTED = [
    Column("pose_id", text=True, required=True),
    Column("target", text=True),
    *(Column(axis, ("length",), required=True, mend="leave the line out") for axis in "xyz"),
    Column("q1", ("angle",), subject="joint_1 turns"),
    Column("temp", ("temperature",), blank=True),
    Column("note", text=True, blank=True),
]
HEADER = "pose_id,target,x_mm,y_mm,z_mm\n"
BY_NUMBER = {"pose_id": 1, "target": 2, "x_mm": 3, "y_mm": 4, "z_mm": 5}


def read(tmp_path: Path, text: str | bytes, **layout: object) -> Table:
    path = tmp_path / "points.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return read_table(path, Layout.model_validate(layout), WANTED, "campaign.toml: points")


def faults(table: Table) -> list[str]:
    """The faults, with the file's bare name."""
    return [str(fault).replace(str(table.path), table.path.name) for fault in table.faults]


def test_reads_numbers_in_si_with_file_lines(tmp_path: Path) -> None:
    table = read(tmp_path, "\n" + HEADER + "1, T1 ,1000,-2e3,+.5\n\n,,,,\n 2,T2,1,2,3\n")
    assert faults(table) == []
    assert table.texts == {"pose_id": ["1", "2"], "target": ["T1", "T2"]}
    np.testing.assert_allclose(table.numbers["x"], [1.0, 0.001], rtol=1e-15)
    np.testing.assert_allclose(table.numbers["y"], [-2.0, 0.002], rtol=1e-15)
    assert table.lines.tolist() == [3, 6]


@pytest.mark.parametrize(
    ("name", "cell", "value"),
    [("q1_deg", "180", np.pi), ("q1_rad", "180", 180.0), ("temp_degC", "21", 21.0), ("temp_K", "300", 26.85)],
)
def test_units_by_suffix(tmp_path: Path, name: str, cell: str, value: float) -> None:
    table = read(tmp_path, f"pose_id,x_m,y_um,z_in,{name}\n1,1,1,1,{cell}\n")
    assert faults(table) == []
    assert table.numbers[name.split("_")[0]] == pytest.approx(value)
    assert [table.numbers[axis][0] for axis in "xyz"] == pytest.approx([1.0, 1e-6, 0.0254])


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_line_endings_and_byte_order_mark(tmp_path: Path, ending: str, mark: str) -> None:
    table = read(tmp_path, (mark + HEADER + "1,T1,1,2,3\n2,T1,1,2,n/m\n").replace("\n", ending))
    assert table.numbers["x"].tolist() == [0.001, 0.001]
    assert faults(table) == ["points.csv line 3: z_mm is 'n/m', not a number; leave the line out"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("1,T1,n/m,2,3", "points.csv line 2: x_mm is 'n/m', not a number; leave the line out"),
        ("1,T1,1,,3", "points.csv line 2: y_mm is empty; leave the line out"),
        ("1,T1,1,2,NaN", "points.csv line 2: z_mm is 'NaN', not a finite number; leave the line out"),
        ("1,T1,-inf,2,3", "points.csv line 2: x_mm is '-inf', not a finite number; leave the line out"),
        ("1,T1,1e999,2,3", "points.csv line 2: x_mm is '1e999', not a finite number; leave the line out"),
        ("1,T1,1_000,2,3", "points.csv line 2: x_mm is '1_000', not a number; leave the line out"),
        ('1,T1,"1,5",2,3', "points.csv line 2: x_mm is '1,5', not a number; say decimal = \",\""),
        (",T1,1,2,3", "points.csv line 2: pose_id is empty"),
        (
            "1,T1,1,2",
            "points.csv line 2: has 4 columns, not 5; "
            "is a separator missing or too many? text that holds one goes into quotation marks",
        ),
        (
            "1,T1,1,2,3,4",
            "points.csv line 2: has 6 columns, not 5; "
            "is a separator missing or too many? text that holds one goes into quotation marks",
        ),
        (
            '1,"T1,1,2,3',
            "points.csv line 2: cannot be split: unexpected end of data; "
            "close the quotation mark, or take it out",
        ),
    ],
)
def test_faults_of_rows(tmp_path: Path, text: str, told: str) -> None:
    table = read(tmp_path, HEADER + text + "\n9,T1,1,2,3\n")
    assert faults(table) == [told]


@pytest.mark.parametrize(
    ("header", "told"),
    [
        (
            "pose_id,target,x_mm,y_mm",
            "points.csv line 1: no column z_mm or z_m; add it, or say which it is: columns = { z_mm = ... }",
        ),
        (
            "pose,target,x_mm,y_mm,z_mm",
            "points.csv line 1: no column pose_id; did you mean 'pose'? "
            "add it, or say which it is: columns = { pose_id = ... }",
        ),
        (
            "pose_id,x_mm,y_mm,z_mm,z_mm",
            "points.csv line 1: column 'z_mm' twice, columns 4 and 5; "
            "take one out, or say which by its number in `columns`",
        ),
        ("pose_id,x_mm,y_mm,z_mm,z_m", "points.csv line 1: both z_mm and z_m; keep one of them"),
        (
            "pose_id,x_mm,y_mm,z_mm,temp_C",
            "points.csv line 1: column 'temp_C': 'C' is not a unit of it; name it temp_degC",
        ),
        (
            "pose_id,x_mm,y_mm,z_mm,q1_mm",
            "points.csv line 1: column 'q1_mm': joint_1 turns, which 'mm' does not fit; "
            "name it q1_deg or q1_rad",
        ),
        (
            "pose_id,x_mm,y_mm,z_mm,q1",
            "points.csv line 1: column 'q1' does not say its unit; name it q1_deg or q1_rad",
        ),
        (
            "pose_id,x_mm,y_mm,z_mm,tarjet",
            "points.csv line 1: column 'tarjet' is not known; did you mean 'target'? "
            "rename it or take it out",
        ),
    ],
)
def test_faults_of_the_header(tmp_path: Path, header: str, told: str) -> None:
    table = read(tmp_path, header + "\n" + ",".join(["1"] * len(header.split(","))) + "\n")
    assert told in faults(table)


def test_unknown_columns_are_listed(tmp_path: Path) -> None:
    table = read(tmp_path, "pose_id,x_mm,y_mm,z_mm,operator,q7_deg,temp_motor\n1,1,2,3,Ann,4,5\n")
    assert faults(table) == []
    assert table.unused == ["operator", "q7_deg", "temp_motor"]


@pytest.mark.parametrize(
    ("text", "layout", "told"),
    [
        ("pose_id;x_mm;y_mm;z_mm\n1;1;2;3\n", {}, 'separated by \';\'; say separator = ";"'),
        (
            "pose_id;x_mm;y_mm;z_mm\n1;1,5;2;3\n",
            {},
            'separated by \';\'; say separator = ";" and decimal = ","',
        ),
        ("pose_id\tx_mm\ty_mm\tz_mm\n1\t1\t2\t3\n", {}, 'separated by tabs; say separator = "\\t"'),
        ("pose_id x_mm  y_mm z_mm\n1 1 2 3\n", {}, 'separated by blanks; say separator = " "'),
        ("pose_id,x_mm,y_mm,z_mm\n1,1,2,3\n", {"separator": ";"}, 'separated by \',\'; say separator = ","'),
        (
            "pose_id, x_mm, y_mm, z_mm\n1, 1, 2, 3\n",
            {"separator": " "},
            'separated by \',\'; say separator = ","',
        ),
        (
            "1, 1, 2, 3\n",
            {"separator": " ", "header": False, "columns": {"pose_id": 1, "x_mm": 2, "y_mm": 3, "z_mm": 4}},
            'separated by \',\'; say separator = ","',
        ),
        (
            "1 1.5 2 3\n",
            {"header": False, "columns": {"pose_id": 1, "x_mm": 2, "y_mm": 3, "z_mm": 4}},
            'separated by blanks; say separator = " "',
        ),
        (
            "// exported\npose_id,x_mm,y_mm,z_mm\n1,1,2,3\n",
            {},
            "starts with '//'; if that is a comment, say comment = \"//\"",
        ),
        (
            "# pose_id,x_mm,y_mm,z_mm\n1,1,2,3\n",
            {},
            "starts with '#'; if that is a comment, say comment = \"#\"",
        ),
        (
            "1,1,2,3\n2,1,2,3\n",
            {},
            "holds numbers where the names of the columns should be; add a header, or say header = false",
        ),
        (
            "1,1,2,3\n2,1,2,3\n",
            {"columns": {"pose_id": 1, "x_mm": 2, "y_mm": 3, "z_mm": 4}},
            "holds numbers where the names of the columns should be; add a header, or say header = false",
        ),
    ],
)  # fmt: skip
def test_one_fault_for_a_wrong_layout(
    tmp_path: Path, text: str, layout: dict[str, object], told: str
) -> None:
    table = read(tmp_path, text, **layout)
    assert len(table.faults) == 1
    assert faults(table)[0].startswith("points.csv line 1: ")
    assert told in faults(table)[0]


def test_decimal_comma(tmp_path: Path) -> None:
    text = "pose_id;x_mm;y_mm;z_mm\n1;1,5;-2;3e-1\n2;1.5;1.000,5;0\n"
    table = read(tmp_path, text, separator=";", decimal=",")
    np.testing.assert_allclose([table.numbers[axis][0] for axis in "xyz"], [1.5e-3, -2e-3, 3e-4])
    assert faults(table) == [
        "points.csv line 3: x_mm is '1.5', not a number; say decimal = \".\"",
        "points.csv line 3: y_mm is '1.000,5', not a number; write it without a sign between the thousands",
    ]


def test_foreign_layout_by_number_and_unit(tmp_path: Path) -> None:
    text = "// program\n// axes\nrun1  a  P1   1.5 2.5\t 3.5  late\nrun2 a P2 1 2 3 later\n"
    columns = {"pose_id": 1, "target": 3, "x_mm": 4, "y_mm": 5, "z_mm": 6}
    table = read(
        tmp_path, text, separator=" ", header=False, comment="//", columns=columns, units={"x_mm": "m"}
    )
    assert faults(table) == []
    assert table.texts["target"] == ["P1", "P2"]
    assert table.lines.tolist() == [3, 4]
    np.testing.assert_allclose(table.numbers["x"], [1.5, 1.0])
    np.testing.assert_allclose(table.numbers["y"], [2.5e-3, 2e-3])


def test_foreign_layout_by_header_name(tmp_path: Path) -> None:
    columns = {"pose_id": "Point", "x_mm": "X", "y_mm": "Y", "z_mm": 4}
    table = read(tmp_path, 'Point,X,Y,Z,x_mm\n"a, b",1,2,oops,9\n', columns=columns)
    assert table.texts["pose_id"] == ["a, b"]
    assert table.numbers["x"].tolist() == [1e-3]
    assert faults(table) == ["points.csv line 2: z_mm (column 4) is 'oops', not a number; leave the line out"]


@pytest.mark.parametrize(
    ("layout", "told"),
    [
        (
            {"columns": {"x_nm": 2}},
            "campaign.toml: points.columns.x_nm: no such column of this table; did you mean",
        ),
        (
            {"columns": {"x": 2}},
            "campaign.toml: points.columns.x: no such column of this table; say x_mm or x_m",
        ),
        ({"columns": {"x_mm": 9}}, "campaign.toml: points.columns.x_mm: no column 9; the file has 5 columns"),
        (
            {"columns": {"x_mm": "x_nm"}},
            "campaign.toml: points.columns.x_mm: no column 'x_nm' in the header; did you mean 'x_mm'?",
        ),
        (
            {"columns": {"x_mm": 3, "x_m": 4}},
            "campaign.toml: points.columns.x_m: x is mapped twice; keep one",
        ),
        (
            {"units": {"x_mm": "deg"}},
            "campaign.toml: points.units.x_mm: 'deg' is not a unit of x_mm; one of 'mm'",
        ),
        ({"units": {"x_mn": "m"}}, "campaign.toml: points.units.x_mn: no such column; did you mean 'x_mm'?"),
        ({"units": {"q1_deg": "rad"}}, "campaign.toml: points.units.q1_deg: no such column"),
        (
            {"header": False, "columns": {"target": "T"}},
            "campaign.toml: points.columns.target: no header to look for 'T' in; give the column's number",
        ),
        (
            {"header": False, "columns": {"x_mm": 3, "y_mm": 4, "z_mm": 5}},
            "points.csv: no column pose_id; say which it is: columns = { pose_id = 1, ... } (1 = first)",
        ),
    ],
)
def test_faults_of_the_mapping(tmp_path: Path, layout: dict[str, object], told: str) -> None:
    table = read(tmp_path, HEADER + "1,T1,1,2,3\n", **layout)
    assert any(fault.startswith(told) for fault in faults(table)), faults(table)


def test_header_in_words_does_not_count_the_columns(tmp_path: Path) -> None:
    columns = {"pose_id": 1, "x_mm": 2, "y_mm": 3, "z_mm": 4}
    table = read(tmp_path, "No. X [mm] Y [mm] Z [mm]\n1 1 2 3\n2 4 5 6\n", separator=" ", columns=columns)
    assert faults(table) == []
    assert table.numbers["z"].tolist() == [0.003, 0.006]


def test_broken_header_is_one_fault(tmp_path: Path) -> None:
    table = read(tmp_path, '"pose_id,x_mm\n1,2\n')
    assert len(faults(table)) == 1
    assert faults(table)[0].startswith("points.csv line 1: cannot be split")


@pytest.mark.parametrize("separator", ["", "ab", ",,", "5", ".", '"', "\n", "x"])
def test_separator_is_one_sign(separator: str) -> None:
    with pytest.raises(ValidationError):
        Layout(separator=separator)


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (b"", "points.csv: is empty; it needs a header and a line per row"),
        (b"\n , ,\n", "points.csv: is empty; it needs a header and a line per row"),
        (HEADER.encode(), "points.csv: has a header but no rows; it needs a line per row"),
        (b"pose_id\n\xff\xfe", "points.csv: is not UTF-8 text"),
    ],
)
def test_faults_of_the_file(tmp_path: Path, content: bytes, told: str) -> None:
    (only,) = faults(read(tmp_path, content))
    assert only.startswith(told)


def test_missing_file(tmp_path: Path) -> None:
    table = read_table(tmp_path / "none.csv", Layout(), WANTED)
    assert [fault.what for fault in table.faults] == ["no such file"]


def test_all_faults_at_once_and_many_of_a_kind_counted(tmp_path: Path) -> None:
    rows = [f"{row},T1,{'bad' if row % 2 else 1},2,3" for row in range(1000)] + ["7,T1,1,2", "8,T1,1,nan,3"]
    told = faults(read(tmp_path, HEADER + "\n".join(rows)))
    assert len(told) == 1 + 11 + 1
    assert told[0].startswith("points.csv line 1002: has 4 columns")
    assert told[1].startswith("points.csv line 3: x_mm is 'bad'")
    assert told[11] == "points.csv line 1001: and 490 more like this up to here"
    assert told[12].startswith("points.csv line 1003: y_mm is 'nan'")


def test_surplus_separators_at_the_end_are_no_fault(tmp_path: Path) -> None:
    table = read(tmp_path, "pose_id,x_mm,y_mm,z_mm,,\n1,1,2,3,,\n2,1,2,3\n3,1,2,3,\n")
    assert faults(table) == []
    assert len(table) == 3


def test_blank_cells_where_they_are_legal(tmp_path: Path) -> None:
    table = read(tmp_path, "pose_id,x_mm,y_mm,z_mm,temp_degC,note\n1,1,2,3,,\n2,1,2,3,hot,\n")
    assert np.isnan(table.numbers["temp"]).tolist() == [True, True]
    assert table.texts["note"] == ["", ""]
    assert faults(table) == [
        "points.csv line 3: temp_degC is 'hot', not a number; leave the cell empty where there is none"
    ]


def test_hundred_thousand_rows(tmp_path: Path) -> None:
    rows = (f"{row // 3},T{row % 3},{row}.25,-{row}.5,{row}e-3" for row in range(100_000))
    path = tmp_path / "points.csv"
    path.write_text(HEADER + "\n".join(rows))
    table = read_table(path, Layout(), WANTED)
    assert len(table) == 100_000
    assert not table.faults


@pytest.mark.parametrize("block", [0, 1, 30, 90])
@pytest.mark.parametrize(
    ("text", "layout"),
    [
        (HEADER + "".join(f"{i},T{i % 2},{i},2,3\n" for i in range(40)), {}),
        (HEADER + "1,T1,1,2,3\n2,T1,x,2,3\n3,T1\n" * 20 + '4,T1,1e400,,3\n5,"T1,1,2,3\n\n6,,1,2,3,,', {}),
        ("# a\n\n# b\n" * 9 + HEADER + "1,T1,1,2,3\n# c\n2,T1,1e99,2,3\n" * 9, {"comment": "#"}),
        ("\n" * 50 + HEADER + "\n" * 50, {}),
        ("\n" * 50, {}),
        (HEADER + "1,T1,1,2,3\n" * 9 + f"1,{'x' * 3000},1,2,3\n", {}),
        ("1,T1,1,2,3\n" * 5 + "1,T1,1\n" * 5 + "1,T1,1,2,3\n", {"header": False, "columns": BY_NUMBER}),
        (HEADER + "1 T1 1 2 3\n" * 9, {"separator": " "}),
        ("\u2028\n" + "\u2028" * 3000 + "\n1\n", {"separator": " "}),
    ],
)
def test_a_table_is_the_same_in_any_blocks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, layout: dict[str, object], block: int
) -> None:
    whole = read(tmp_path, text, **layout)
    monkeypatch.setattr("workbench.files.table_rows.BLOCK", block)
    parts = read(tmp_path, text.replace("\n", "\r\n"), **layout)
    assert faults(parts) == faults(whole)
    assert (parts.texts, parts.labels, parts.unused) == (whole.texts, whole.labels, whole.unused)
    assert parts.lines.tolist() == whole.lines.tolist()
    for name, values in whole.numbers.items():
        np.testing.assert_array_equal(parts.numbers[name], values)


@pytest.mark.parametrize(
    ("column", "values", "name", "cells"),
    [
        (Column("x", ("length",)), [0.1, -0.0, 1e-9], "x_mm", ["100", "0", "1e-06"]),
        (Column("q1", ("angle", "length")), [np.pi / 2, np.nan], "q1_deg", ["90", ""]),
        (Column("tau1", ("torque",)), [1 / 3], "tau1_Nm", ["0.333333333333"]),
        (Column("dir1"), [-1.0, 0.0, 1.0], "dir1", ["-1", "0", "1"]),
    ],
)
def test_columns_are_written_in_their_usual_unit(
    column: Column, values: list[float], name: str, cells: list[str]
) -> None:
    assert column_cells(column, np.array(values)) == (name, cells)


NAMES = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Zl", "Zp")), min_size=1, max_size=8
).map(str.strip).filter(bool)  # fmt: skip
NUMBERS = st.floats(-1e6, 1e6, allow_subnormal=False)


@settings(max_examples=100, deadline=None)
@given(rows=st.lists(st.tuples(NAMES, NUMBERS, NUMBERS, NUMBERS), min_size=1, max_size=8))
def test_what_is_written_is_read_back(
    tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[str, float, float, float]]
) -> None:
    path = tmp_path_factory.mktemp("round") / "points.csv"
    texts = [[name, *(number_text(value) for value in values)] for name, *values in rows]
    path.write_text(table_text(["pose_id", "x_m", "y_m", "z_m"], texts), encoding="utf-8")
    table = read_table(path, Layout(), WANTED)
    assert table.faults == []
    assert table.texts["pose_id"] == [name for name, *_ in rows]
    for index, axis in enumerate("xyz", 1):
        np.testing.assert_allclose(table.numbers[axis], [row[index] for row in rows], rtol=1e-11)


def test_decimal_commas_between_commas_are_one_fault(tmp_path):
    rows = "".join(f"{n},T1,{n},5,-2,25,3,{n}1\n" for n in range(1, 30))
    (tmp_path / "points.csv").write_text("pose_id,target,x_mm,y_mm,z_mm\n" + rows, encoding="utf-8")
    wanted = [Column("pose_id", text=True), Column("target", text=True)]
    wanted += [Column(axis, ("length",), required=True) for axis in "xyz"]
    (fault,) = read_table(tmp_path / "points.csv", Layout(), wanted, "points").faults
    assert "line 2: decimal commas, and commas between the columns as well (29 rows)" in str(fault)
    assert "decimal points, or with ';' between the columns and say separator = \";\"" in str(fault)
