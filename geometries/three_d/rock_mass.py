"""Jointed rock in space as it is described, and the cells that its joints and openings cut it into."""

from __future__ import annotations

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bsm_mesh.geometries.errors import GeometryError
from bsm_mesh.geometries.parameters import Checks
from bsm_mesh.geometries.three_d.bodies import Body, Excavation, HalfSpaces, Opening
from bsm_mesh.geometries.three_d.cell_complex import SIDES, CellComplex
from bsm_mesh.geometries.three_d.crowding import expected_cells
from bsm_mesh.geometries.three_d.joints import Joints
from bsm_mesh.geometries.three_d.rows import BoolArray, FloatArray, IntArray, spread

MAX_CELLS = 1_000_000  # blocks of a box
CROWDED = (
    1.5  # times these: refused before any is cut; of 22 rocks without discs the estimate was 0.83 to 1.36 of the cells
)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class RockMass:
    """Jointed rock in a box, ready to be cut into cells.

    Attributes
    ----------
    box : pair of (float, float, float) [m]
        The lower south-west corner and the upper north-east one; its sides are the boundaries ``west``, ``east``,
        ``south``, ``north``, ``bottom`` and ``top``.
    joints : sequence of Joints
        Joint sets and single joints. Where two lie on each other the one given first names the face.
    bodies : sequence of Opening or Excavation
        The later ones lie over the earlier ones.
    rock : str
        Name of the rock.
    seed : int
        Of the random numbers: same seed, same cells.

    Examples
    --------
    >>> from bsm_mesh.geometries import three_d
    >>> sets = [three_d.JointSet(name=f"J{d}", dip=90, dip_direction=d, spacing=1.0, origin=(0, 0, 0)) for d in (0, 90)]
    >>> three_d.cut_cells(three_d.RockMass(box=((0, 0, 0), (2, 2, 1)), joints=sets)).count
    4
    """

    box: tuple[Sequence[float], Sequence[float]]
    joints: Sequence[Joints] = ()
    bodies: Sequence[Opening | Excavation] = ()
    rock: str = "rock"
    seed: int = 0

    def __post_init__(self) -> None:
        checks = Checks("rock mass")
        parts = list(self.box) if isinstance(self.box, Sequence) else []
        if len(parts) != 2:
            checks.add("box must be two corners, ((x, y, z), (X, Y, Z)) in m")
        elif checks.vector(**{"lower corner of the box": parts[0], "upper corner of the box": parts[1]}):
            low, high = np.asarray(parts, dtype=np.float64)
            if not (low < high).all():
                checks.add("box: every coordinate of the second corner must be above that of the first")
        checks.things(_gives_planes, "JointSet(...), JointPlane(...) or other joints in space", joints=self.joints)
        checks.things(_is_part, "Opening(...) or Excavation(...)", bodies=self.bodies)
        checks.count(0, seed=self.seed)
        checks.group_part(rock=self.rock)
        checks.raise_faults()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CellCut:
    """Rock cut into convex cells that share whole faces; ``bsm.Polyhedra.from_cells`` makes blocks of them.

    Attributes
    ----------
    vertices : (n_vertices, 3) float64 [m]
        Points.
    face_vertices, face_offsets : (k,), (n_faces + 1,) int32
        Corners of the faces, counter-clockwise seen from outside their first cell.
    face_cells : (n_faces, 2) int32
        The two cells of every face; the second is -1 where there is none.
    face_joint : (n_faces,) int32
        Index of each face's joint in `joint_names`, or -1.
    cell_rock, cell_excavation : (n_cells,) int32
        Index of every cell's rock, and of its excavation, or -1.
    joint_names, rock_names, excavation_names : tuple of str
        Names.
    boundaries : mapping of str to (k,) int32
        Faces of the sides of the box and of openings.
    planes : mapping of str to int
        How many planes of each joint cut rock.
    """

    vertices: FloatArray
    face_vertices: IntArray
    face_offsets: IntArray
    face_cells: IntArray
    face_joint: IntArray
    cell_rock: IntArray
    cell_excavation: IntArray
    joint_names: tuple[str, ...]
    rock_names: tuple[str, ...]
    excavation_names: tuple[str, ...]
    boundaries: Mapping[str, IntArray]
    planes: Mapping[str, int]

    @property
    def count(self) -> int:
        """Number of cells."""
        return len(self.cell_rock)


