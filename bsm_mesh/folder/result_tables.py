"""Tables of results as files: CSV with units in the header, or Parquet with units in the columns' metadata."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from bsm_mesh.errors import NO_PANDAS, ModelError
from bsm_mesh.files import whole_file
from bsm_mesh.results.results import Results
from bsm_mesh.results.tables import ResultTable, result_table
from bsm_mesh.text.csv_tables import csv_file

if TYPE_CHECKING:
    from bsm_mesh.converters.vtk_files import Compression

BOLTS, FLOW = "bolts", "flow"
ON_REQUEST = ("blocks", "contacts", "supports", "joints")
TableForm = Literal["csv", "parquet"]


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputForm:
    """How results are written.

    Attributes
    ----------
    tables : bool or {"csv", "parquet"}
        Whether the tables `ON_REQUEST` are written too, and as what; True: as CSV.
    compression : {"zlib", "lz4"}
        Of the VTU files.
    """

    tables: bool | TableForm = False
    compression: Compression = "zlib"

    def __post_init__(self) -> None:
        for what, value, known in (
            ("tables", self.tables, (True, False, "csv", "parquet")),
            ("compression", self.compression, ("zlib", "lz4")),
        ):
            if value not in known:
                raise ModelError(f"{what} = {value!r} must be one of {', '.join(map(repr, known))}")


USUAL = OutputForm()


def write_tables(results: Results, folder: Path, form: OutputForm) -> list[str]:
    """Write the tables that are asked for, and those of bolts and of flow where there are any; return their names."""
    kind: TableForm = "csv" if form.tables is True else form.tables or "csv"
    wanted = [(name, kind) for name in ON_REQUEST if form.tables]
    if results.stages[0].bolts.count:
        wanted.append((BOLTS, kind))
    if results.stages[0].flow is not None:
        wanted.append((FLOW, kind))
    for name, ending in wanted:
        _WRITERS[ending](result_table(results, name), folder / f"{name}.{ending}")
    return [f"{name}.{ending}" for name, ending in wanted]


def to_pandas(results: Results, name: str) -> Any:
    """Return a table as a pandas DataFrame, texts as categories, units in ``attrs["units"]``.

    Raises
    ------
    ModelError
        If there is no such table, or no pandas.
    """
    return frame_of(result_table(results, name))


def frame_of(table: ResultTable) -> Any:
    """Return a table as a pandas DataFrame; errors as of `to_pandas`."""
    try:
        import pandas as pd
    except ImportError:
        raise ModelError(NO_PANDAS) from None
    columns = {h: pd.Categorical(v) if v.dtype == object else v for h, v in table.columns.items()}
    frame = pd.DataFrame(columns)
    frame.attrs["units"] = dict(table.units)
    return frame


def write_table(table: ResultTable, path: Path) -> Path:
    """Write one table, as the ending of its name says: ``.csv`` or ``.parquet``; return the path.

    Raises
    ------
    ModelError
        For another ending.
    """
    ending = path.suffix.removeprefix(".")
    if ending not in _WRITERS:
        raise ModelError(f"{path}: a table ends in .csv or .parquet; give such a name")
    _WRITERS[ending](table, path)
    return path


def _write_csv(table: ResultTable, path: Path) -> None:
    with csv_file(path) as writer:
        writer.writerow(f"{h} [{table.units[h]}]" if h in table.units else h for h in table.columns)
        writer.writerows(zip(*map(_cells, table.columns.values()), strict=True))


def _cells(values: Any) -> Iterable[Any]:
    """Return the cells of a column; an empty one where there is no number."""
    if values.dtype.kind == "f" and np.isnan(values).any():
        return ["" if value != value else value for value in values.tolist()]
    return values.astype(np.uint8).tolist() if values.dtype == bool else values.tolist()  # type: ignore[no-any-return]


def _write_parquet(table: ResultTable, path: Path) -> None:
    import pyarrow as pa
    from pyarrow import parquet

    arrays = {
        header: pa.array(values, pa.string()).dictionary_encode() if values.dtype == object else pa.array(values)
        for header, values in table.columns.items()
    }
    fields = [
        pa.field(h, array.type, metadata={"unit": table.units[h]} if h in table.units else None)
        for h, array in arrays.items()
    ]
    with whole_file(path) as draft:
        parquet.write_table(pa.table(arrays, schema=pa.schema(fields)), draft, compression="zstd")


_WRITERS = {"csv": _write_csv, "parquet": _write_parquet}
