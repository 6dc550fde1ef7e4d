"""Results of a stage in zones: forces on every block, its balance, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.falls import Falls
from bsm_mesh.model.in_stage import without_stages
from bsm_mesh.model.loads import PointForces, point_forces_of
from bsm_mesh.model.options import Options
from bsm_mesh.model.supports import Bars, bars_of
from bsm_mesh.model.water_pressure import WaterLoad
from bsm_mesh.results.bolts import BoltForces
from bsm_mesh.results.records import ContactForces, ContactStatus, StageResult, Status, StepRecord, SupportForces
from bsm_mesh.results.zones import ZoneResult
from bsm_mesh.solve.algebra.constraints import constrain_bars
from bsm_mesh.solve.algebra.loads import force_sums, mean_force, reference_weight, relative_residual
from bsm_mesh.solve.algebra.reactions import bar_forces, support_forces
from bsm_mesh.solve.stages.as_built import small_blocks
from bsm_mesh.solve.zones.collapse import falling_blocks
from bsm_mesh.solve.zones.evidence import evidence_of
from bsm_mesh.solve.zones.fields import over_blocks
from bsm_mesh.solve.zones.large_loads import joined, moved_loads
from bsm_mesh.solve.zones.large_water import table_on_outlines
from bsm_mesh.solve.zones.placement import Placement
from bsm_mesh.solve.zones.small_displacements import MOVED, moved_far, on_a_corner
from bsm_mesh.solve.zones.solution import ContinuumSolution
from bsm_mesh.solve.zones.stage_solution import StageEnd, contacts_of, met_rows, movement, stage_solution
from bsm_mesh.solve.zones.stages import Continuum

NO_EQUILIBRIUM = (
    "no equilibrium was found in the zones, which allow small displacements only; displacements are those of the last "
    "equilibrium; give zones displacement = 'large' to follow the blocks, or leave zones out"
)
INSTEAD = "give zones displacement = 'large', or leave zones out"
LARGER = f"for larger ones {INSTEAD}"
NO_LARGE_EQUILIBRIUM = (
    "no equilibrium was found in the zones; displacements are those of the last one, or where motion ended; leave "
    "zones out to see whether blocks fall"
)
NO_SMALL_YIELDED_EQUILIBRIUM = (
    "no equilibrium was found in the zones, whose rock can yield: bsm-mesh safety finds the greatest factor with one; "
    "displacements are those of the last"
)
NO_YIELDED_EQUILIBRIUM = (
    "no equilibrium was found in the zones, whose rock yields; small displacement (displacement = 'small') shows "
    "whether it yields without end, and rigid blocks (without zones) whether blocks fall"
)
LEAVES = (
    "the equilibrium in the zones is unstable: blocks buckle or topple by the least disturbance, and zones do not "
    "follow them; leave zones out to see whether blocks fall"
)


@dataclass(frozen=True, eq=False, slots=True)
class Before:
    """The start of a stage: present blocks (n,), their positions (n, 3), seconds, the reference so far."""

    present: BoolArray
    position: FloatArray
    seconds: float
    reference: float

    @classmethod
    def of(cls, stage: StageResult | None, present: BoolArray, seconds: float) -> Before:
        """Return the end of the stage before; None: the start with the blocks (n,) that are there."""
        if stage is None:
            return cls(present, np.zeros((len(present), 3)), seconds, 0.0)
        return cls(stage.present, stage.origin + stage.displacement, seconds, stage.reference_weight)


def stage_result(of: Continuum, end: StageEnd, before: Before, number: int, options: Options) -> StageResult:
    """Return balance, means over blocks, zones and verdict at the end of a stage.

    Parameters
    ----------
    of : Continuum
        The cells, apart as well.
    end : StageEnd
        Its end.
    before : Before
        The state at its start.
    number : int
        Of the stage.
    options : Options
        Largest residual of a block in balance, and which blocks are too small to count.
    """
    found = stage_solution(of, end, "", before.seconds, ())
    out_of_balance, reactions = _at_nodes(of, end)
    place, here = Placement.of(of, end), end.present[:, None]
    contacts = _contacts(of, end, out_of_balance + reactions, place)
    bars, supports, held = _supports(of, end, reactions, place)
    forces, water = _point_forces(of, end, place), _water(end)
    on_blocks, weight = _of_water(of, end, water, place)[0] * here, end.model.gravity_forces * here
    loads = on_blocks + force_sums(forces, place.centroid)
    loads[:, :2] += weight
    bolts = _as_given(end, found.bolts)
    of_bolts, of_contacts = _of_bolts(bolts, place.centroid), _of_contacts(contacts, place.centroid)
    reference = _reference(end, loads, forces, contacts, of_bolts, before.reference)
    residual = relative_residual(of.model, (loads + held + of_contacts + of_bolts) * here, reference)
    position, zones = _position(of, end, found), _zones(of, found, end)
    small = _small_blocks(of, end, zones, options.falls)
    status, reason = _verdict(of, end, found, position, end.present & ~small, residual, options.tolerance)
    return StageResult(
        name=end.name,
        status=status,
        reason=reason,
        present=end.present,
        displacement=found.displacement,
        stage_displacement=np.where(before.present[:, None], position - before.position, found.displacement) * here,
        origin=position - found.displacement,
        stress=found.stress * here[:, :, None],
        stress_effective=found.stress * here[:, :, None] + _pore_pressure(of, end),
        loads=loads,
        reactions=held,
        water=on_blocks,
        **water.recorded(),
        contacts=contacts,
        supports=supports,
        bolts=bolts,
        unstable_blocks=falling_blocks(of, end),
        small_blocks=np.flatnonzero(small).astype(np.int32),
        start_residual=0.0,
        residual=residual,
        reference_weight=reference,
        steps=(_step_record(end, found, residual, before.seconds, number),),
        evidence=evidence_of(of, end, contacts, forces, water, bars, weight, place),
        zones=zones,
        shaking=end.shaking,
        notes=(*_of_strains(of, end), *_of_corners(of, end)),
    )


def _of_strains(of: Continuum, end: StageEnd) -> tuple[str, ...]:
    """Return a note on strains that are not small, in large displacement."""
    if end.large is None:
        return ()
    strain = end.large.rock.greatest_strains(end.u, of.basis.element_dofs)
    worst = int(strain.argmax())
    if not strain[worst] > MOVED:
        return ()
    return (
        f"zones of block {of.mesh.block[worst]} strain by {100 * strain[worst]:.2g} %: large displacement of zones is "
        f"for small strains, and stresses and strengths there are off by up to {200 * strain[worst]:.2g} %",
    )


def _of_corners(of: Continuum, end: StageEnd) -> tuple[str, ...]:
    """Return a note on blocks that touch others with corners alone, in small displacement."""
    if end.large is not None or not (corner := on_a_corner(of.model, end.present, end.present)):
        return ()
    return (f"block {corner}; {INSTEAD}",)


def _water(end: StageEnd) -> WaterLoad:
    water = None if end.water is None else end.water.load.water
    return WaterLoad(without_stages(end.model, water=water)).of_present(end.present)


def _of_water(of: Continuum, end: StageEnd, water: WaterLoad, place: Placement) -> tuple[FloatArray, FloatArray]:
    """Return the water's force and moment on every block, (n, 3), and their stiffness in large displacement."""
    blocks = of.model.blocks
    if end.large is None:
        zero = np.zeros((blocks.count, 3, 3))
        return water.on_blocks(blocks.vertices, blocks.moments.centroid), zero
    assert of.apart is not None
    return table_on_outlines(water, of.apart, place.node, place.centroid)


