"""Whether a model can be analysed: all that a run refuses is found here, before it and at once.

`bsm_mesh.run` and ``bsm-mesh check`` ask the same question, so that a model that passes the check runs.
"""

from __future__ import annotations

import platform
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.contact.in_situ import in_situ_contacts
from bsm_mesh.contact.table import ContactTable, initial_contacts
from bsm_mesh.errors import MAX_NAMED, ModelError, raise_faults
from bsm_mesh.flow.coupling import FlowCoupling
from bsm_mesh.model.model import Model
from bsm_mesh.model.notes import notes_of, of_unusual_rocks
from bsm_mesh.model.options import Options
from bsm_mesh.model.start import start_faults
from bsm_mesh.solve.algebra import pardiso
from bsm_mesh.solve.algebra.block_matrix import block_pattern
from bsm_mesh.solve.algebra.linear_solvers import make_linear_solver
from bsm_mesh.solve.linear.closure import closure_faults
from bsm_mesh.solve.linear.system import LinearSystem


@dataclass(frozen=True, eq=False, slots=True)
class Ready:
    """A model that can be analysed, with the quantities computed for that check.

    Attributes
    ----------
    model : Model
        It, with what flow in the joints presses with at the start.
    contacts : ContactTable
        Its contacts as the blocks are given.
    system : LinearSystem
        Its equations with these, which carry the forces of the in-situ field.
    notes : tuple of str
        Notes for a reader of the results, a sentence each.
    flow : FlowCoupling or None
        Its flow.
    """

    model: Model
    contacts: ContactTable
    system: LinearSystem
    notes: tuple[str, ...]
    flow: FlowCoupling | None


def make_ready(model: Model, options: Options) -> Ready:
    """Return a model that can be analysed by a scheme.

    Raises
    ------
    ModelError
        With everything that forbids it: no load or no support, blocks that overlap, rigid rocks that meet without a
        joint, supports that contradict each other, stiffness beyond the range of the scheme, a linear solver that is
        not there; a flow that is none; in the linear scheme parts that are free to move. The other schemes follow
        these: they are noted.
    """
    faults = [*start_faults(model), *solver_faults(options), *_shaking_faults(model, options)]
    try:
        flow = None if model.flow is None else FlowCoupling(model)
        model = model if flow is None else model.replace(face_water=flow.first.water)
        contacts = initial_contacts(model)
        borne = _borne_at_start(model, contacts)
        system = LinearSystem(model, contacts, *borne)
    except ModelError as error:
        raise ModelError([*faults, *error.faults]) from error
    stiffness = closure_faults(system, options)
    if stiffness:  # of joints with the rock's springs in series: the rock's numbers may be the cause
        faults += of_unusual_rocks(model.rocks)
    faults += stiffness
    free = [part.text for part in system.free_parts()] if len(system.constraints.block) else []
    if options.scheme == "linear":
        faults += free
    raise_faults(faults)
    notes = notes_of(model, fails=options.scheme != "linear")
    if flow is not None:
        flow.apertures.set_in_situ((-borne[0] / contacts.length).reshape(-1, 2)[contacts.joint[::2] >= 0])
    return Ready(model, contacts, system, (*notes, *_notes(free), *_advice(model, options)), flow)


def _shaking_faults(model: Model, options: Options) -> list[str]:
    """Return why stages cannot be shaken; nothing where they can."""
    names = [stage.name for stage in model.stages if stage.shaking is not None]
    if not names or options.scheme == "continuation":
        return []
    return [f"stage '{names[0]}' is shaken, which scheme = '{options.scheme}' cannot do; take 'continuation'"]


def solver_faults(options: Options) -> tuple[str, ...]:
    """Return why a linear solver cannot be had; nothing where it can."""
    try:
        none = np.zeros(0, dtype=np.int32)
        make_linear_solver(options.linear_solver, block_pattern(1, none, none), np.zeros((1, 2))).close()
    except ModelError as error:
        return error.faults
    return ()


def _advice(model: Model, options: Options) -> tuple[str, ...]:
    """Return the advice to install Pardiso for a large model that SuperLU solves because Pardiso is missing."""
    count, can = model.blocks.count, platform.machine() in ("x86_64", "AMD64")
    if options.linear_solver != "auto" or pardiso.is_available() or count < pardiso.LARGE or not can:
        return ()
    return (
        f"SuperLU factorizes this model of {count} blocks. Pardiso gives the same answer and takes half the time or "
        "less: sh bootstrap.sh pardiso, or pip install mkl",
    )


def _borne_at_start(model: Model, contacts: ContactTable) -> tuple[FloatArray, FloatArray]:
    """Return the contact forces where nothing moved, normal and shear, (m,) each [N/m]."""
    if model.in_situ is None or model.in_situ.method != "direct":
        return np.zeros(contacts.count), np.zeros(contacts.count)
    return in_situ_contacts(model, contacts)


def _notes(free: list[str]) -> tuple[str, ...]:
    more = [f"{len(free) - MAX_NAMED} more parts are free to move"] if len(free) > MAX_NAMED else []
    return (*(f"{text}; it is followed where it moves" for text in free[:MAX_NAMED]), *more)
