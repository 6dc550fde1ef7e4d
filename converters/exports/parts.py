"""Parts of a model for every export: faces with their joints, forces on blocks, and notes on omissions."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import ModelError, counted, one_line
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.edges import LongArray
from bsm_mesh.model.face_stiffness import face_joints
from bsm_mesh.model.faces import Faces, find_faces
from bsm_mesh.model.joint_laws import Elastic, MohrCoulomb, Patton
from bsm_mesh.model.loads import InSituTraction, point_forces_of
from bsm_mesh.model.locate import blocks_at
from bsm_mesh.model.materials import Joint
from bsm_mesh.model.model import Model
from bsm_mesh.model.supports import Fixed

GRAVITY = 9.81  # m/s^2: what turns a unit weight into a density
STIFF = 1e11  # Pa/m: faces of rock without a joint, where a program knows contacts only


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class JointedFaces:
    """The faces between blocks and the joint of each, -1 for unjointed rock."""

    faces: Faces
    joint: IntArray

    @classmethod
    def of(cls, model: Model) -> JointedFaces:
        """Return the faces of a model."""
        faces = find_faces(model.blocks)
        return cls(faces=faces, joint=face_joints(model, faces))


def heading(model: Model) -> str:
    """Return the title of a model in one line, with the units of the file."""
    return one_line(f"{model.title or 'a model'} of bsm-mesh, in m, N, Pa, kg/m^3")


def quoted(name: str) -> str:
    """Return a name in quotation marks, in one line, with none in it: it ends no line, and continues none (``&``)."""
    return '"' + one_line(name).replace('"', "'") + '"'


def unit_weights(model: Model) -> FloatArray:
    """Return the unit weight of every block, (n,) [N/m^3]."""
    by_name = {rock.name: rock.unit_weight for rock in model.rocks}
    return np.array([by_name[name] for name in model.blocks.rock_names])[model.blocks.rock]


def forces_on_blocks(model: Model) -> FloatArray:
    """Return the resultant of loads but weights on every block, (n, 3): Fx, Fy [N/m], moment at the centroid [N]."""
    forces = point_forces_of([load for load in model.loads if not isinstance(load, InSituTraction)], model.blocks)
    arm = forces.point - model.blocks.moments.centroid[forces.block]
    moment = arm[:, 0] * forces.force[:, 1] - arm[:, 1] * forces.force[:, 0]
    found: FloatArray = np.zeros((model.blocks.count, 3))
    np.add.at(found, forces.block, np.column_stack([forces.force, moment]))
    return found


def fixed_blocks(model: Model) -> tuple[LongArray, list[str]]:
    """Return the blocks that supports fix, and what of the supports is left out: programs fix whole blocks."""
    held, remarks = [np.empty(0, np.int64)], []
    for number, support in enumerate(model.supports, start=1):
        if not isinstance(support, Fixed):
            remarks.append(f"support {number} ({type(support).__name__}): only blocks that are fixed are written")
            continue
        if support.blocks is None:
            remarks.append(f"support {number} holds edges or a point: the whole blocks there are fixed")
        held.append(_held_by(support, model.blocks))
    return np.unique(np.concatenate(held)), remarks


def _held_by(support: Fixed, blocks: Blocks) -> LongArray:
    if support.blocks is not None:
        return np.asarray(support.blocks, dtype=np.int64)
    if support.boundary is not None:
        return blocks.owner[blocks.boundary_edges(support.boundary)].astype(np.int64)
    assert support.point is not None
    x, y = support.point
    return blocks_at(blocks, (float(x), float(y))).astype(np.int64)


def friction_and_cohesion(joint: Joint) -> tuple[float | None, float]:
    """Return the friction angle [degrees] and cohesion [Pa] of a joint; None: no limit of shear.

    Raises
    ------
    ModelError
        If its law has no such numbers.
    """
    law = joint.law
    if law is None or isinstance(law, Elastic):
        return None, 0.0
    if isinstance(law, MohrCoulomb):
        return law.friction, law.cohesion
    if isinstance(law, Patton):
        return law.friction + law.dilation, 0.0  # its first line, which governs at low pressure
    raise ModelError(
        f"joint '{joint.name}': the law {type(law).__name__} has no friction and cohesion to export; give a "
        "mohr_coulomb law that fits it over the pressures of this model"
    )


def left_out(model: Model, said: Collection[str] = ()) -> list[str]:
    """Return what of a model is left out by a program that can say no more than `said`, a sentence each."""
    found = {
        "stages": [f"{counted(len(model.stages), 'stage')} ({', '.join(stage.name for stage in model.stages)})"]
        if model.stages
        else [],
        "bolts": [counted(len(model.bolts), "bolt")] if model.bolts else [],
        "water": ["groundwater"] if model.water is not None else [],
        "flow": ["flow of water in the joints"] if model.flow is not None else [],
        "in_situ": ["in-situ stress, and tractions that balance it"] if model.in_situ is not None else [],
        "earthquake": ["pseudo-static earthquake"] if model.gravity_horizontal or model.gravity_vertical else [],
        "gravity": [f"gravity in the direction {model.gravity_direction:g} degrees: it is taken as downwards"]
        if model.gravity_direction % 360 != 270
        else [],
        "laws": [
            f"joint '{joint.name}': its law {type(joint.law).__name__} beyond friction and cohesion"
            for joint in model.joints
            if joint.law is not None and not _is_plain(joint)
        ]
        + [f"joint '{joint.name}': its greatest closure" for joint in model.joints if joint.max_closure is not None]
        + [
            f"joint '{joint.name}': shear stiffness that grows"
            for joint in model.joints
            if joint.shear_curve is not None
        ]
        + [f"joint '{joint.name}': its dilation" for joint in model.joints if joint.dilation_angle > 0],
        "rock strength": [
            f"rock '{rock.name}': strength of unjointed faces"
            for rock in model.rocks
            if any(value is not None for value in (rock.cohesion, rock.friction, rock.tensile_strength))
        ],
    }
    return [text for key, texts in found.items() if key not in said for text in texts]


def _is_plain(joint: Joint) -> bool:
    law = joint.law
    if isinstance(law, Patton):  # without asperities its two lines are one
        return law.dilation == 0 and law.residual_friction in (None, law.friction)
    plain = isinstance(law, MohrCoulomb) and law.residual_friction is None and law.residual_cohesion is None
    return plain or isinstance(law, Elastic)
