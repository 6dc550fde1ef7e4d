"""Tables of any country: separators, decimal commas, units and capitals in headers, comments; one reader for all."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bsm_mesh.commands.joint_test import read_laboratory
from bsm_mesh.converters.beside_files import read_beside
from bsm_mesh.converters.meshes.foreign_files import read_foreign
from bsm_mesh.errors import ModelError
from bsm_mesh.geometries import GeometryError, read_scan_line, read_traces
from bsm_mesh.model.bolt_patterns import bolts_from_table
from bsm_mesh.modelfile.build_bolts import _read_cell
from bsm_mesh.table_rows import read_rows

Table = list[list[str]]
ENDS: Table = [["x1", "y1", "x2", "y2", "set"], ["0.5", "1.25", "10", "2.5", "J"], ["-1e1", "0", "3", "4.125", "F"]]
POINTS: Table = [["x", "y", "trace", "set"], ["0.5", "1.25", "a", "J"], ["10", "2.5", "a", "J"]]
SCAN: Table = [["distance", "dip", "dip_direction", "set"], ["0.4", "60", "135.5", "J"], ["1.125", "62.5", "90", "B"]]
BOLTS: Table = [
    ["start_x", "start_y", "end_x", "end_y", "diameter", "name"],
    ["0.5", "1.25", "0.5", "4", "0.025", "A"],
    ["1.5", "1", "2", "4.75", "0.025", "B"],
]
BESIDE: Table = [["history", "u", "axial_force", "stage"], ["crest", "-0.0035", "", "cut"], ["rod", "", "12500.5", "0"]]
NODES: Table = [["x", "y", "sxx"], ["0", "0", "1.5"], ["1.25", "0", "2.5"], ["0", "1.5", "-3.5"]]
SHEAR: Table = [["displacement [m]", "shear_stress [Pa]"], ["0", "0"], ["0.0015", "250000.5"]]


def _traces(path: Path) -> Any:
    return [(one.name, [np.asarray(line).tolist() for line in one.lines]) for one in read_traces(path)]


def _bolts(path: Path) -> Any:
    return [(b.name, b.start, b.end, b.diameter) for b in bolts_from_table(path, _read_cell, bond_strength=1e5)]


def _nodes(path: Path) -> Any:
    found = read_foreign(path)
    return found.points.tolist(), {name: values.tolist() for name, values in found.at_points.items()}


def _laboratory(path: Path) -> Any:
    found = read_laboratory(path)
    return found.displacement.tolist(), found.shear_stress.tolist()


READERS: dict[str, tuple[Table, Callable[[Path], Any]]] = {
    "ends of traces": (ENDS, _traces),
    "points of traces": (POINTS, _traces),
    "scan line": (SCAN, read_scan_line),
    "bolts": (BOLTS, _bolts),
    "measured": (BESIDE, lambda path: read_beside(path, source="s")),
    "nodes": (NODES, _nodes),
    "laboratory": (SHEAR, _laboratory),
}


def commas(cell: str) -> str:
    """Return a number as it is written in most of Europe."""
    return cell.replace(".", ",") if cell.replace(".", "").replace("-", "").replace("e", "").isdigit() else cell


def semicolons(table: Table) -> str:
    return "\n".join(";".join(map(commas, row)) for row in table)


def tabs(table: Table) -> str:
    return "\n".join("\t".join(row) for row in table)


def tabs_and_commas(table: Table) -> str:
    return "\r\n".join("\t".join(map(commas, row)) for row in table) + "\r\n"


def quoted(table: Table) -> str:
    return "\n".join(",".join(f'"{commas(cell)}"' for cell in row) for row in table)


def spreadsheet(table: Table) -> str:
    """Return what spreadsheets add: a mark of the encoding, the separator, empty cells at the ends, empty rows."""
    width = len(table[0]) + 2
    rows = [";".join([*map(commas, row), "", ""]) for row in table]
    return "\N{BYTE ORDER MARK}sep=;\n" + "\n".join([*rows, ";" * (width - 1), ""])


def comments(table: Table) -> str:
    rows = [", ".join(row) for row in table]
    return "\n".join(["# mapped by hand", "", rows[0], "# the first", rows[1], "  # the others", *rows[2:], "# end"])


def commented_header(table: Table) -> str:
    """Return a table as numpy.savetxt and PorePy write it."""
    return "\n".join(["# units: m", "# " + ", ".join(table[0]), *(",".join(row) for row in table[1:])])


def capitals(table: Table) -> str:
    titles = [name.upper() + sign + unit for name, sign, unit in (title.partition(" [") for title in table[0])]
    return "\n".join(",".join(row) for row in [titles, *table[1:]])


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize(
    "written",
    [semicolons, tabs, tabs_and_commas, quoted, spreadsheet, comments, commented_header, capitals],
    ids=lambda written: written.__name__,
)
def test_every_reader_of_tables_reads_all_countries(
    tmp_path: Path, reader: str, written: Callable[[Table], str]
) -> None:
    """Separators, decimal commas, comments and capitals change nothing, whatever the table is for."""
    table, read = READERS[reader]
    plain, other = tmp_path / "plain" / "a.csv", tmp_path / "other" / "a.csv"
    for path, text in ((plain, "\n".join(",".join(row) for row in table)), (other, written(table))):
        path.parent.mkdir()
        path.write_text(text, encoding="utf-8", newline="")
    expected, found = read(plain), read(other)
    if reader == "nodes":  # the field's name is the file's
        expected, found = ((points, list(fields.values())) for points, fields in (expected, found))
    assert found == expected


@pytest.mark.parametrize(
    ("reader", "old", "new", "factors"),
    [
        ("ends of traces", ("x1", "y1", "x2", "y2"), "{} [mm]", 1e-3),
        ("points of traces", ("x", "y"), "{} (ft)", 0.3048),
        ("scan line", ("distance",), "{} [ft]", 0.3048),
        ("bolts", ("start_x", "start_y", "end_x", "end_y"), "{} [cm]", 1e-2),
        ("laboratory", ("displacement [m]",), "Displacement (mm)", 1e-3),
    ],
)
def test_units_in_headers(tmp_path: Path, reader: str, old: tuple[str, ...], new: str, factors: float) -> None:
    table, read = READERS[reader]
    titles = [new.format(name) if name in old else name for name in table[0]]
    scaled = [
        [f"{float(cell) * factors:.17g}" if name in old else cell for name, cell in zip(table[0], row, strict=True)]
        for row in table[1:]
    ]
    for name, rows in (("a", [titles, *table[1:]]), ("b", [table[0], *scaled])):
        (tmp_path / name).mkdir()
        (tmp_path / name / "t.csv").write_text("\n".join(",".join(row) for row in rows))
    found, expected = read(tmp_path / "a" / "t.csv"), read(tmp_path / "b" / "t.csv")
    np.testing.assert_allclose(_numbers(found), _numbers(expected), rtol=1e-14)
    assert len(_numbers(found)) > 2


def _numbers(value: Any) -> list[float]:
    if isinstance(value, dict):
        return _numbers(list(value.values()))
    if isinstance(value, list | tuple):
        return [number for part in value for number in _numbers(part)]
    return [value] if isinstance(value, float) else []


def test_units_of_angles_and_bolts(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("Distance [m];Dip [\N{DEGREE SIGN}];Dip Direction [rad];Set\n0,5;60;1,5;J\n", encoding="utf-8")
    (row,) = read_scan_line(path)
    assert row == {"distance": 0.5, "dip": 60, "dip_direction": pytest.approx(np.degrees(1.5)), "set": "J"}
    path.write_text("start_x;start_y;end_x;end_y;Diameter [mm];pretension [kN];stage\n0,5 m;1;0,5;4;25;2,5;\n")
    (bolt,) = bolts_from_table(path, _read_cell, kind="end_anchored", bond_strength=None)
    assert (bolt.start, bolt.end, bolt.diameter, bolt.pretension) == ((0.5, 1), (0.5, 4), 0.025, 2500)
    path.write_text("start_x,start_y,end_x,end_y,diameter [mm]\n0,1,0,4,25\n")
    with pytest.raises(ModelError, match="line 2: diameter = '25 mm' is no plain number; give it in SI units"):
        bolts_from_table(path)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("x1;y1;x2;y2\n0,5;1.5;2;3\n", "has numbers with commas ('0,5') and with points ('1.5'); use one of them"),
        ('x1,y1,x2,y2\n"0,5",1.5,2,3\n', "has numbers with commas ('0,5') and with points ('1.5'); use one of them"),
        ('x1,y1,x2,y2\n"1,500",1,2,3\n', "line 2: x1 = '1,500' is no finite number; where commas are decimal points"),
        ("x1,y1,x2,y2\n0,5,1,2,3\n", "line 2: has more or fewer cells than the header (5, not 4); where commas"),
        ("x1;y1;x2;y2\n1.234,5;1;2;3\n", "line 2: x1 = '1.234,5' is no finite number"),
        ("x1 [m],y1 [m],x2 [mm],y2 [m]\n0,0,1,1\n", "name different units; give all the same"),
        ("x1 [yd],y1 [m],x2 [mm],y2 [m]\n0,0,1,1\n", "column 'x1 [yd]': unit 'yd' is none of m, cm, mm"),
        ("x1,X1,y1,x2,y2\n0,0,1,1,1\n", "two columns are called 'x1'; name them apart"),
        ("0,0,1,1,J1\n0,1,1,1,J1\n", "line 1: is no header; write one above it that names the columns"),
        ("# 1\n# 2\n", "has no rows; it needs a header and rows below it (x1, y1, x2, y2 of a trace"),
        ("x1;y1;x2;y2\n0;0;1\n", "line 2: has more or fewer cells than the header (3, not 4)"),
        ("# a\nx1,y1,x2,y2\n# b\n0,0,1,z\n", "line 4: y2 = 'z' is no finite number"),
        ('x1,y1,x2,y2\n0,0,1,"1\n0,0,1,1\n', "is no table: unexpected end of data; correct the line"),
    ],
)
def test_tables_that_are_not_clear(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(GeometryError) as caught:
        read_traces(tmp_path / "a.csv")
    assert says in str(caught.value)


def test_columns_may_be_called_by_numbers(tmp_path: Path) -> None:
    """Values at nodes by stages, as they come from other programs."""
    (tmp_path / "a.csv").write_text("x,y,1,2,3\n0,0,1,2,3\n")
    assert read_rows(tmp_path / "a.csv", "x").header == ["x", "y", "1", "2", "3"]


def test_notes_are_texts(tmp_path: Path) -> None:
    """Points in texts are no decimal points; commas in quotation marks part no cells."""
    path = tmp_path / "a.csv"
    path.write_text('a;note\n0,5;"1.5 m deep, or more"\n1,5;no\n')
    rows = read_rows(path, "a")
    assert rows.cells == [["0,5", "1.5 m deep, or more"], ["1,5", "no"]]
    assert [rows.number(k, 0) for k in (0, 1)] == [0.5, 1.5]


def test_a_laboratory_curve_needs_its_units(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("displacement,shear_stress [Pa]\n0,0\n")
    with pytest.raises(ModelError, match=r"column 'displacement' has no unit; call it displacement \[m\]"):
        read_laboratory(tmp_path / "a.csv")
