"""Jointed rock cut into blocks, and the account of every joint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bsm_mesh.errors import counted
from bsm_mesh.geometries.cutting.pieces import IntArray
from bsm_mesh.geometries.joint_sets import FloatArray

ENGINES = {"gmsh": "Gmsh", "shapely": "our own cutter"}


@dataclass(frozen=True, slots=True, kw_only=True)
class JointAccount:
    """Where the length of a joint went [m]: ``in_rock + extended`` is the sum of the six below.

    Attributes
    ----------
    name : str
        Name of the joint.
    given : float
        Length of all traces, also outside the rock.
    in_rock : float
        Length in the rock and two tolerances around it.
    extended : float
        Length added to dead ends.
    bounding : float
        Between blocks.
    coincident : float
        On a joint given before this one, which names the edge, or twice on the same; sides of joined slivers too.
    on_outline : float
        On the outline of the rock.
    dead : float
        In the rock with the same block on both sides, or in none.
    outside : float
        Ends that stand out of the rock by two tolerances.
    snapped : float
        Length removed or added by the tolerance where joints nearly meet.
    dead_ends : int
        Ends in the rock.
    """

    name: str
    given: float
    in_rock: float
    extended: float
    bounding: float
    coincident: float
    on_outline: float
    dead: float
    outside: float
    snapped: float
    dead_ends: int

    def __str__(self) -> str:
        """Return the account as a sentence."""
        parts = [f"{self.bounding:.6g} m between blocks"]
        for length, what in (
            (self.extended, "m added where ends reach on to the next joint"),
            (self.coincident, "m on another joint"),
            (self.on_outline, "m on the outline"),
            (self.dead, f"m that end in the rock and bound no block ({self.dead_ends} free ends)"),
        ):
            if length > 0:
                parts.append(f"{length:.6g} {what}")
        return f"joint:{self.name}: {self.in_rock:.6g} m in the rock: {', '.join(parts)}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """The tool that cut the rock, its reason, and the joined pieces.

    Attributes
    ----------
    engine : str
        ``gmsh`` or ``shapely``.
    reason : str
        Why, in words.
    slivers : int
        Blocks thinner than two tolerances, joined to a neighbour.
    """

    engine: str
    reason: str
    slivers: int = 0

    def __str__(self) -> str:
        """Return the choice in words."""
        return f"cut by {ENGINES[self.engine]}: {self.reason}"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BlockCut:
    """Blocks that meet without gaps, with the groups of their edges.

    Attributes
    ----------
    points : (n_points, 2) float64 [m]
        All corners.
    corners : (n_corners,) int64
        Points of the rings, ring after ring: outer rings counter-clockwise, holes clockwise.
    rings : (n_rings + 1,) int64
        Ring r owns ``corners[rings[r]:rings[r + 1]]``.
    faces : (n_blocks + 1,) int64
        Block b owns the rings ``faces[b]`` to ``faces[b + 1] - 1``, the outer one first.
    rock : (n_blocks,) int64
        Index of the rock of each block in `rock_names`.
    rock_names : tuple of str
        Names of the rocks.
    excavations : mapping of str to (k,) int64
        Blocks of each excavation.
    joints, boundaries : mapping of str to (k, 2) int64
        Points at the ends of the edges of each joint between blocks, and of each boundary.
    dead : mapping of str to (k, 2) int64
        Points at the ends of the pieces of each joint that bound no block and are kept.
    accounts : tuple of JointAccount
        Where the length of each joint went.
    by : Choice
        What cut the rock.
    """

    points: FloatArray
    corners: IntArray
    rings: IntArray
    faces: IntArray
    rock: IntArray
    rock_names: tuple[str, ...]
    excavations: Mapping[str, IntArray]
    joints: Mapping[str, IntArray]
    boundaries: Mapping[str, IntArray]
    dead: Mapping[str, IntArray]
    accounts: tuple[JointAccount, ...]
    by: Choice

    @property
    def count(self) -> int:
        """Number of blocks."""
        return len(self.faces) - 1

    @property
    def holed(self) -> IntArray:
        """Blocks with a hole."""
        return np.flatnonzero(np.diff(self.faces) > 1)

    def report(self) -> list[str]:
        """Return the outcome of the joints, a line each."""
        lines = [f"{self.count} blocks, {self.by}", *(str(account) for account in self.accounts)]
        if self.by.slivers:
            lines.append(
                f"{counted(self.by.slivers, 'sliver')} thinner than two tolerances joined to the adjacent block"
            )
        if self.holed.size:
            have = "has a hole and is" if self.holed.size == 1 else "have a hole and are"
            lines.append(f"{counted(self.holed.size, 'block')} {have} divided when read")
        return lines