def _at_nodes(of: Continuum, end: StageEnd) -> tuple[FloatArray, FloatArray]:
    """Return the unbalanced forces at the nodes of every block, and the reactions."""
    assert of.apart is not None
    return of.apart.out_of_balance(end), of.apart.reactions(end)


def _contacts(of: Continuum, end: StageEnd, left: FloatArray, place: Placement) -> ContactForces:
    """Return the forces at the points of given joints, then those of whole rock and where blocks met later."""
    assert of.apart is not None
    joints, rock, columns = contacts_of(end, with_rock=True), of.apart.ties(end, left, place.node), {}
    given = len(joints.length) - met_rows(end)
    for field in fields(ContactForces):
        values = getattr(joints, field.name)
        columns[field.name] = np.concatenate([values[:given], getattr(rock, field.name), values[given:]])
    return ContactForces(**columns)


def _supports(
    of: Continuum, end: StageEnd, reactions: FloatArray, place: Placement
) -> tuple[Bars, SupportForces, FloatArray]:
    """Return the bars of blocks that are there, the forces at supports, and their sums on every block (n, 3)."""
    assert of.apart is not None
    held = of.apart.sums(reactions, place.node, place.centroid)
    every = bars_of(of.model.supports, of.model.blocks)
    point = place.bars(of, every)
    arm = point - place.centroid[every.block]
    constraints = constrain_bars(of.model, every, arm, np.zeros(len(every.block)), conflicts=False)
    size = bar_forces(constraints, held, arm, np.zeros(len(every.block)))
    rows = np.flatnonzero(end.present[every.block])
    bars = Bars(**{field.name: getattr(every, field.name)[rows] for field in fields(Bars)})
    supports = support_forces(bars, point[rows], size[rows])
    return replace(bars, point=point[rows]), supports, held


