"""State of every joint set: the shares of its length that slip and are open, and the pressure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from bsm_mesh import space
from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.model.kinds import in_space
from bsm_mesh.results.joint_faces import joint_faces
from bsm_mesh.results.records import StageResult

if TYPE_CHECKING:
    from bsm_mesh.results.results import Results

ROCK_FACE = "unjointed rock"


class FacesOfJoints(Protocol):
    """Faces between blocks at the end of a stage: `JointFaces` of the plane, `JointPolygons` of space."""

    @property
    def block_a(self) -> IntArray: ...  # noqa: D102

    @property
    def block_b(self) -> IntArray: ...  # noqa: D102

    @property
    def joint(self) -> IntArray: ...  # noqa: D102

    @property
    def length(self) -> FloatArray: ...  # noqa: D102

    @property
    def slip(self) -> FloatArray: ...  # noqa: D102

    @property
    def opening(self) -> FloatArray: ...  # noqa: D102

    @property
    def pressure(self) -> FloatArray: ...  # noqa: D102

    @property
    def slipping(self) -> FloatArray: ...  # noqa: D102

    @property
    def open(self) -> FloatArray: ...  # noqa: D102


@dataclass(frozen=True, slots=True, kw_only=True)
class JointSet:
    """A joint set at the end of a stage: all faces of one joint, weighed by their length.

    Attributes
    ----------
    name : str
        Of the joint; "unjointed rock" of faces without one.
    length : float [m]
        Of all its faces between blocks that are there; in space their area [m2].
    slipping, open : float
        Share of the length that slips or is within 1 % of its strength, and that is open.
    pressure : float [Pa]
        Mean over the length, compression positive; effective where there is water.
    slip, opening : float [m]
        Means: of the slip without its sign, of the opening.
    greatest_slip, greatest_opening : float [m]
        Of a face between blocks that count: not of one that is too small (``falls.ignore_below``).
    """

    name: str
    length: float
    slipping: float
    open: float
    pressure: float
    slip: float
    opening: float
    greatest_slip: float
    greatest_opening: float


def joint_sets(results: Results, stage: StageResult) -> tuple[JointSet, ...]:
    """Return the joint sets that have faces in a stage, in the order of the joints; unjointed rock is the last."""
    faces = faces_of_joints(results, stage)
    numbers = [*range(len(results.joint_names)), -1]
    found = (
        joint_set(name, faces, n, stage.counts)
        for n, name in zip(numbers, (*results.joint_names, ROCK_FACE), strict=True)
    )
    return tuple(one for one in found if one is not None)


def faces_of_joints(results: Results, stage: StageResult) -> FacesOfJoints:
    """Return the faces of joints at the end of a stage, in space their polygons."""
    return space.joint_polygons(results, stage) if in_space(results.blocks) else joint_faces(results, stage)


def joint_set(name: str, faces: FacesOfJoints, number: int, counts: BoolArray) -> JointSet | None:
    """Return what happened in the joint of a number; None where it has no face. `counts`: blocks that count, (n,)."""
    mine = faces.joint == number
    length = faces.length[mine]
    total = float(length.sum())
    if not total > 0:
        return None
    slip = abs(faces.slip)
    greatest = mine & counts[faces.block_a] & counts[faces.block_b]
    columns = {"slipping": faces.slipping, "open": faces.open, "pressure": faces.pressure, "slip": slip}
    columns["opening"] = faces.opening
    return JointSet(
        name=name,
        length=total,
        **{quantity: float((values[mine] * length).sum()) / total for quantity, values in columns.items()},
        greatest_slip=float(slip[greatest].max(initial=0.0)),
        greatest_opening=float(faces.opening[greatest].max()) if greatest.any() else 0.0,
    )
