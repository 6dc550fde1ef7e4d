"""The evidence for the verdict on a stage in zones: strength and springs of joints; whole rock has no limit."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.model.joint_laws import Elastic, JointLaw
from bsm_mesh.model.loads import PointForces
from bsm_mesh.model.supports import Bars
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.results.evidence import Evidence, bar_rows, law_table
from bsm_mesh.results.records import ContactForces
from bsm_mesh.solve.algebra.loads import given_of
from bsm_mesh.solve.zones.bolts_on_blocks import tangent_on_blocks
from bsm_mesh.solve.zones.large_water import table_on_outlines
from bsm_mesh.solve.zones.placement import Placement, outline_of
from bsm_mesh.solve.zones.stage_solution import StageEnd, met_rows
from bsm_mesh.solve.zones.stages import Continuum


def evidence_of(
    of: Continuum,
    end: StageEnd,
    contacts: ContactForces,
    forces: PointForces,
    water: WaterLoad,
    bars: Bars,
    weight: FloatArray,
    place: Placement,
) -> Evidence:
    """Return the evidence: laws and springs of joints; whole rock neither slips nor opens."""
    assert of.apart is not None
    joints, history, state = end.joints, end.history, end.at.state
    m = len(contacts.length)
    laws: tuple[JointLaw, ...] = (Elastic(),)
    law, tension = np.zeros(m, np.int32), np.full(m, np.inf)
    failed, path, left = np.zeros(m, dtype=bool), np.zeros(m), np.zeros(m)
    size = np.sqrt(of.model.blocks.moments.area)[contacts.block_b]
    of_rock = end.model.unit_weights * end.present
    first = np.searchsorted(of.mesh.block[np.argsort(of.mesh.block, kind="stable")], contacts.block_b)
    stiff = end.stiffness[np.argsort(of.mesh.block, kind="stable")[first]]
    normal, shear = (stiff[:, k, k] * contacts.length / size for k in (0, 2))
    if joints is not None and state is not None and history is not None:
        on = np.flatnonzero(end.present[joints.block].all(axis=1))
        given = len(on) - met_rows(end)
        rows = np.concatenate([np.arange(given), np.arange(m - len(on) + given, m)])
        laws, law = (*joints.laws, Elastic()), np.full(m, len(joints.laws), np.int32)
        law[rows], failed[rows], path[rows] = joints.joint[on], history.failed[on], history.slip_path[on]
        left[rows] = np.where(history.parted, 0.0, joints.residual_tension)[on]
        tension[rows] = np.where(failed[rows], left[rows], joints.tension[on])
        normal[rows], shear[rows] = state.normal_stiffness[on], state.springs.stiffness[on]
    pair, tangent = np.zeros((0, 2), np.int32), np.zeros((0, 3, 3))
    if end.bolts is not None and end.at.bolts is not None:
        u = None if end.large is None else end.u
        pair, tangent = tangent_on_blocks(end.bolts, end.at.bolts, u, place.centroid)
    return Evidence(
        laws=law_table(laws),
        law=law,
        failed=failed,
        slip_path=path,
        tension=tension,
        residual_tension=left,
        normal_stiffness=normal,
        shear_stiffness=shear,
        near=np.zeros(m, dtype=bool),
        **{**given_of(end.model, water, forces), "weight": weight, "unit_weight": of_rock},
        bolt_pair=pair,
        bolt_tangent=tangent,
        **bar_rows(bars, bars.point),
        **({} if end.large is None else _of_shapes(of, end, forces, water, place)),
    )


def _of_shapes(of: Continuum, end: StageEnd, forces: PointForces, water: WaterLoad, place: Placement) -> dict[str, Any]:
    """Return the fields that describe blocks as they deformed, and how loads and water turn them further."""
    assert of.apart is not None
    turning = table_on_outlines(water, of.apart, place.node, place.centroid)[1]
    arm = forces.point - place.centroid[forces.block]
    np.add.at(turning[:, 2, 2], forces.block, (arm * forces.force).sum(axis=1))
    outline, offsets = outline_of(of.apart.mesh, place.node)
    turning = (turning + turning.transpose(0, 2, 1)) / 2 * end.present[:, None, None]
    return {"load_stiffness": turning, "outline": outline, "outline_offsets": offsets}
