"""Joints that end at joints of other sets: the relations of sets as fractopo gives them, and traces cut accordingly."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter
from typing import Any

import numpy as np

from bsm_mesh.errors import one_line
from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.joint_sets import FloatArray

COUNTS = ("x", "y", "y-reverse")


def abutting_sets(relations: Any, least: float = 0.5) -> dict[str, tuple[str, ...]]:
    """Return the sets at whose joints those of each set end, from fractopo's table of relations.

    Parameters
    ----------
    relations : DataFrame, or iterable of mappings
        ``Network.azimuth_set_relationships``, or the rows of it as CSV: ``sets`` two names; ``x`` crossings, ``y``
        ends of the first at the second, ``y-reverse`` ends of the second at the first.
    least : float
        Share of all meetings of two sets from which one abuts on the other, above 0 up to 1.

    Returns
    -------
    dict of str to tuple of str
        For ``JointSet(abuts=)``; sets that end at no other are not in it. Of two sets one at most abuts on the other:
        that which ends there more often.

    Raises
    ------
    GeometryError
        For rows without these columns.

    Examples
    --------
    >>> abutting_sets([{"sets": ("J1", "J2"), "x": 3, "y": 1, "y-reverse": 12, "error-count": 0}])
    {'J2': ('J1',)}
    """
    if not 0 < least <= 1:
        raise GeometryError(f"abutting_sets: least = {least} must be above 0 and at most 1")
    rows: Iterable[Mapping[str, Any]] = relations.to_dict("records") if hasattr(relations, "to_dict") else relations
    found: dict[str, tuple[str, ...]] = {}
    for number, row in enumerate(rows, start=1):
        try:
            names = row["sets"]
            first, second = (str(n) for n in (ast.literal_eval(names) if isinstance(names, str) else names))
            crossing, ending, reverse = (int(row[name]) for name in COUNTS)
        except (KeyError, ValueError, TypeError, SyntaxError) as fault:
            raise GeometryError(
                f"abutting_sets: row {number} needs sets (two names) and the counts {', '.join(COUNTS)}; "
                f"it is {one_line(repr(row))}"
            ) from fault
        meetings = crossing + ending + reverse
        count, one, other = max((ending, first, second), (reverse, second, first))
        if ending != reverse and count >= least * meetings:
            found[one] = (*found.get(one, ()), other)
    return found


def ended(joints: Sequence[Any], traces: Sequence[FloatArray]) -> list[FloatArray]:
    """Return the traces of all joints, (n, 2, 2) [m] each, ended at the sets that these abut on.

    Sets that others abut on come first: a trace ends at the rest of another, not at the part cut off it.

    Raises
    ------
    GeometryError
        For a set that is not there, and for sets that abut on each other in a circle.
    """
    on: dict[str, set[str]] = {}
    for joint in joints:
        on.setdefault(joint.name, set()).update(getattr(joint, "abuts", ()))
    for name, those in on.items():
        if unknown := those - on.keys():
            raise GeometryError(f"joint set '{name}': abuts on '{min(unknown)}', which is no set of this rock")
    try:
        order = tuple(TopologicalSorter(on).static_order())
    except CycleError as fault:
        circle = " on ".join(f"'{name}'" for name in reversed(fault.args[1]))
        raise GeometryError(f"joint sets abut on each other in a circle: {circle}; leave one of these out") from None
    found: list[FloatArray] = list(traces)
    for number in sorted(range(len(joints)), key=lambda k: order.index(joints[k].name)):
        abuts = getattr(joints[number], "abuts", ())
        others = [trace for joint, trace in zip(joints, found, strict=True) if joint.name in abuts]
        if others:
            found[number] = end_at(found[number], np.concatenate(others))
    return found


def end_at(traces: FloatArray, others: FloatArray) -> FloatArray:
    """Return the traces, (n, 2, 2) [m], each between the nearest of `others` before and after its middle."""
    import shapely

    lines = shapely.linestrings(traces)
    one, other = shapely.STRtree(shapely.linestrings(others)).query(lines, predicate="intersects")
    start, vector = traces[one, 0], traces[one, 1] - traces[one, 0]
    along = others[other, 1] - others[other, 0]
    gap = others[other, 0] - start
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (gap[:, 0] * along[:, 1] - gap[:, 1] * along[:, 0]) / (
            vector[:, 0] * along[:, 1] - vector[:, 1] * along[:, 0]
        )
    first, last = np.zeros(len(traces)), np.ones(len(traces))
    before = share < 0.5  # of parallel ones that touch there is no share: they end nothing
    np.maximum.at(first, one[before], share[before])
    np.minimum.at(last, one[share >= 0.5], share[share >= 0.5])
    whole = traces[:, 1] - traces[:, 0]
    return np.stack([traces[:, 0] + first[:, None] * whole, traces[:, 0] + last[:, None] * whole], axis=1)