def _point_forces(of: Continuum, end: StageEnd, place: Placement) -> PointForces:
    """Return loads, pressures on new faces, and excavation forces that are held back, as forces at points."""
    assert of.apart is not None
    if end.large is not None:
        forces = moved_loads(of, end, place, movement(of, end.u)[:, 2])
    else:
        given = point_forces_of(end.acting, of.model.blocks)
        forces = joined(given, of.apart.nodal_forces(end.pressures - of.apart.held_back(end), place.node))
    here = end.present[forces.block]
    return PointForces(block=forces.block[here], point=forces.point[here], force=forces.force[here])


def _as_given(end: StageEnd, found: BoltForces) -> BoltForces:
    """Return bolts whose dowels act where they cross joints as given: there small displacements have their forces."""
    if end.bolts is None or end.large is not None:
        return found
    dowels, point = end.bolts.bolts.dowels, found.shear_point.copy()
    point[dowels.element] = dowels.crossing
    return replace(found, shear_point=point)


def _of_contacts(contacts: ContactForces, centroid: FloatArray) -> FloatArray:
    """Return the sums of contact forces on every block, (n, 3)."""
    total = np.zeros((len(centroid), 3))
    for block, sign in ((contacts.block_b, 1.0), (contacts.block_a, -1.0)):
        force, arm = sign * contacts.force, contacts.point - centroid[block]
        np.add.at(total, block, np.column_stack([force, arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]]))
    return total


def _of_bolts(bolts: BoltForces, centroid: FloatArray) -> FloatArray:
    block, point, force = bolts.on_blocks()
    return force_sums(PointForces(block=block, point=point, force=force), centroid)


def _reference(
    end: StageEnd,
    loads: FloatArray,
    forces: PointForces,
    contacts: ContactForces,
    on_bolted: FloatArray,
    before: float,
) -> float:
    """Return what residuals are relative to [N/m]: as of rigid blocks, whose contacts in the first stage count too.

    Loads may balance each other on a block, which deforms by them: the mean of the forces counts as well.
    """
    at_start = mean_force(contacts.normal_force, contacts.shear_force) if before == 0 else 0.0
    return max(
        before, reference_weight(end.model, loads, on_bolted, end.present), at_start, mean_force(*forces.force.T)
    )


def _position(of: Continuum, end: StageEnd, found: ContinuumSolution) -> FloatArray:
    """Return the movement of every block since it was given or put back, (n, 3)."""
    before = movement(of, end.origin)
    for fill in end.fills:
        before[fill.blocks] = 0.0
    position: FloatArray = (before + found.displacement) * end.present[:, None]
    return position


