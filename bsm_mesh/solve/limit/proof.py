"""Proof that blocks must move: a mechanism that no forces within strength can balance, by virtual work.

For velocities v of rigid blocks, equilibrium of any forces in contacts, supports and bolts with the loads F says
``F v = D``, D what those forces take up in v. Strength bounds D: of a contact by the greatest of ``-p dn + S(p) |ds|``
over its pressures p, with dn and ds the velocities of opening and slip there. So where F v is greater than the bounds'
sum no forces within strength are in equilibrium with the loads, whatever the flow rule and the stiffness. The dual of
the linear program gives such a v; that v is right takes sums to see, and no linear program.

A velocity is exact to rounding only. A contact that it closes by rounding would take up much under an enormous
pressure. So what is proved is: no forces below a bound balance the loads, and the bound is enormous.
"""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.contact.outlines import Outlines
from bsm_mesh.contact.search import ActiveContacts, detect_contacts, key_of
from bsm_mesh.contact.strength import contact_strength
from bsm_mesh.errors import ModelError, counted
from bsm_mesh.model.model import Model
from bsm_mesh.results.evidence import Proof, Witness, bar_rows, law_table
from bsm_mesh.solve.algebra.loads import external_loads
from bsm_mesh.solve.limit.program import LimitProgram

MAX_BLOCKS = 500  # of which a proof is sought in a run: the linear program then takes less time than the run
TOUCHING = 1e-3  # over the block size: the gap that is contact, as everywhere


def prove(model: Model) -> Proof:
    """Return the proof that no forces within strength balance a model's loads where its blocks were given, or why not.

    Parameters
    ----------
    model : Model
        What is there, without stages.
    """
    if model.blocks.count > MAX_BLOCKS:
        return Proof(text=f"no proof was sought: the model has more than {MAX_BLOCKS} blocks")
    try:
        model = model.replace(contact_points="ends")
        program, loads = LimitProgram(model), external_loads(model)
        if left_out := _left_out(model, program):
            return Proof(text=f"no proof was sought: {left_out}")
        optimum = program.maximise(np.zeros_like(loads), loads, most=1.0)
    except ModelError as error:
        return Proof(text=f"no proof: {error}")
    if optimum.factor >= 1:
        return Proof(text="no proof: forces within strength exist that balance the loads, which proves nothing")
    text = (
        "no forces within strength balance the loads where the blocks were given: they bear at most "
        f"{optimum.factor + 0.0:.6g} times the loads; the blocks must move"
    )
    return Proof(text=text, witness=_witness(model, program, loads, optimum.velocity, optimum.slip))


def _left_out(model: Model, program: LimitProgram) -> str:
    """Return what the contacts of limit analysis, which are faces, leave out of what touches; nothing if all is there.

    Blocks that meet at a node of the mesh without a common face have no contact there.
    """
    blocks, outlines = model.blocks, Outlines.of(model.blocks, np.zeros(model.blocks.count, dtype=bool))
    near = TOUCHING * outlines.size
    found = detect_contacts(outlines, outlines.placed(np.zeros((blocks.count, 3))), ActiveContacts.none(), near)
    corner = blocks.nodes[found.corner]
    at_node = (corner == blocks.nodes[found.edge]) | (corner == blocks.nodes[blocks.following[found.edge]])
    touching = found.in_range & (found.gap <= near) & ~at_node
    faces = key_of(
        np.minimum(program.contacts.block_a, program.contacts.block_b),
        np.maximum(program.contacts.block_a, program.contacts.block_b),
    )
    alone = np.flatnonzero(touching & ~np.isin(found.pair, faces))
    if not alone.size:
        return ""
    a, b = int(found.block_a[alone[0]]), int(found.block_b[alone[0]])
    return f"{counted(alone.size, 'corner')} touch an edge without a common face (blocks {a} and {b})"


def _witness(model: Model, program: LimitProgram, loads: FloatArray, velocity: FloatArray, slip: FloatArray) -> Witness:
    """Return the mechanism with all that a check of it takes."""
    contacts, bolts, dowels = program.contacts, program.bolts, program.dowels
    strength = contact_strength(model, contacts)
    return Witness(
        velocity=velocity,
        loads=loads,
        laws=law_table(strength.laws),
        law=strength.law,
        tension=strength.tension,
        block_a=contacts.block_a,
        block_b=contacts.block_b,
        point=contacts.point,
        normal=contacts.normal,
        length=contacts.length,
        lines=np.stack(strength.lines(), axis=2),
        node_block=bolts.block,
        node_point=bolts.point,
        node_capacity=bolts.capacity / bolts.spacing[bolts.bolt_of_node],
        node_slip=slip,
        element_node=bolts.first_node,
        element_yield=(bolts.yield_force / bolts.spacing)[bolts.bolt_of_element],
        dowel_block=np.column_stack([dowels.near, dowels.far]),
        dowel_point=program.crossing,
        dowel_across=dowels.across,
        dowel_strength=dowels.strength / dowels.spacing,
        **bar_rows(program.bars, program.bars.point),
    )
