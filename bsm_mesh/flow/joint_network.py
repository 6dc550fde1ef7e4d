"""The network of a model's joints: faces between blocks, cut where drains and wells meet them and where grout begins.

Its nodes are the points where faces end and where they are cut, its pieces the parts of faces between two of these. The
alternative, domains between blocks with a pressure each, needs a volume for every void; where apertures are constant
between two nodes, heads that are linear between them are exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray, Portable, show_only
from bsm_mesh.errors import ModelError, place, raise_faults
from bsm_mesh.flow.network import Network
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.face_stiffness import face_joints
from bsm_mesh.model.faces import Faces, find_faces
from bsm_mesh.model.flow import Drain, Grout, Well
from bsm_mesh.model.model import Model

if TYPE_CHECKING:
    from shapely import Polygon

SNAP = 1e-6  # of a face's length: a cut this near to its end is at its end
FARTHEST = 1.0  # of the nearest joint's length: a well further from it was meant to be elsewhere


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class JointNetwork(Portable):
    """The joints of a model as a network, in the numbers of the whole model, for all its stages.

    Attributes
    ----------
    network : Network
        Nodes and pieces.
    faces : Faces
        The faces between blocks with a joint.
    joint : (k,) int32
        Number of each face's joint in ``model.joints``.
    face : (m,) int32
        The face that each piece is a part of.
    part : (m, 2) float64
        Where it begins and ends, as parts of the face's length.
    of_point : (p,) int32
        Node of every point of ``blocks.nodes``; -1 where no joint ends.
    on_drain : tuple of (j,) int32
        Nodes on each drain.
    at_well : (w,) int32
        Node of each well.
    in_grout : tuple of (m,) bool
        Pieces in each grouted region.
    unjointed : (j, 2) int32
        Blocks on both sides of the faces without a joint, where no water is until one of them is gone.
    at_unjointed : (j, 2) int32
        Nodes at both ends of these; -1 where no joint ends.
    """

    network: Network
    faces: Faces
    joint: IntArray
    face: IntArray
    part: FloatArray
    of_point: IntArray
    on_drain: tuple[IntArray, ...]
    at_well: IntArray
    in_grout: tuple[BoolArray, ...]
    unjointed: IntArray
    at_unjointed: IntArray

    def __post_init__(self) -> None:
        show_only(self)

    @cached_property
    def ends(self) -> FloatArray:
        """Both ends of the faces, (k, 2, 2) [m]."""
        return np.stack([self.faces.start, self.faces.end], axis=1)

    @cached_property
    def face_length(self) -> FloatArray:
        """Length of the faces, (k,) [m]."""
        length: FloatArray = np.hypot(*(self.faces.end - self.faces.start).T)
        return length


def joint_network(
    model: Model, drains: Sequence[Drain] = (), wells: Sequence[Well] = (), grout: Sequence[Grout] = ()
) -> JointNetwork:
    """Return the network of a model's joints, cut for drains, wells and grouted regions.

    Raises
    ------
    ModelError
        Where there is no joint at all; for drains and grout that meet none, and wells far from any.
    """
    blocks = model.blocks
    faces = find_faces(blocks)
    joint = face_joints(model, faces)
    rock, faces, joint = _rows(faces, joint < 0), _rows(faces, joint >= 0), joint[joint >= 0]
    if not len(joint):
        raise ModelError("flow: no face has a joint, and rock is tight; give faces joints, or mesh.default_joint")
    lines = _Lines(np.stack([faces.start, faces.end], axis=1))
    faults: list[str] = []
    cuts = [
        *(lines.where_drained(drain, f"flow: drain {k + 1}", faults) for k, drain in enumerate(drains)),
        *(lines.where_pumped(well, f"flow: well {k + 1}", faults) for k, well in enumerate(wells)),
        *(lines.where_grouted(region) for region in grout),
    ]
    face, part, ends, point = _cut(blocks, faces, lines, cuts)
    used, number = np.unique(ends, return_inverse=True)
    first, last = number.reshape(ends.shape).T.astype(np.int32)
    network = Network(point=point[used], first=first, last=last)
    in_grout = tuple(_within(network, region) for region in grout)
    faults += [
        f"flow: grout {k + 1} from {place(region.polygon[0])} has no joint in it; check its corners and their unit"
        for k, (region, inside) in enumerate(zip(grout, in_grout, strict=True))
        if not inside.any()
    ]
    raise_faults(faults)
    of_point = np.full(int(blocks.nodes.max()) + 1, -1, dtype=np.int32)
    corners = used[used < len(of_point)]
    of_point[corners] = np.arange(len(corners))
    return JointNetwork(
        network=network,
        faces=faces,
        joint=joint,
        face=face,
        part=part,
        of_point=of_point,
        on_drain=tuple(_near_line(network.point, drain, lines.tolerance) for drain in drains),
        at_well=_nearest(network.point, [lines.foot(well) for well in wells]),
        in_grout=in_grout,
        unjointed=np.stack([blocks.owner[rock.edge_a], blocks.owner[rock.edge_b]], axis=1),
        at_unjointed=of_point[_ends(blocks, rock)],
    )


def _ends(blocks: Blocks, faces: Faces) -> IntArray:
    """Return the points at the start and at the end of faces, (k, 2), in ``blocks.nodes``."""
    start = np.where(faces.start_corner_of_a, blocks.following[faces.edge_a], faces.edge_b)
    end = np.where(faces.end_corner_of_a, faces.edge_a, blocks.following[faces.edge_b])
    return np.stack([blocks.nodes[start], blocks.nodes[end]], axis=1)


def _rows(faces: Faces, chosen: BoolArray) -> Faces:
    return Faces(**{name: getattr(faces, name)[chosen] for name in Faces.__slots__})


class _Lines:
    """The faces as lines, and where other things meet them.

    Parameters
    ----------
    ends : (k, 2, 2) float64 [m]
        Both ends of every face.
    """

    def __init__(self, ends: FloatArray) -> None:
        import shapely

        self.ends, self.lines = ends, shapely.linestrings(ends)
        self.tree = shapely.STRtree(self.lines)
        self.length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
        self.tolerance = SNAP * float(np.median(self.length))

    def where_drained(self, drain: Drain, what: str, faults: list[str]) -> tuple[IntArray, FloatArray]:
        """Return the faces that a drain meets, and where along them."""
        import shapely

        hole = shapely.LineString([drain.start, drain.end])
        found = self._met(hole, self.tree.query(hole, predicate="dwithin", distance=self.tolerance))
        if not len(found[0]):
            faults.append(
                f"{what} from {place(drain.start)} to {place(drain.end)} meets no joint: it drains nothing; check its "
                "ends, and their unit"
            )
        return found

    def where_grouted(self, region: Grout) -> tuple[IntArray, FloatArray]:
        """Return the faces that the outline of a grouted region crosses, and where along them."""
        outline = _polygon(region).boundary
        return self._met(outline, self.tree.query(outline, predicate="intersects"))

    def where_pumped(self, well: Well, what: str, faults: list[str]) -> tuple[IntArray, FloatArray]:
        """Return the face nearest to a well, and where along it."""
        import shapely

        line = int(self.tree.nearest(shapely.Point(well.point)))
        distance, foot = float(shapely.distance(self.lines[line], shapely.Point(well.point))), self.foot(well)
        if distance > FARTHEST * self.length[line]:
            faults.append(
                f"{what} at {place(well.point)} is {distance:.3g} m from the nearest joint, at {place(foot)}; wells "
                "are in joints: move it"
            )
        along = self.ends[line, 1] - self.ends[line, 0]
        t = float(((foot - self.ends[line, 0]) * along).sum() / (along**2).sum())
        return np.array([line]), np.array([t])

    def foot(self, well: Well) -> FloatArray:
        """Return the point of a joint that is nearest to a well, (2,) [m]."""
        import shapely

        line = int(self.tree.nearest(shapely.Point(well.point)))
        return np.array(shapely.shortest_line(self.lines[line], shapely.Point(well.point)).coords[0])

    def _met(self, thing: object, chosen: IntArray) -> tuple[IntArray, FloatArray]:
        """Return of some faces where a line meets them: all crossing points, or both ends of the common part."""
        import shapely

        shared = shapely.intersection(self.lines[chosen], thing)
        nothing = shapely.is_empty(shared)  # within the tolerance only
        shared[nothing] = shapely.get_point(shapely.shortest_line(self.lines[chosen[nothing]], thing), 0)
        points, which = shapely.get_coordinates(shared, return_index=True)
        line = chosen[which]
        along = self.ends[line, 1] - self.ends[line, 0]
        t: FloatArray = ((points - self.ends[line, 0]) * along).sum(axis=1) / (along**2).sum(axis=1)
        return line, t


def _cut(
    blocks: Blocks, faces: Faces, lines: _Lines, cuts: Sequence[tuple[IntArray, FloatArray]]
) -> tuple[IntArray, FloatArray, IntArray, FloatArray]:
    """Return face, part and both end points of the pieces, and all points: those of the blocks, then the cuts'."""
    k = len(faces.edge_b)
    start, end = _ends(blocks, faces).T
    count = int(blocks.nodes.max()) + 1
    point = np.zeros((count, 2))
    point[blocks.nodes] = blocks.vertices
    line = np.concatenate([np.zeros(0, np.int64), *(cut[0] for cut in cuts)])
    t = np.concatenate([np.zeros(0), *(cut[1] for cut in cuts)])
    inside = (t > SNAP) & (t < 1 - SNAP)
    line, t = line[inside], t[inside]
    order = np.lexsort((t, line))
    line, t = line[order], t[order]
    same = (np.diff(line, prepend=-1) == 0) & (np.diff(t, prepend=-1) < SNAP)
    line, t = line[~same], t[~same]
    at = lines.ends[line, 0] + t[:, None] * (lines.ends[line, 1] - lines.ends[line, 0])
    new = count + np.arange(len(line))
    of_face = np.concatenate([np.arange(k), line, np.arange(k)])
    along = np.concatenate([np.zeros(k), t, np.ones(k)])
    node = np.concatenate([start, new, end])
    order = np.lexsort((along, of_face))
    of_face, along, node = of_face[order], along[order], node[order]
    piece = np.flatnonzero(of_face[1:] == of_face[:-1])
    part = np.stack([along[piece], along[piece + 1]], axis=1)
    ends = np.stack([node[piece], node[piece + 1]], axis=1)
    return of_face[piece].astype(np.int32), part, ends, np.concatenate([point, at])


def _near_line(point: FloatArray, drain: Drain, tolerance: float) -> IntArray:
    import shapely

    hole = shapely.LineString([drain.start, drain.end])
    near = shapely.dwithin(shapely.points(point), hole, 2 * tolerance)
    return np.flatnonzero(near).astype(np.int32)


def _nearest(point: FloatArray, feet: Sequence[FloatArray]) -> IntArray:
    return np.array([int(np.argmin(np.hypot(*(point - foot).T))) for foot in feet], dtype=np.int32)  # a few wells


def _within(network: Network, region: Grout) -> BoolArray:
    import shapely

    middle = (network.point[network.first] + network.point[network.last]) / 2
    inside: BoolArray = shapely.contains_xy(_polygon(region), *middle.T)
    return inside


def _polygon(region: Grout) -> Polygon:
    import shapely

    return shapely.make_valid(shapely.Polygon(region.polygon))
