"""The evidence for a verdict of the continuation: strength, stiffness and supports where the blocks have come to."""

from __future__ import annotations

from typing import Any

import numpy as np

from bsm_mesh.arrays import IntArray
from bsm_mesh.contact.tangents import elastic_contacts
from bsm_mesh.model.loads import PointForces
from bsm_mesh.results.evidence import STRENGTH_STATE, Evidence, bar_rows, law_table
from bsm_mesh.solve.algebra.loads import given_of
from bsm_mesh.solve.bolts.tangent import bolt_tangent
from bsm_mesh.solve.motion.motion import Motion
from bsm_mesh.solve.step.block_system import BlockSystem
from bsm_mesh.solve.step.system import System


def evidence_of(system: BlockSystem, motion: Motion, kept: IntArray) -> Evidence:
    """Return the evidence at the end of a run, for the contacts `kept` (k,) of its contact set."""
    table, at = motion.contacts, motion.at
    block, point, force = system.point_forces_at(motion.position)
    return Evidence(
        **rows_of(system, motion, kept),
        shear_stiffness=np.where(at.closed, at.springs.stiffness, table.shear_stiffness)[kept],
        near=(elastic_contacts(table, at, system.outlines.size) & ~at.closed)[kept],
        **given_of(system.model, system.water, PointForces(block=block, point=point, force=force)),
    )


def rows_of(system: System, motion: Motion, kept: IntArray) -> dict[str, Any]:
    """Return the fields of `Evidence` that do not depend on the number of dimensions."""
    table, turning, bars = motion.contacts, system.load_stiffness(motion.position), motion.constraints.bars
    pair, tangent = bolt_tangent(motion.bolts, motion.bolts_at, turning=True)
    names = ("law", *STRENGTH_STATE, "tension", "residual_tension")
    dilating = table.features.dilating
    dilation = dilating.spread(table.count, dilating.slope, dilating.last).T
    return {
        "laws": law_table(system.catalogue.laws),
        **{name: getattr(table, name)[kept] for name in names},
        "closed_at": table.features.once_open(table.offset, table.slip_path)[kept],
        "dilation": dilation[kept] if system.catalogue.dilates else None,
        "normal_stiffness": motion.at.normal_stiffness[kept],
        "load_stiffness": None if turning is None else (turning + turning.transpose(0, 2, 1)) / 2,
        "velocity": motion.velocity,
        "bolt_pair": pair,
        "bolt_tangent": tangent,
        **bar_rows(bars, system.placed(motion.position)[bars.block] + system.bar_arms(motion.position)),
    }
