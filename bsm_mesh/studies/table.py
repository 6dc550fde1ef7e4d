"""The table of a study: a row a run, of its values and its answers, as a Parquet file."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.errors import NO_PANDAS, ModelError, counted
from bsm_mesh.files import whole_file
from bsm_mesh.studies.sampling import Plan

Kind = Literal["string", "int64", "float64"]
UNITS = "units"  # in a table's metadata: the units of its keys, as JSON
FAILED = "failed"  # status of a run that came to no verdict for a fault
ANSWERS: dict[str, Kind] = {
    "status": "string",
    "stage": "string",
    "reason": "string",
    "max_displacement": "float64",
    "moved_blocks": "int64",  # that fell, or moved by more than a tenth of their size before they reached rest
    "unstable_blocks": "int64",
    "unstable_area": "float64",  # in the plane
    "unstable_volume": "float64",  # in space
    "steps": "int64",
}
FACTOR: dict[str, Kind] = {
    "factor": "float64",
    "factor_stable": "float64",
    "factor_unstable": "float64",
    "factor_undecided": "int64",
}
LAST: dict[str, Kind] = {"seconds": "float64", "error": "string"}


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class StudyTable:
    """The outcome of the runs of a study, one row a run, in their order.

    Attributes
    ----------
    keys : tuple of str
        The keys of the model that take values.
    columns : mapping of str to list
        ``run``, the keys, and the answers; None where there is none.
    metadata : mapping of str to str
        Source of the table.
    """

    keys: tuple[str, ...]
    columns: Mapping[str, list[Any]]
    metadata: Mapping[str, str]

    def __repr__(self) -> str:
        return f"StudyTable: {counted(self.count, 'run')}; columns {', '.join(self.columns)}"

    @property
    def count(self) -> int:
        """Number of runs."""
        return len(self.columns["run"])

    def numbers(self, name: str) -> FloatArray:
        """Return a column of numbers, (n,); NaN where there is none."""
        return np.array([np.nan if value is None else value for value in self.columns[name]], dtype=np.float64)

    def unit(self, key: str) -> str:
        """Return the unit of a key's numbers; empty where it has none."""
        units: dict[str, str] = json.loads(self.metadata.get(UNITS, "{}"))
        return units.get(key, "")

    def given_to(self, row: int) -> dict[str, str]:
        """Return the values that the keys have in a row, with their units, in words."""
        given = {key: self.columns[key][row] for key in self.keys}
        return {
            key: f"{value:g} {self.unit(key)}".rstrip() if isinstance(value, int | float) else str(value)
            for key, value in given.items()
        }

    def is_number(self, name: str) -> bool:
        """Return whether a column holds numbers."""
        return all(value is None or isinstance(value, int | float) for value in self.columns[name])

    def has_status(self, *names: str) -> BoolArray:
        """Return which runs have one of these statuses, (n,)."""
        return np.isin(np.array([str(status) for status in self.columns["status"]]), names)

    def to_pandas(self) -> Any:
        """Return the table as a pandas DataFrame, a row a run, in the units of ``study.parquet``.

        Raises
        ------
        ModelError
            If pandas is not installed.
        """
        try:
            return self._arrow().to_pandas()
        except ImportError:
            raise ModelError(NO_PANDAS) from None

    def write(self, path: Path) -> None:
        """Write it as a Parquet file, whole or not at all, compressed by Zstandard."""
        from pyarrow import parquet

        with whole_file(path, settled=True) as draft:
            parquet.write_table(self._arrow(), draft, compression="zstd")

    def _arrow(self) -> Any:
        import pyarrow as pa

        types = {"string": pa.string(), "int64": pa.int64(), "float64": pa.float64()}
        kinds = {"run": "int64", **ANSWERS, **FACTOR, **LAST}
        fields = [
            pa.field(name, types[kinds.get(name) or _kind(values)], nullable=name != "run")
            for name, values in self.columns.items()
        ]
        schema = pa.schema(fields, metadata={**self.metadata, "keys": "\n".join(self.keys)})
        return pa.table(dict(self.columns), schema=schema)

    @classmethod
    def read(cls, path: Path) -> StudyTable:
        """Return the table of a Parquet file that `write` wrote.

        Raises
        ------
        ModelError
            If it is none.
        """
        import pyarrow as pa
        from pyarrow import parquet

        try:
            table = parquet.read_table(path)
            told = {name.decode(): value.decode() for name, value in (table.schema.metadata or {}).items()}
            keys = tuple(told.pop("keys").split("\n"))
        except FileNotFoundError:
            raise ModelError(
                f"{path}: there is no such file; give the folder of a study that has reached its end"
            ) from None
        except (pa.ArrowException, OSError, KeyError, ValueError) as error:
            raise ModelError(f"{path} is no table of a study, or damaged ({error}); run the study again") from None
        return cls(keys=keys, columns=table.to_pydict(), metadata=told)


def unstable_bulk(name: str) -> str:
    """Return the column of the unstable blocks' area or volume."""
    return f"unstable_{name}"


def make_table(
    plan: Plan, rows: Mapping[int, Mapping[str, Any]], *, factor: bool, bulk: str, metadata: Mapping[str, str]
) -> StudyTable:
    """Return the table of the runs that are finished.

    Parameters
    ----------
    plan : Plan
        The values of every run.
    rows : mapping of int to mapping
        The answers by run.
    factor : bool
        Whether the columns of the factor of safety are there.
    bulk : {"area", "volume"}
        The measure of blocks in the plane, or in space.
    metadata : mapping of str to str
        Source of the table.
    """
    order: Sequence[int] = sorted(rows)
    other = {unstable_bulk(name) for name in ("area", "volume")} - {unstable_bulk(bulk)}
    answers = [name for name in (*ANSWERS, *(FACTOR if factor else ()), *LAST) if name not in other]
    columns: dict[str, list[Any]] = {"run": list(order)}
    columns.update({key: [plan.values[key][run] for run in order] for key in plan.values})
    columns.update({name: [rows[run].get(name) for run in order] for name in answers})
    return StudyTable(keys=tuple(plan.values), columns=columns, metadata=metadata)


def _kind(values: Sequence[object]) -> Kind:
    """Return the type of a key's column."""
    if all(isinstance(value, int) and not isinstance(value, bool) for value in values):
        return "int64"
    return "float64" if all(isinstance(value, int | float) for value in values) else "string"
