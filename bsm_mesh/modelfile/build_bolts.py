"""From the model file's [[bolt]] tables to bolts: single ones and patterns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError, nearest, placed
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.bolt_patterns import (
    ENDS_IN_SPACE,
    bolts_from_table,
    bolts_on_curves,
    radial_bolts,
    row_of_bolts,
)
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.quantities import COORDINATE, quantities_of
from bsm_mesh.model.quantity import convert
from bsm_mesh.model.stages import Stage
from bsm_mesh.modelfile.bolt_tables import BoltTable, SpaceBoltTable
from bsm_mesh.modelfile.reach import Reach

PLACES = ("start", "end", "radial", "row", "curve", "table")
QUANTITIES = {  # of the columns of a table
    **dict.fromkeys(ENDS_IN_SPACE, COORDINATE),
    **{name: quantity for name, (quantity, _) in quantities_of(Bolt).items()},
}


def make_bolts(
    table: BoltTable,
    place: str,
    blocks: Blocks,
    curves: Mapping[str, FloatArray],
    reach: Reach,
    stages: Sequence[Stage] = (),
) -> list[Bolt]:
    """Return the bolts of one table.

    Parameters
    ----------
    table : BoltTable
        The table.
    place : str
        Where it is, for messages.
    blocks : Blocks
        For rows along a boundary.
    curves : mapping of str to (n, 2, 2) float64 [m]
        Line elements of the mesh's groups ``bolt:NAME``.
    reach : Reach
        Where a table may lie.
    stages : sequence of Stage
        For rows along faces that stages lay bare.

    Raises
    ------
    ModelError
        With the fault, and where.
    """
    keys = _shared_keys(table, place, PLACES)
    with placed(place):
        if table.radial is not None:
            return radial_bolts(**table.radial.model_dump(), **keys)
        if table.row is not None:
            return row_of_bolts(blocks, **table.row.model_dump(), stages=stages, **keys)
        if table.curve is not None:
            if table.curve not in curves:
                raise ModelError(f"the mesh has no curve 'bolt:{table.curve}'{nearest(table.curve, curves)}")
            return bolts_on_curves(curves[table.curve], **{**keys, "name": table.name or table.curve})
        return _one_or_rows(table, reach, keys)


def make_space_bolts(table: SpaceBoltTable, place: str, reach: Reach) -> list[Bolt]:
    """Return the bolts of one table of a model of three dimensions; parameters and errors as `make_bolts`."""
    keys = _shared_keys(table, place, ("start", "end", "table"))
    with placed(place):
        return _one_or_rows(table, reach, keys)


def _shared_keys(table: BoltTable | SpaceBoltTable, place: str, places: Sequence[str]) -> dict[str, Any]:
    """Return the keys that all bolts of a table share, once it says in one way where they are."""
    given = [name for name in places if getattr(table, name) is not None]
    if given != ["start", "end"] and (len(given) != 1 or given[0] in ("start", "end")):
        told, others = ", ".join(given) or "none of them", places[2:]
        asked = f"one of {', '.join(others)}" if len(others) > 1 else others[0]
        raise ModelError(f"{place}: say where: start and end, or {asked}; given: {told}")
    keys = table.model_dump(exclude=set(places))
    if table.diameter is None:
        if table.table is None:
            raise ModelError(f"{place}: needs the key 'diameter', for example diameter = \"25 mm\"")
        del keys["diameter"]  # the rows have it, or miss it
    return keys


def _one_or_rows(table: BoltTable | SpaceBoltTable, reach: Reach, keys: Mapping[str, Any]) -> list[Bolt]:
    """Return the bolts of the file that a table names, or the one between its ends."""
    if table.table is not None:
        return bolts_from_table(reach.path(table.table, "table"), _read_cell, **keys)
    assert table.start is not None
    assert table.end is not None
    return [Bolt(start=tuple(table.start), end=tuple(table.end), **keys)]


def unused_curves(curves: Mapping[str, FloatArray], tables: Iterable[BoltTable]) -> dict[str, str]:
    """Return a sentence for every group of bolt curves in the mesh that no table names, by its name."""
    used = {table.curve for table in tables}
    return {
        name: f"the bolt curve '{name}' is not used; give it a [[bolt]] with curve = \"{name}\""
        for name in curves
        if name not in used
    }


def _read_cell(name: str, text: str) -> float:
    """Return a number in SI units, from a plain number or one with its unit."""
    try:
        return float(text)
    except ValueError:
        pass
    try:
        return convert(text, QUANTITIES[name])
    except ValueError as error:
        raise ValueError(f"{name} = {text}: {error}") from None