def _gives_planes(thing: object) -> bool:
    return isinstance(getattr(thing, "name", None), str) and callable(getattr(thing, "planes", None))


def _is_part(thing: object) -> bool:
    return isinstance(thing, Opening | Excavation)


def cut_cells(rock: RockMass) -> CellCut:
    """Return the cells of jointed rock: joints cut first, in the order given, then openings and excavations.

    Raises
    ------
    GeometryError
        For a joint that cuts nothing, a body without rock in it, and planes that pass corners too near to divide faces;
        also for more than a million cells.
    """
    checks = Checks("cut_cells")
    checks.a_thing(RockMass, rock=rock)
    checks.raise_faults()
    low, high = np.asarray(rock.box, dtype=np.float64)
    _refuse_crowds(rock, low, high)
    cells = CellComplex(low, high)
    names = tuple(dict.fromkeys(joints.name for joints in rock.joints))
    planes = dict.fromkeys(names, 0)
    for joints in rock.joints:
        planes[joints.name] += _cut_by(cells, joints, names.index(joints.name), rock.seed)
    faults = [
        f"joint '{name}' cuts no rock: it lies outside the box or on another joint"
        for name, number in planes.items()
        if number == 0
    ]
    for number, body in enumerate(rock.bodies):
        if not _fill(cells, body.body, number):
            faults.append(f"{_title(body)}: there is no rock in it; move it into the box or leave it out")
    void = np.array([isinstance(body, Opening) for body in rock.bodies] + [False])[cells.cell_tag.values]
    if void.all():
        faults.append("the openings leave no rock")
    if faults:
        raise GeometryError(faults)
    return _finished(cells, rock, void, names, planes)


def _refuse_crowds(rock: RockMass, low: FloatArray, high: FloatArray) -> None:
    """Refuse rock in far too many cells before it is cut: that takes minutes."""
    cells = expected_cells([(j.planes(low, high, rock.seed), j.persistence) for j in rock.joints], low, high)
    if cells > CROWDED * MAX_CELLS:
        raise GeometryError(_too_many(f"into about {cells:.1g} blocks, and at most {MAX_CELLS:.0e} are cut"))


def _too_many(into: str) -> str:
    """Return the message of joints that cut a box into too many blocks."""
    return f"the joints cut the box {into}; give wider spacings or a smaller box, and check that lengths are in metres"


def _cut_by(cells: CellComplex, joints: Joints, number: int, seed: int) -> int:
    """Cut cells by the planes of a joint; return how many planes cut any."""
    low, high = cells.cell_low.values.min(axis=0), cells.cell_high.values.max(axis=0)
    planes, count = joints.planes(low, high, seed), 0
    generator = np.random.default_rng([seed, zlib.crc32(joints.name.encode()), 1])
    for normal, point, radius in zip(planes.normal, planes.point, planes.radius, strict=True):
        offset = float(normal @ point)
        if np.isfinite(radius):
            reach = radius * np.sqrt(np.maximum(1 - normal**2, 0))

            def inside(centres: FloatArray, point: FloatArray = point, radius: float = radius) -> BoolArray:
                return np.asarray(np.linalg.norm(centres - point, axis=1) <= radius)

            found = cells.cut(normal, offset, number, near=(point - reach, point + reach), choose=inside)
        elif joints.persistence < 1:

            def some(centres: FloatArray) -> BoolArray:
                return np.asarray(generator.uniform(size=len(centres)) < joints.persistence)

            found = cells.cut(normal, offset, number, choose=some)
        else:
            found = cells.cut(normal, offset, number)
        count += bool(len(found))
        if cells.count > MAX_CELLS:
            raise GeometryError(f"joint '{joints.name}': {_too_many(f'into more than {MAX_CELLS:.0e} blocks')}")
    return count


def _fill(cells: CellComplex, body: Body, number: int) -> bool:
    """Cut cells by the surface of a body, and tag those in it with a number; return whether there are any."""
    low, high = cells.cell_low.values.min(axis=0), cells.cell_high.values.max(axis=0)
    found = False
    for part in body:
        alone = CellComplex(low, high)
        there = _inside_part(alone, part, np.ones(1, dtype=bool))
        if not there.any():
            continue
        bottom, top = alone.cell_low.values[there][0], alone.cell_high.values[there][0]
        may = ((cells.cell_low.values < top) & (cells.cell_high.values > bottom)).all(axis=1)
        inside = _inside_part(cells, part, may & (cells.cell_tag.values != number))
        cells.cell_tag.values[inside] = number
        found |= bool(inside.any())
    return found


