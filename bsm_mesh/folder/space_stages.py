"""Stages of polyhedra read back from the arrays of their certificates, which hold every number of them."""

from __future__ import annotations

import io
import json
from dataclasses import fields
from typing import TYPE_CHECKING, Any

from bsm_mesh.certificate.certificate import OF_SPACE, POLYHEDRA, arrays_file
from bsm_mesh.certificate.verify_certificate import read_arrays
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.records import SupportForces
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra
from bsm_mesh.three_d.point_forces import PointForces3D

if TYPE_CHECKING:
    from bsm_mesh.folder.saved_results import SavedResults

SHAPES = {  # of the rows of blocks
    **dict.fromkeys(("displacement", "stage_displacement", "origin", "loads", "reactions", "water"), (6,)),
    **dict.fromkeys(("stress", "stress_effective"), (3, 3)),
    "present": (),
}


def polyhedra_of(saved: SavedResults) -> Polyhedra:
    """Return the blocks of the model, those that were taken away too; boundaries and excavations are not written."""
    arrays = _arrays(saved, 0)
    names = json.loads(str(arrays["told"]))["blocks"]
    return Polyhedra(
        **{name: arrays[name] for name in POLYHEDRA},
        rock_names=tuple(names["rock_names"]),
        joint_names=tuple(names["joint_names"]),
    )


def columns_in_space(saved: SavedResults, number: int, blocks: Polyhedra, *, bolts: bool) -> dict[str, Any]:
    """Return the fields of a stage that are arrays; `bolts` says whether it has any.

    Raises
    ------
    ValueError
        Where they are not those of the blocks.
    """
    from bsm_mesh.converters.bolt_files import bolts_of_grid
    from bsm_mesh.converters.result_files import BOLTS, kinds_of_space, stage_file

    for kind in kinds_of_space(bolts=bolts):
        saved.content(stage_file(kind, number))  # follows from the arrays; whoever opens it elsewhere trusts it
    arrays = _arrays(saved, number)
    wrong = [name for name, shape in SHAPES.items() if arrays[name].shape != (blocks.count, *shape)]
    if wrong:
        raise ValueError(f"{', '.join(wrong)} of stage {number}")
    contacts = PointForces3D(**{f.name: arrays[f"contact_{f.name}"] for f in fields(PointForces3D)})
    if contacts.face.size and not 0 <= contacts.face.min() <= contacts.face.max() < len(blocks.face_joint):
        raise ValueError(f"faces of contacts in stage {number}")
    read = ("present", "displacement", "reactions", "water", *OF_SPACE)
    return {
        **{name: arrays[name] for name in read},
        "contacts": contacts,
        "supports": SupportForces(**{f.name: arrays[f"support_{f.name}"] for f in fields(SupportForces)}),
        "bolts": bolts_of_grid(saved.grid(stage_file(BOLTS, number))) if bolts else BoltForces.none(3),
    }


def _arrays(saved: SavedResults, number: int) -> dict[str, Any]:
    return read_arrays(io.BytesIO(saved.content(arrays_file(number))))
