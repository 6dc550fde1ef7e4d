"""Proof that blocks must move: a mechanism that no forces within strength can balance, by virtual work.

For velocities v of rigid blocks, equilibrium of any forces in contacts, supports and bolts with the loads F says
``F v = D``, D what those forces take up in v. Strength bounds D: of a contact by the greatest of ``-p dn + S(p) |ds|``
over its pressures p, with dn and ds the velocities of opening and slip there. So where F v is greater than the bounds'
sum no forces within strength are in equilibrium with the loads, whatever the flow rule and the stiffness. The dual of
the linear program gives such a v; that v is right takes sums to see, and no linear program.

A velocity is exact to rounding only. A contact that it closes by rounding would take up much under an enormous
pressure. So the proof is: no forces below a bound balance the loads, and the bound is enormous.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.contact.strength import contact_strength
from bsm_mesh.contact.table import ContactTable, initial_contacts
from bsm_mesh.errors import ModelError
from bsm_mesh.model.loads import point_forces_of
from bsm_mesh.model.model import Model
from bsm_mesh.model.submodel import SubModel, submodel_of
from bsm_mesh.model.supports import Fixed, bars_of
from bsm_mesh.results.evidence import Proof, Witness, bar_rows, law_table
from bsm_mesh.solve.algebra.loads import external_loads
from bsm_mesh.solve.limit.corner_contacts import with_corner_contacts
from bsm_mesh.solve.limit.program import LimitProgram

MAX_BLOCKS = 2000  # that a linear program in a run has: it takes a second, beside the seconds of a collapse
LAYERS = 2  # of neighbours that may move with the unstable blocks
FEASIBLE = "no proof: forces within strength exist that balance the loads, which proves nothing"


def prove(model: Model, down: IntArray) -> Proof:
    """Return the proof that no forces within strength balance a model's loads where its blocks were given, or why not.

    It is looked for among the unstable blocks and their neighbours first: where these cannot be at rest with all
    others fixed, they cannot be with others that may give way.

    Parameters
    ----------
    model : Model
        The present blocks, without stages.
    down : (k,) int32
        Blocks that fall.
    """
    model = model.replace(contact_points="ends")
    try:
        part = None if model.bolts else _around(model, with_corner_contacts(model, initial_contacts(model)), down)
        if part is not None and (proof := _proof_of(part.model)).witness is not None:
            return replace(proof, witness=proof.witness.in_whole(part))
        if model.blocks.count > MAX_BLOCKS:
            return Proof(text=_in_vain(part, model))
        return _proof_of(model)
    except (ModelError, MemoryError) as error:  # what was solved is not lost for want of a proof
        return Proof(text=f"no proof: {str(error) or 'not enough memory'}")


def _in_vain(part: SubModel | None, model: Model) -> str:
    sought = (
        "no proof was sought" if part is None else "no proof was found among every unstable block and its neighbours"
    )
    return f"{sought}, and the model, of {model.blocks.count} blocks, is too large for one of the whole in a run"


def _around(model: Model, contacts: ContactTable, down: IntArray) -> SubModel | None:
    """Return unstable blocks with layers of neighbours, the last fixed; None where that is too much, or all."""
    near = np.zeros(model.blocks.count, dtype=bool)
    near[down] = True
    layers = [near]
    for _ in range(LAYERS + 1):
        near = layers[-1].copy()
        near[contacts.block_a[layers[-1][contacts.block_b]]] = True
        near[contacts.block_b[layers[-1][contacts.block_a]]] = True
        layers.append(near)
    if near.sum() > MAX_BLOCKS or near.all():
        return None
    forces = point_forces_of(model.acting_loads, model.blocks)
    part = submodel_of(model, near, bars_of(model.supports, model.blocks), forces, model.water, model.face_water)
    outermost = np.flatnonzero(~layers[-2][part.block])
    if not outermost.size:
        return part
    return replace(
        part, model=part.model.replace(supports=[*part.model.supports, Fixed(blocks=tuple(outermost.tolist()))])
    )


def _proof_of(model: Model) -> Proof:
    """Return the proof that the linear program gives."""
    program, loads = LimitProgram(model), external_loads(model)
    balance = program.balance(loads)
    if balance.stands:
        return Proof(text=FEASIBLE)
    optimum = program.collapse(loads, balance)
    text = (
        "no forces within strength balance the loads where the blocks were given: they carry at most "
        f"{optimum.factor + 0.0:.6g} times the loads; the blocks must move"
    )
    return Proof(text=text, witness=witness_of(model, program, loads, optimum.velocity, optimum.slip))


def witness_of(
    model: Model, program: LimitProgram, loads: FloatArray, velocity: FloatArray, slip: FloatArray
) -> Witness:
    """Return a mechanism of a model, and of the program of it, with all that a check takes."""
    contacts, bolts, dowels, strength = program.contacts, program.bolts, program.dowels, program.strength
    named = contact_strength(model, contacts)
    return Witness(
        velocity=velocity,
        loads=loads,
        laws=law_table(named.laws),
        law=named.law,
        tension=strength.tension,
        block_a=contacts.block_a,
        block_b=contacts.block_b,
        point=contacts.point,
        normal=contacts.normal,
        length=contacts.length,
        lines=np.stack([strength.slope, strength.intercept], axis=2),
        node_block=bolts.block,
        node_point=bolts.point,
        node_capacity=strength.capacity,
        node_slip=slip,
        element_node=bolts.first_node,
        element_yield=strength.yield_force,
        dowel_block=np.column_stack([dowels.near, dowels.far]),
        dowel_point=program.crossing,
        dowel_across=dowels.across,
        dowel_strength=strength.dowel,
        **bar_rows(program.bars, program.bars.point),
    )
