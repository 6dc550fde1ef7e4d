"""The state of a shaken stage from window to window, and from part to part where blocks are taken away."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray
from bsm_mesh.model.submodel import SubModel
from bsm_mesh.results.shaking import ENERGIES, ShakingResult, imbalance_of
from bsm_mesh.solve.motion.quiet_ends import QuietEnds

SUMS = ("input", "loads", "bolts", "slip", "dashpots", "mass_damping", "quiet")


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ShakingMemory:
    """The state of a shaken stage without positions and contacts.

    Attributes
    ----------
    time : float [s]
        Since the stage began.
    velocity : (n, 3) float64 [m/s, m/s, rad/s]
        Of the blocks, half a time step before; of the implicit integrator at the time.
    time_step, stable : float [s]
        The last one, 0 at the start; the largest that was stable so far.
    sums : (7,) float64 [N]
        Energies of `SUMS` since the start.
    springs : float [N]
        Energy in the springs of contacts at the start.
    records : (k, 12) float64
        Time, acceleration of the base and the energies of `ENERGIES` at the times of records.
    peaks : (n, 2) float64 [m/s, m/s2]
        Greatest speed and acceleration of every block.
    slip_energy : (j + 1,) float64 [N]
        What slip took in every joint, and in unjointed rock.
    heavier : (n,) bool
        Blocks that were heavier than real at any time.
    heaviest : float
        Greatest mass over the real one.
    least_step : float [s]
        The smallest time step.
    cycles, windows : int
        So far.
    stored : float [N]
        Kinetic energy and that of springs where blocks have come down.
    quiet : QuietEnds or None
        Of quiet boundaries.
    dashpots : (n, 3) float64 or None [N/m, N/m, N]
        Forces of contacts' dashpots on blocks at the end of the last implicit time step.
    """

    time: float
    velocity: FloatArray
    time_step: float
    stable: float
    sums: FloatArray
    springs: float
    records: FloatArray
    peaks: FloatArray
    slip_energy: FloatArray
    heavier: BoolArray
    heaviest: float
    least_step: float
    cycles: int
    windows: int
    stored: float = 0.0
    quiet: QuietEnds | None = None
    dashpots: FloatArray | None = None

    @classmethod
    def begin(cls, blocks: int, joints: int, springs: float, quiet: QuietEnds | None = None) -> ShakingMemory:
        """Return the state at the start, of so many blocks at rest and so many joints."""
        return cls(
            time=0.0,
            velocity=np.zeros((blocks, 3)),
            time_step=0.0,
            stable=np.inf,
            sums=np.zeros(len(SUMS)),
            springs=springs,
            records=np.zeros((1, 2 + len(ENERGIES))),
            peaks=np.zeros((blocks, 2)),
            slip_energy=np.zeros(joints + 1),
            heavier=np.zeros(blocks, dtype=bool),
            heaviest=1.0,
            least_step=np.inf,
            cycles=0,
            windows=0,
            quiet=quiet,
        )

    def without(self, stored: float) -> ShakingMemory:
        """Return the same without what blocks that were taken away took along: `stored` [N] is left of their energy."""
        sums = self.sums.copy()
        sums[SUMS.index("loads")] += stored - self.stored
        return replace(self, sums=sums, stored=stored)

    @property
    def greatest_energy(self) -> float:
        """The greatest of all recorded energies [N]."""
        return float(np.abs(self.records[:, 2:-1]).max(initial=0.0))

    def with_record(self, base: float, kinetic: float, springs: float, in_ends: float = 0.0) -> ShakingMemory:
        """Return the same with a row more in the records.

        Parameters
        ----------
        base : float [m/s2]
            Acceleration of the base.
        kinetic, springs, in_ends : float [N]
            Energy of the blocks' movement, in springs of contacts, and in the ends of quiet boundaries, now.
        """
        found = {**dict(zip(SUMS, self.sums, strict=True)), "kinetic": kinetic, "springs": springs - self.springs}
        found["quiet"] += in_ends
        found["error"] = found["input"] + found["loads"] - sum(found[name] for name in ENERGIES[2:-1])
        return replace(self, records=np.vstack([self.records, [self.time, base, *(found[name] for name in ENERGIES)]]))

    def in_part(self, part: SubModel) -> ShakingMemory:
        """Return the same of some of the blocks."""
        quiet = None if self.quiet is None else self.quiet.in_part(part)
        names = ("velocity", "peaks", "heavier", *(() if self.dashpots is None else ("dashpots",)))
        return replace(self, quiet=quiet, **{name: getattr(self, name)[part.block] for name in names})

    def in_whole(self, part: SubModel) -> ShakingMemory:
        """Return the same in the numbers of the whole."""
        heavier = np.zeros(len(part.present), dtype=bool)
        heavier[part.block] = self.heavier
        quiet = None if self.quiet is None else self.quiet.in_whole(part)
        names = ("velocity", "peaks", *(() if self.dashpots is None else ("dashpots",)))
        rows: dict[str, Any] = {name: part.in_whole(getattr(self, name)) for name in names}
        return replace(self, heavier=heavier, quiet=quiet, **rows)


def result_of(memory: ShakingMemory) -> ShakingResult:
    """Return what came out of a stage that was shaken."""
    energy = memory.records[:, 2:]
    return ShakingResult(
        time=memory.records[:, 0],
        base_acceleration=memory.records[:, 1],
        energy=energy,
        peak_velocity=memory.peaks[:, 0],
        peak_acceleration=memory.peaks[:, 1],
        slip_energy=memory.slip_energy,
        end_velocity=float(np.hypot(*memory.velocity[:, :2].T).max(initial=0.0)),
        time_step=memory.least_step,
        cycles=memory.cycles,
        windows=memory.windows,
        heavier=memory.heavier,
        heaviest=memory.heaviest,
        imbalance=imbalance_of(energy),
    )
