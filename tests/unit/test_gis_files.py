"""GDAL is given shapefiles and GeoPackages only: nothing that leads to other files, or to the network."""

from __future__ import annotations

import socket
import sqlite3
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.gis_files import lines_of_gis
from bsm_mesh.geometries.traces import read_traces
from tests.unit.test_traces import write_gis

pytest.importorskip("pyogrio")
VRT = (
    '<OGRVRTDataSource><OGRVRTLayer name="secret"><SrcDataSource>{}</SrcDataSource>'
    "<GeometryType>wkbLineString</GeometryType>"
    '<GeometryField encoding="WKT" field="WKT"/></OGRVRTLayer></OGRVRTDataSource>'
)
SECRET = 'WKT\n"LINESTRING (0 0, 1 1)"\n'


@pytest.fixture
def asked() -> Iterator[tuple[int, list[bytes]]]:
    """Listen on a port; return its number, and what it was asked for."""
    heard: list[bytes] = []
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            while True:
                try:
                    connection, _ = server.accept()
                except OSError:
                    return
                with connection:
                    heard.append(connection.recv(200))

        threading.Thread(target=answer, daemon=True).start()
        yield server.getsockname()[1], heard
        server.shutdown(socket.SHUT_RDWR)


@pytest.mark.parametrize("name", ["t.gpkg", "t.shp", "t.GPKG", "t.Shp"])
def test_a_virtual_dataset_is_refused(tmp_path: Path, asked: tuple[int, list[bytes]], name: str) -> None:
    port, heard = asked
    (tmp_path / "secret.csv").write_text(SECRET)
    for source in ("secret.csv", str(tmp_path / "secret.csv"), f"/vsicurl/http://127.0.0.1:{port}/a.csv"):
        (tmp_path / name).write_text(VRT.format(source))
        with pytest.raises(GeometryError, match=rf"{name}: its content is no (GeoPackage|shapefile)"):
            read_traces(tmp_path / name)
    assert heard == []


@pytest.mark.parametrize("name", ["t.gpkg", "t.shp"])
def test_a_virtual_dataset_beside_the_file_or_behind_its_head_is_not_read(tmp_path: Path, name: str) -> None:
    (tmp_path / "secret.csv").write_text(SECRET)
    path = write_gis(tmp_path / name)
    sets = set(lines_of_gis(path, None).sets)
    for ending in (".aux.xml", ".vrt", ".gpkg.vrt"):
        path.with_name(f"{name}{ending}").write_text(VRT.format("secret.csv"))
    assert set(lines_of_gis(path, None).sets) == sets
    content = path.read_bytes()
    path.write_bytes(content[:100] + VRT.format(tmp_path / "secret.csv").encode())
    with pytest.raises(GeometryError, match=r"GDAL cannot read it|holds no traces"):
        read_traces(path)


@pytest.mark.parametrize("name", ["http:", "zip:", "https:", "s3:"])
def test_a_folder_called_as_an_address_is_a_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, asked: tuple[int, list[bytes]], name: str
) -> None:
    port, heard = asked
    monkeypatch.chdir(tmp_path)
    folder = Path(name, f"127.0.0.1:{port}")
    folder.mkdir(parents=True)
    assert set(lines_of_gis(write_gis(tmp_path / folder / "t.gpkg").relative_to(tmp_path), None).sets) == {"J1", "F"}
    assert heard == []


@pytest.mark.parametrize("view", [False, True])
def test_tables_in_a_geopackage_that_are_other_files_are_not_read(tmp_path: Path, view: bool) -> None:
    secret = tmp_path / "secret.gpkg"
    write_gis(secret)
    path = write_gis(tmp_path / "t.gpkg")
    with closing(sqlite3.connect(path)) as base, base:
        base.execute("PRAGMA writable_schema = 1")
        table = "other" if view else "t"
        base.execute("DELETE FROM sqlite_master WHERE tbl_name = 't'")
        rows = [("table", table, f"CREATE VIRTUAL TABLE {table} USING VirtualOGR('{secret}')")]
        rows += [("view", "t", "CREATE VIEW t AS SELECT * FROM other")] if view else []
        for kind, own, sql in rows:
            base.execute("INSERT INTO sqlite_master VALUES (?, ?, ?, 0, ?)", (kind, own, own, sql))
    with pytest.raises(GeometryError, match=r"GDAL cannot read it|holds no traces"):
        read_traces(path)


def test_the_parts_of_a_shapefile_lie_where_it_lies(tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "here").mkdir()
    path = write_gis(tmp_path / "there" / "t.shp")
    for part in path.parent.iterdir():  # a whole shapefile reached by links
        (tmp_path / "here" / part.name).symlink_to(part)
    assert set(lines_of_gis(tmp_path / "here" / "t.shp", None).sets) == {"J1", "F"}
    (tmp_path / "here" / "t.shp").unlink()
    (tmp_path / "here" / "t.shp").write_bytes(path.read_bytes())
    with pytest.raises(GeometryError, match=r"t\.(cpg|dbf): is a link to another folder than that of t\.shp"):
        read_traces(tmp_path / "here" / "t.shp")


def test_capitals_in_names_and_the_name_of_the_layer(tmp_path: Path) -> None:
    path = write_gis(tmp_path / "faults.shp")
    (tmp_path / "faults.dbf").unlink()  # no names of sets: it is the layer's
    for part in tmp_path.iterdir():
        part.rename(part.with_suffix(part.suffix.upper()))
    assert set(lines_of_gis(path.with_suffix(".SHP"), None).sets) == {"faults"}


def test_what_was_not_yet_merged_into_a_geopackage_is_read(tmp_path: Path) -> None:
    """A GeoPackage that QGIS has open keeps the last changes in a file beside it."""
    path = write_gis(tmp_path / "t.gpkg")
    with closing(sqlite3.connect(path)) as base:
        base.execute("PRAGMA journal_mode = WAL")
        for (trigger,) in base.execute("SELECT name FROM sqlite_master WHERE type = 'trigger'").fetchall():
            base.execute(f'DROP TRIGGER "{trigger}"')  # they call functions of GDAL
        base.execute("UPDATE t SET \"set\" = 'J2' WHERE \"set\" = 'F'")
        base.commit()
        assert (tmp_path / "t.gpkg-wal").stat().st_size > 0
        assert set(lines_of_gis(path, None).sets) == {"J1", "J2"}


def test_texts_in_another_encoding_are_said(tmp_path: Path) -> None:
    path = write_gis(tmp_path / "t.shp")
    table = tmp_path / "t.dbf"
    table.write_bytes(table.read_bytes().replace(b"J1 ", b"\xe4\xf6 "))
    with pytest.raises(GeometryError, match="holds texts that are not in UTF-8"):
        read_traces(path)