def _inside_part(cells: CellComplex, part: HalfSpaces, may: BoolArray) -> BoolArray:
    """Cut those cells that `may` lie in a convex body by its planes, and return which cells lie in it."""
    inside = may
    for normal, offset in zip(part.normal, part.offset, strict=True):
        cells.cut(normal, float(offset), within=inside)
        inside = np.concatenate([inside, np.ones(cells.count - len(inside), dtype=bool)])
        chosen = np.flatnonzero(inside)
        inside[chosen[cells.centres(chosen) @ normal > offset]] = False
    return inside


def _finished(
    cells: CellComplex, rock: RockMass, void: BoolArray, joint_names: tuple[str, ...], planes: Mapping[str, int]
) -> CellCut:
    """Return the rest of a complex without the cells of openings, renumbered."""
    kept = ~void
    renumbered = np.append(np.where(kept, np.cumsum(kept) - 1, -1), -1)
    old = cells.face_cells.values
    pairs = renumbered[old]
    face = np.flatnonzero((pairs >= 0).any(axis=1))
    flipped = pairs[face, 0] < 0  # the first cell was in an opening
    corners, sizes = cells.loops.take(face)
    start = np.cumsum(sizes) - sizes
    place, owner = spread(start, sizes), np.repeat(np.arange(len(face)), sizes)
    corners = corners[np.where(flipped[owner], (2 * start + sizes - 1)[owner] - place, place)]
    used, number = np.unique(corners, return_inverse=True)
    beyond = np.where(flipped, old[face, 0], old[face, 1])
    return CellCut(
        vertices=cells.points.values[used],
        face_vertices=number.reshape(-1).astype(np.int32),
        face_offsets=np.append(start, len(corners)).astype(np.int32),
        face_cells=np.where(flipped[:, None], pairs[face][:, ::-1], pairs[face]).astype(np.int32),
        face_joint=np.where((pairs[face] >= 0).all(axis=1), cells.face_joint.values[face], -1).astype(np.int32),
        cell_rock=np.zeros(int(kept.sum()), np.int32),
        cell_excavation=_excavation_of(cells, rock)[kept],
        joint_names=joint_names,
        rock_names=(rock.rock,),
        excavation_names=_names_of(rock, Excavation),
        boundaries=_boundaries(cells, rock, face, beyond),
        planes=dict(planes),
    )


def _excavation_of(cells: CellComplex, rock: RockMass) -> IntArray:
    """Return the number of every cell's excavation, or -1."""
    names = _names_of(rock, Excavation)
    of_body = [names.index(body.name) if isinstance(body, Excavation) else -1 for body in rock.bodies]
    numbers: IntArray = np.array([*of_body, -1], np.int32)[cells.cell_tag.values]
    return numbers


def _names_of(rock: RockMass, kind: type) -> tuple[str, ...]:
    """Return the names of the openings' boundaries, or of the excavations, each once."""
    return tuple(dict.fromkeys(_name(body) for body in rock.bodies if isinstance(body, kind)))


def _boundaries(cells: CellComplex, rock: RockMass, face: IntArray, beyond: IntArray) -> dict[str, IntArray]:
    """Return the faces, by their new numbers, of the sides of the box and along openings."""
    side, found = cells.face_side.values[face], {}
    for number, name in enumerate(SIDES):
        found[name] = np.flatnonzero(side == number)
    names = _names_of(rock, Opening)
    of_body = [names.index(body.boundary) if isinstance(body, Opening) else -1 for body in rock.bodies]
    along = np.where(beyond >= 0, np.array([*of_body, -1])[cells.cell_tag.values[beyond]], -1)
    for number, name in enumerate(names):
        found[name] = np.union1d(found.get(name, []), np.flatnonzero(along == number))
    return {name: faces.astype(np.int32) for name, faces in found.items() if len(faces)}


def _name(body: Opening | Excavation) -> str:
    return body.boundary if isinstance(body, Opening) else body.name


def _title(body: Opening | Excavation) -> str:
    return f"{'opening' if isinstance(body, Opening) else 'excavation'} '{_name(body)}'"