def _pore_pressure(of: Continuum, end: StageEnd) -> FloatArray:
    """Return the mean pressure of the water in every block, on the diagonal of (n, 2, 2) [Pa]."""
    if end.water is None:
        return np.zeros((len(end.present), 2, 2))
    area = of.basis.dx.sum(axis=1)
    mean = (end.water.pressure * of.basis.dx).sum(axis=1) / area
    of_block = over_blocks(mean, area, of.mesh.block, of.model.blocks.moments.area) * end.present
    pressure: FloatArray = of_block[:, None, None] * np.eye(2)
    return pressure


def _verdict(
    of: Continuum,
    end: StageEnd,
    found: ContinuumSolution,
    position: FloatArray,
    counts: BoolArray,
    residual: float,
    tolerance: float,
) -> tuple[Status, str]:
    if end.fault:
        return Status.NOT_CONVERGED, end.fault
    if end.fall is not None:
        return Status.UNSTABLE, end.fall.reason
    if end.loose:
        if end.large is None and (corner := on_a_corner(of.model, _loose_blocks(of, end), end.present)):
            return Status.NOT_CONVERGED, f"block {corner}; {INSTEAD}"
        return Status.UNSTABLE, "loads move blocks that neither contacts nor supports hold"
    if end.collapse is not None:
        return Status.UNSTABLE, (
            f"rock yields without end: no equilibrium was found, and any needs displacements above {end.collapse:.3g} m"
        )
    if not found.converged:
        if end.large is None:
            return Status.NOT_CONVERGED, NO_EQUILIBRIUM if end.plastic is None else NO_SMALL_YIELDED_EQUILIBRIUM
        yields = end.at.plastic is not None and bool(end.at.plastic.yields.any())
        return Status.NOT_CONVERGED, NO_YIELDED_EQUILIBRIUM if yields else NO_LARGE_EQUILIBRIUM
    if end.large is not None:
        if end.leaves:
            return Status.NOT_CONVERGED, LEAVES
    elif far := moved_far(of.model, position, counts):
        return Status.NOT_CONVERGED, f"block {far}: {LARGER}"
    if not residual <= tolerance:
        return Status.NOT_CONVERGED, f"a block is out of balance by {residual:.1e} of the reference weight"
    return Status.STABLE, "blocks and zones are in equilibrium"


def _loose_blocks(of: Continuum, end: StageEnd) -> BoolArray:
    found = np.zeros(of.model.blocks.count, dtype=bool)
    found[of.mesh.block[np.concatenate([part.cells for part in end.loose])]] = True
    return found


def _step_record(end: StageEnd, found: ContinuumSolution, residual: float, seconds: float, number: int) -> StepRecord:
    status = found.contacts.status
    return StepRecord(
        stage=number,
        step=0,
        residual=residual,
        max_displacement=float(np.hypot(*found.displacement[:, :2].T).max(initial=0.0)),
        newton_iterations=end.solutions,
        factorizations=end.solutions,
        open_contacts=int((status == ContactStatus.OPEN).sum()),
        slipping_contacts=int((status == ContactStatus.SLIPPING).sum()),
        seconds=seconds,
        method="Newton in zones",
    )


def _small_blocks(of: Continuum, end: StageEnd, zones: ZoneResult, falls: Falls) -> BoolArray:
    """Return the blocks that are there and too small to count, (n,)."""
    pieces = zones.of_pieces(of.model.blocks.moments.bulk * end.present)
    small: BoolArray = small_blocks(of.model, falls, pieces) & end.present
    return small


def _zones(of: Continuum, found: ContinuumSolution, end: StageEnd) -> ZoneResult:
    """Return the zones of the blocks that are there."""
    there = end.present[found.cell_block]
    used, number = np.unique(found.cells[there], return_inverse=True)
    yielded = strain = np.zeros(len(there))
    if end.plastic is not None:
        yielded, strain = end.plastic.over_cells(len(there))
    return ZoneResult(
        points=found.points[used],
        displacement=found.point_displacement[used],
        cells=number.reshape(found.cells[there].shape).astype(np.int32),
        block=found.cell_block[there],
        stress=found.cell_stress[there],
        yielded=yielded[there],
        plastic_strain=strain[there],
    )
