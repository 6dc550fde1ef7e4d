"""Zones in motion: central differences with the real masses of nodes, and the energies of a shaken stage.

Displacements are relative to the base. Velocities are those of half a time step before, as central differences have
them. A window of cycles begins with forces and laws of joints worked out exactly; within it joints follow their
compiled laws, and bolts are as stiff as at its begin.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from bsm_mesh.arrays import ROUNDING, BoolArray, FloatArray
from bsm_mesh.model.base_motion import GRAVITY, BaseMotion
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.solve.motion.following import DAMPED, FREE
from bsm_mesh.solve.motion.shaken_kernels import BASE, BOLTS, DRAG, SPEED
from bsm_mesh.solve.motion.shaking_memory import SUMS, ShakingMemory
from bsm_mesh.solve.zones.equilibrium import Equations
from bsm_mesh.solve.zones.joint_columns import JointWindow
from bsm_mesh.solve.zones.moved_supports import slid_on
from bsm_mesh.solve.zones.moving_points import SLID
from bsm_mesh.solve.zones.quiet_nodes import QuietNodes
from bsm_mesh.solve.zones.rock_in_motion import MovingRock
from bsm_mesh.solve.zones.zone_kernels import advance_zones
from bsm_mesh.solve.zones.zone_masses import greatest_frequency, stable_time_step

BAND = 0.02  # of a block's size: blocks nearer to each other have points, and move by half of it in a window
SINGLE = 1e-6  # of the energy in rock and joints at the start: what single precision leaves of the balance


class _Cycles(NamedTuple):
    """Cycles of a window.

    Attributes
    ----------
    most : int
        How many at most.
    step : float [s]
        Their time step.
    base, wave : (most,) float64
        Acceleration of the base over the square of a cycle [m]; velocity [m/s] or stress [Pa] of a wave.
    velocity : (k, 3) float64 [m]
        Movement of nodes in the cycle before.
    """

    most: int
    step: float
    base: FloatArray
    wave: FloatArray
    velocity: FloatArray


class ShakenZones:
    """Blocks with zones that are shaken.

    Parameters
    ----------
    rock : MovingRock
        The rock at its nodes.
    equations : Equations
        Rock, joints and bolts, with all that acts on them.
    u : (N,) float64 [m]
        Displacements at the start.
    shaking : Shaking
        The shaking as given.
    present : (n,) bool
        Which blocks are there.
    quiet : QuietNodes
        Dashpots of quiet boundaries.

    Attributes
    ----------
    memory : ShakingMemory
        State of the stage; velocities are those of nodes, (k, 3).
    equations : Equations
        With the joints and bolts as they are.
    at : Iterate
        Displacements and forces there.
    diverged : bool
        Whether nodes are nowhere any more.
    damping : float
        Part of the force on a piece of rock that acts against its velocity; 0: vibrations are not damped either.
    touched : (k, 2) int
        Blocks at points that were closed at any time in the last `go_on`.
    is_over : bool
        Whether the base is at rest, or moves on as it does, and no wave enters.
    slide : float
        By how much a point of a joint slides in a window at most, over a zone's side.
    window_cycles : int
        Cycles in a window at most.
    """

    slide = SLID
    keeps_lengths = True  # of closed points, as of rigid blocks in time
    window_cycles = FREE.cycles

    def __init__(
        self,
        rock: MovingRock,
        equations: Equations,
        u: FloatArray,
        shaking: Shaking,
        present: BoolArray,
        quiet: QuietNodes,
    ) -> None:
        self._band = BAND * equations.size * (equations.large is not None)
        self._present = present
        self.equations = equations
        self._search(u)
        self.at = self.equations.at(u, equations.free.none)
        self._rock, self._shaking, self._base, self._quiet = rock, shaking, BaseMotion(shaking), quiet
        self.diverged, self.is_over, self.damping = False, False, 0.0
        self._start = u
        self._along = np.asarray(self._base.axis, dtype=np.float64) * (shaking.boundary is None)
        self._axis = np.append(self._base.axis, 0.0) * (rock.mass > 0)[:, None] * (shaking.boundary is None)
        mass = np.where(rock.mass > 0, rock.mass, 1.0)[:, None]
        self.touched = np.zeros((0, 2), dtype=np.int32)
        self._drag = shaking.drag + quiet.dashpots / mass  # 1/s
        self._window: JointWindow | None = None
        self._counted: FloatArray | None = None
        self._begin()
        joints = 0 if equations.joints is None else equations.joints.joints
        begun = ShakingMemory.begin(len(present), joints, self.stored)
        self.memory = replace(begun, velocity=np.zeros((len(rock.mass), 3)))
        self._limit_time_step()

    def _search(self, u: FloatArray) -> None:
        """Give points the places that they face at displacements u (N,), and where blocks have met."""
        found = slid_on(self.equations, u, self._present, band=self._band, keeps_lengths=self.keeps_lengths)
        self.equations = found or self.equations

    def steps_to(self, until: float) -> int:
        """Return the number of time steps to a time [s], with the present joints."""
        return max(1, int(np.ceil((until - self.memory.time) / self.memory.stable * (1 - 1e-9))))

    def steps_of_blocks(self) -> FloatArray:
        """Return the time step (n,) [s] that the nodes of each block allow, by their stiffness; infinite without."""
        rock = self._rock
        assert self._counted is not None
        sums, parts = rock.stiffness_sums(self.equations, self.at, self._counted), rock.parts.tocoo()
        square = np.divide(sums, rock.mass, out=np.zeros_like(sums), where=rock.moves)
        of_block = np.zeros(len(self._present))
        np.maximum.at(of_block, parts.row, square[parts.col])
        steps: FloatArray = np.divide(2.0, np.sqrt(of_block), out=np.full(len(of_block), np.inf), where=of_block > 0)
        return steps

    def go_on(self, until: float) -> None:
        """Move nodes until a time [s], or until they are nowhere any more."""
        self.touched = self.touched[:0]
        while self.memory.time < until and not self.diverged:
            self._advance(until)

    @property
    def kinetic(self) -> float:
        """Kinetic energy now [N]: of the velocities half a time step before and after."""
        before = self.memory.velocity
        after = before + self._rock.projected(self._accelerations()) * self.memory.time_step
        return float((self._rock.mass[:, None] * before * after).sum() / 2)

    def keep_record(self) -> None:
        """Add a row to the records: the present time, acceleration of the base and energies."""
        base = self._of_base(1, self.memory.time_step)[0] * (self._shaking.boundary is None)
        memory = self.memory.with_record(float(base), self.kinetic, self.stored)
        error = memory.records[-1, -1:]  # the last of `ENERGIES`
        error[np.abs(error) <= SINGLE * abs(memory.springs)] = 0.0
        self.memory = memory

    def _begin(self) -> None:
        """Begin a window: the columns of joints."""
        equations, state = self.equations, self.at.state
        if equations.joints is not None and equations.history is not None and state is not None:
            before = self._window
            same = before is not None and before.count == len(equations.joints.length)
            self._window = JointWindow(equations.joints, equations.history, state, before if same else None)

    def _limit_time_step(self) -> None:
        """Set the longest stable time step, where joints are stiffer than they were when it was set."""
        stiffness = np.zeros(0) if self._window is None else self._window.stiffness
        counted = self._counted if self._counted is not None and len(self._counted) == len(stiffness) else None
        if counted is not None and (stiffness <= counted).all():
            return
        self._counted = stiffness if counted is None else np.maximum(stiffness, counted)
        mass = self._rock.of_unknowns[self.equations.free.free]
        frequency = greatest_frequency(self._rock.stiffness(self.equations, self.at, self._counted), mass)
        stable = stable_time_step(frequency, self._shaking.drag + 2 * self._shaking.dashpots * frequency)
        self.memory = replace(self.memory, stable=min(self.memory.stable, self._shaking.time_step * stable))

    def _advance(self, until: float) -> None:
        """Go through a window, and keep the energies of its parts."""
        cycles, rock, parts = self._cycles(until), self._rock, self._rock.parts
        begun = self._halves(cycles.velocity)
        velocity, step = cycles.velocity.copy(), cycles.step
        mass = rock.mass[:, None] / step**2
        inverse = np.divide(1.0, mass, out=np.zeros_like(mass), where=mass > 0)
        moved, room = np.zeros((2, *velocity.shape)), np.zeros((2, *velocity.shape))
        moved[0, :, :2] = self.at.u[rock.nodes]
        work, pushed, greatest = np.zeros((len(mass), 5)), np.zeros(1), np.zeros(len(self._present))
        points, laws, farthest = self._points(velocity, step)
        went = advance_zones(
            cycles.most,
            farthest,
            rock.own,
            rock.supports,
            rock.cells,
            points,
            tuple(laws.values()),
            rock.bolts(self.equations, self.at),
            (rock.on_nodes(self.equations.load_at(self.at.u)), self._axis * mass, cycles.base),
            np.repeat(inverse, 3, axis=1),
            (self.damping, DAMPED.damping, *rock.pieces),
            velocity,
            moved,
            room,
            (self._drag * step, work),
            (self._quiet.push, cycles.wave, pushed),
            (parts.indptr, parts.indices, parts.data, self._along, parts @ velocity[:, :2], greatest),
        )
        way = np.abs(moved[went % 2, :, :2] - self.at.u[rock.nodes]).max(initial=0.0)
        self.diverged = not way <= rock.extent  # in a window: no number, or nowhere near
        if self.diverged:
            return
        u = self.at.u.copy()
        u[rock.nodes] = moved[went % 2, :, :2]
        loads = float((rock.outer + rock.in_joints) @ (u - self.at.u))
        self._keep_time(until, went, velocity, step)
        self._keep_peaks(work[:, SPEED], greatest)
        slip, damped = self._keep(u, laws)
        halves = begun - self._halves(velocity)
        drag = self._drag_work(work)
        sums = {
            "input": work[:, BASE].sum() + pushed[0] + halves[0],
            "loads": loads,
            "bolts": -work[:, BOLTS].sum() - halves[1],
            "slip": slip.sum(),
            "dashpots": damped,
            "mass_damping": drag[0],
            "quiet": drag[1],
        }
        found = np.array([sums[name] for name in SUMS])
        self.memory = replace(self.memory, sums=self.memory.sums + found, slip_energy=self.memory.slip_energy + slip)

    def _cycles(self, until: float) -> _Cycles:
        """Return the cycles of the next window up to a time [s]."""
        memory = self.memory
        left, last = until - memory.time, memory.time_step
        count = self.steps_to(until)
        step = left / count
        step = last if abs(step - last) <= ROUNDING * left else step
        velocity = memory.velocity
        if last and last != step:  # that of half another time step before
            velocity = velocity + self._rock.projected(self._accelerations()) * (last - step) / 2
        count = min(count, self.window_cycles, self._cycles_within(velocity, step))
        base, wave = self._of_base(count, step) * step**2, np.zeros(count)
        if self._shaking.boundary is not None:
            base, wave = wave, base
            if not self.is_over:
                wave = self._base.velocity_at(memory.time + step * np.arange(count, dtype=np.float64))
        return _Cycles(count, step, base, wave, velocity * step)

    def _cycles_within(self, velocity: FloatArray, step: float) -> int:
        """Return the cycles of a time step [s] in which no node comes through the band, at velocities (k, 3) [m/s]."""
        if self._band == 0:
            return self.window_cycles
        fastest = float(np.hypot(*velocity[:, :2].T).max(initial=0.0))
        time = (np.sqrt(fastest**2 + GRAVITY * self._band) - fastest) / GRAVITY
        return max(1, int(time / step))

    def _of_base(self, count: int, step: float) -> FloatArray:
        """Return the acceleration of the base in cycles from now on, (count,) [m/s2]."""
        if self.is_over:
            return np.zeros(count)
        times = self.memory.time + step * np.arange(count, dtype=np.float64)
        return self._base.acceleration_at(times, step)

    def _keep_peaks(self, speed: FloatArray, acceleration: FloatArray) -> None:
        """Keep the peaks of a window from squares, in cycles: speeds of nodes (k,), accelerations of blocks (n,)."""
        memory, peaks = self.memory, np.zeros((len(self._present), 2))
        of_nodes = np.sqrt(speed) / memory.time_step
        np.maximum.at(peaks[:, 0], self._rock.block, of_nodes[self._rock.cells[0]].max(axis=1))
        peaks[:, 1] = np.sqrt(acceleration) / memory.time_step**2
        self.memory = replace(memory, peaks=np.maximum(memory.peaks, peaks))

    def _keep_time(self, until: float, went: int, velocity: FloatArray, step: float) -> None:
        """Keep time and velocities at the end of a window."""
        memory = self.memory
        time = memory.time + went * step
        self.memory = replace(
            memory,
            time=until if until - time < step / 2 else time,
            time_step=step,
            velocity=velocity / step,
            least_step=min(memory.least_step, step),
            cycles=memory.cycles + went,
            windows=memory.windows + 1,
        )

    def _keep(self, u: FloatArray, laws: dict[str, Any]) -> tuple[FloatArray, float]:
        """Keep where nodes are, and what joints and bolts remember.

        Return what slip took in every joint, (j + 1,) [N], and what dashpots of joints took.
        """
        equations, slip, damped = self.equations, np.zeros_like(self.memory.slip_energy), 0.0
        window, joints = self._window, equations.joints
        if window is not None and joints is not None:
            equations = replace(equations, history=window.after(laws, joints.relative(u)[1]))
        if equations.bolts is not None:
            equations = replace(equations, bolts=equations.bolts.commit(equations.bolts.evaluate(u), u))
        there = equations.at(u, equations.free.none)
        self.equations = equations
        self._search(u)
        self.at = self.equations.at(u, equations.free.none)
        if window is not None and joints is not None and there.state is not None:
            at_points, damped = window.work(laws, there.state)
            joint = np.minimum(joints.joint, len(slip) - 1)  # the last: of rock
            slip = np.bincount(joint, at_points, len(slip)).astype(np.float64)
            self.touched = np.unique(np.concatenate([self.touched, window.touched(laws)]), axis=0)
        self._begin()
        self._limit_time_step()
        return slip, damped

    def _halves(self, velocity: FloatArray) -> FloatArray:
        """Return half the work of input and bolts in a cycle with a velocity (k, 3), (2,) [N]: windows share it."""
        memory = self.memory
        base = self._of_base(1, memory.time_step or memory.stable)[0]
        push = -base * self._axis * self._rock.mass[:, None]
        if self._shaking.boundary is not None and not self.is_over:
            push = self._quiet.push * self._base.velocity_at(np.array([memory.time]))[0]
        bolts = np.zeros_like(push)
        if self.equations.bolts is not None and self.at.bolts is not None:
            bolts = self._rock.on_nodes(self.equations.bolts.forces(self.at.bolts))
        return -np.array([(push * velocity).sum(), (bolts * velocity).sum()]) / 2

    def _drag_work(self, work: FloatArray) -> tuple[float, float]:
        """Return what mass damping and quiet boundaries took, of the work of nodes (k, 5), [N]."""
        taken, whole = work[:, DRAG], self._drag[:, :2].sum(axis=1)
        of_masses = np.divide(2 * self._shaking.drag, whole, out=np.zeros_like(whole), where=whole > 0)
        by_masses = float((taken * of_masses).sum())
        return by_masses, float(taken.sum()) - by_masses

    def _accelerations(self) -> FloatArray:
        """Return the accelerations of nodes by all forces, relative to the base, (k, 3) [m/s2]."""
        memory, mass = self.memory, self._rock.mass[:, None]
        forces = self._rock.on_nodes(self.at.residual)
        if self._shaking.boundary is not None and not self.is_over:
            forces = forces + self._quiet.push * self._base.velocity_at(np.array([memory.time]))[0]
        forces = forces - self._quiet.dashpots * memory.velocity
        found: FloatArray = np.divide(forces, mass, out=np.zeros_like(forces), where=mass > 0)
        found -= self._of_base(1, memory.time_step or memory.stable)[0] * self._axis
        return found

    def _points(self, velocity: FloatArray, step: float) -> tuple[Any, dict[str, Any], FloatArray]:
        """Return points of joints, their laws and how far they may slide, as kernels take them."""
        joints, history = self.equations.joints, self.equations.history
        if joints is None or history is None or self._window is None:
            return self._rock.no_points, self._rock.no_laws, np.zeros(0)
        points, gradient = self._rock.points(joints, history, self.at.u)
        opened, slid = (gradient * velocity[points[0]][:, None, :, :2]).sum(axis=(2, 3)).T
        dashpots = self._shaking.dashpots * self._rock.critical_dashpots(joints, points[0], gradient)
        laws = self._window.chunks(dashpots / step, opened, slid)
        return points, laws, self._window.farthest(FREE.window, self.slide)

    @property
    def stored(self) -> float:
        """Return the energy of rock and springs of joints now, that of the rock at the start apart [N]."""
        equations = self.equations
        energy = self._rock.strain_energy(equations, self.at.u)
        energy += float((self._rock.outer - equations.load) @ (self.at.u - self._start))
        return energy if self._window is None else energy + self._window.energy
