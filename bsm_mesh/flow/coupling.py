"""Flow and blocks alternately: water presses on blocks, and blocks open and close the joints in which it flows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, Portable, show_only
from bsm_mesh.errors import ModelError, listing, place, placed
from bsm_mesh.flow.apertures import Apertures
from bsm_mesh.flow.boundaries import Boundaries, boundaries_of, reservoir_parts
from bsm_mesh.flow.joint_network import joint_network
from bsm_mesh.flow.network import cubic_law
from bsm_mesh.flow.pressures import face_water, wet_pieces
from bsm_mesh.flow.steady import SteadyFlow, solve_steady
from bsm_mesh.model.face_water import FaceWater
from bsm_mesh.model.flow import Flow
from bsm_mesh.model.flow_faults import flow_in_stage
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import presence
from bsm_mesh.results.flow import FlowResult
from bsm_mesh.results.records import StageResult


@dataclass(frozen=True, eq=False, repr=False, slots=True, kw_only=True)
class FlowState(Portable):
    """Agreement of flow and blocks: the pressures on the blocks, and the start of the next iteration.

    Attributes
    ----------
    u : (n,) float64 [m]
        Unknowns of the flow whose water presses.
    aperture : (k, 2) float64 [m]
        At both ends of every face, as the blocks stood last.
    water : FaceWater
        What presses on the blocks, on edges of the whole.
    step : (n,) float64 [m]
        By which pressure heads were found off in the last turn.
    part : float
        Of that step that was taken.
    rounds : int
        Turns in this stage.
    """

    u: FloatArray
    aperture: FloatArray
    water: FaceWater
    step: FloatArray
    part: float
    rounds: int

    def __post_init__(self) -> None:
        show_only(self)


class FlowCoupling:
    """The flow of a model in all its stages.

    Parameters
    ----------
    model : Model
        With a ``flow``.

    Raises
    ------
    ModelError
        Where drains, wells and grout of any stage meet no joint, or there is no steady flow in it.

    Attributes
    ----------
    first : FlowState
        Flow before anything moved, in joints without stress.
    """

    def __init__(self, model: Model) -> None:
        last = flow_in_stage(model, len(model.stages))
        assert last is not None
        self.model, self.joints = model, joint_network(model, last.drains, last.wells, last.grout)
        self.apertures = Apertures(model, self.joints)
        at_start, *later = presence(model.stages, model.blocks)
        self.first = self.begin(0, at_start)
        for number, (stage, here) in enumerate(zip(model.stages, later, strict=True), start=1):
            with placed(f"stage '{stage.name}'"):
                self.begin(number, here)  # the fault with it is reported before the run

    def begin(self, number: int, present: BoolArray, before: FlowState | None = None) -> FlowState:
        """Return the flow at the start of a stage: in joints as they stood last, or before anything pressed on them.

        Raises
        ------
        ModelError
            If there is no steady flow.
        """
        aperture = self.apertures.given if before is None else before.aperture
        return _Turn(self, number, present).started(aperture)[0]

    def result(self, state: FlowState, number: int, present: BoolArray) -> FlowResult:
        """Return the record of the flow in joints as they stood last."""
        return _Turn(self, number, present).started(state.aperture)[1]

    def go_on(
        self, state: FlowState, number: int, present: BoolArray, stage: StageResult, moved: FloatArray, *, in_rows: bool
    ) -> tuple[FlowState, FlowResult]:
        """Return the flow in joints as the blocks are, and where that leaves both.

        Parameters
        ----------
        state : FlowState
            What pressed on them.
        number : int
            Of the stage.
        present : (n,) bool
            Blocks that are there.
        stage : StageResult
            At rest under that pressure, in the numbers of the whole.
        moved : (n, 3) float64 [m, m, rad]
            Displacement of every block since it was given.
        in_rows : bool
            As in `Apertures.after`.
        """
        two_way = self._in_stage(number).coupling == "two_way"
        aperture = self.apertures.after(stage.contacts, moved, in_rows=in_rows) if two_way else state.aperture
        return _Turn(self, number, present).taken(state, aperture)

    def is_settled(self, result: FlowResult, number: int) -> bool:
        """Return whether pressures no longer change."""
        return result.change <= self.tolerance(number)

    def tolerance(self, number: int) -> float:
        """Return the change of pressures, over the greatest, below which they count as settled in a stage."""
        return self._in_stage(number).tolerance

    def most_rounds(self, number: int) -> int:
        """Return after how many turns a stage counts as not converged."""
        return self._in_stage(number).max_rounds

    def _in_stage(self, number: int) -> Flow:
        flow = flow_in_stage(self.model, number)
        assert flow is not None
        return flow


class _Turn:
    """One solution of the flow in a stage."""

    def __init__(self, coupling: FlowCoupling, number: int, present: BoolArray) -> None:
        flow = flow_in_stage(coupling.model, number)
        assert flow is not None
        self.joints, self.blocks, self.flow, self.present = coupling.joints, coupling.model.blocks, flow, present
        self.boundaries: Boundaries = boundaries_of(coupling.joints, self.blocks, flow, present)

    def started(self, aperture: FloatArray) -> tuple[FlowState, FlowResult]:
        """Return the flow in joints of some aperture (k, 2), whose pressure is put on the blocks as a whole."""
        ends, conductance, found = self._solved(aperture, None)
        wet = self._wet(found, conductance)
        state = FlowState(
            u=found.u, aperture=aperture, water=self._water(wet), step=np.zeros_like(found.u), part=1.0, rounds=0
        )
        return state, self._result(found, ends, wet, 0, 0.0)

    def taken(self, state: FlowState, aperture: FloatArray) -> tuple[FlowState, FlowResult]:
        """Return the flow in joints of some aperture, part of whose change of pressure is put on the blocks.

        The part is Aitken's where that is one, else all: B.M. Irons, R.C. Tuck, Int. J. Num. Meth. Eng. 1 (1969)
        275-277.
        """
        ends, conductance, found = self._solved(aperture, state.u)
        before = np.maximum(state.u, 0.0)
        step = found.pressure_head - before
        greatest = max(float(found.pressure_head.max(initial=0.0)), float(before.max(initial=0.0)))
        change = float(np.abs(step).max(initial=0.0)) / greatest if greatest > 0 else 0.0
        part = state.part
        turned = step - state.step
        if state.rounds and (turned**2).sum() > 0:
            aitken = -part * float((state.step * turned).sum() / (turned**2).sum())
            part = aitken if 0 < aitken < 1 else 1.0
        u = found.u if part == 1 else np.where(found.u > 0, before + part * step, found.u)
        pressing = replace(found, u=u)
        wet = self._wet(found, conductance)
        water = self._water(wet if part == 1 else self._wet(pressing, conductance))
        after = FlowState(u=u, aperture=aperture, water=water, step=step, part=part, rounds=state.rounds + 1)
        return after, self._result(found, ends, wet, after.rounds, change)

    def _solved(self, aperture: FloatArray, start: FloatArray | None) -> tuple[FloatArray, FloatArray, SteadyFlow]:
        """Return apertures at both ends of the pieces, their conductances, and the flow in them."""
        joints, flow = self.joints, self.flow
        of_face, part = aperture[joints.face], joints.part
        ends = of_face[:, :1] + part * (of_face[:, 1:] - of_face[:, :1])
        for inside, grout in zip(joints.in_grout, flow.grout, strict=False):
            ends[inside] = grout.aperture
        conductance = cubic_law(ends[:, 0], ends[:, 1], joints.network.length, flow.unit_weight, flow.viscosity)
        conductance = np.where(self.boundaries.there, conductance, 0.0)
        found = solve_steady(joints.network, conductance, self.boundaries.conditions, start)
        if not found.converged and start is not None:
            found = solve_steady(joints.network, conductance, self.boundaries.conditions)
        if not found.converged:
            raise ModelError(self._why_none(conductance, found))
        return ends, conductance, found

    def _why_none(self, conductance: FloatArray, found: SteadyFlow) -> str:
        """Return why there is no steady flow."""
        given = self.boundaries.conditions
        part = self.joints.network.parts(conductance > 0)
        outlets = np.unique(part[given.given | np.isfinite(given.spill)])
        stuck = [
            k
            for k, well in enumerate(self.flow.wells)
            if well.discharge < 0 and part[self.joints.at_well[k]] not in outlets
        ]
        if stuck:
            at = place(self.flow.wells[stuck[0]].point)
            return (
                f"flow: water of well {listing(k + 1 for k in stuck)} (the first at {at}) cannot leave; give the "
                "joints around it an outlet (head, seepage, a drain), or remove the well"
            )
        return (
            f"flow: no steady flow was found: after {found.iterations} iterations a node is still out of balance by "
            f"{found.imbalance:.2g} of the greatest discharge; look for a slip in apertures, levels and wells"
        )

    def _wet(self, found: SteadyFlow, conductance: FloatArray) -> tuple[FloatArray, FloatArray]:
        return wet_pieces(self.joints.network, found, conductance > 0)

    def _water(self, wet: tuple[FloatArray, FloatArray]) -> FaceWater:
        reservoirs = reservoir_parts(self.blocks, self.flow, self.present)
        return face_water(self.joints, self.blocks, self.boundaries.there, wet, reservoirs, self.flow.unit_weight)

    def _result(
        self, found: SteadyFlow, ends: FloatArray, wet: tuple[FloatArray, FloatArray], rounds: int, change: float
    ) -> FlowResult:
        """Return the record of a flow."""
        network, there = self.joints.network, self.boundaries.there
        part, heads = wet
        edge, ends_of_shore, pressure = reservoir_parts(self.blocks, self.flow, self.present)
        ends_of_pieces = np.stack([network.first[there], network.last[there]])
        node, number = np.unique(ends_of_pieces, return_inverse=True)  # where no joint is any more there is no node
        first, last = number.reshape(ends_of_pieces.shape).astype(np.int32)
        start = self.blocks.vertices[edge]
        along = self.blocks.vertices[self.blocks.following[edge]] - start
        return FlowResult(
            point=network.point[node],
            head=found.head[node],
            filled=found.filled[node],
            outflow=found.outflow[node],
            place=self.boundaries.place[node],
            places=self.boundaries.names,
            first=first,
            last=last,
            joint=self.joints.joint[self.joints.face][there],
            aperture=ends[there],
            discharge=found.discharge[there],
            wet=part[there],
            wet_pressure=self.flow.unit_weight * heads[there],
            shore=start[:, None] + ends_of_shore[:, :, None] * along[:, None],
            shore_pressure=pressure,
            imbalance=found.imbalance,
            rounds=rounds,
            change=change,
        )
