"""Zones that move to rest: masses decide how soon, weights and strengths where."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bsm_mesh.contact.rules import RULES
from bsm_mesh.model.shaking import Shaking
from bsm_mesh.solve.motion.following import DAMPED, FREE
from bsm_mesh.solve.zones.shaken_zones import ShakenZones
from bsm_mesh.solve.zones.zone_masses import stable_time_step, weighted_quantile

STILL = Shaking(waveform="pulse", frequency=1.0, amplitude=0.0, duration=1.0, contact_damping=1.0)


class ZonesToRest(ShakenZones):
    """Blocks with zones that move over a base at rest, as `ShakenZones` has them; impacts are damped critically.

    The time step is the one that nine tenths of the moving mass allow. Nodes that are too light for their springs are
    heavier than real, as rigid blocks are. With real masses a splinter would make the time step a hundredth.

    A window lasts as long as a block needs to fall through half the band in which points are found.
    """

    slide = RULES.min_overlap
    keeps_lengths = False
    _rate = 0.0  # greatest stiffness sum over mass [1/s2]

    def _limit_time_step(self) -> None:
        """Set the masses with which the time step is stable, with the present points; first that time step."""
        rock, springs = self._rock, np.zeros(0) if self._window is None else self._window.stiffness
        sums = rock.stiffness_sums(self.equations, self.at, springs)
        if not self._rate:
            there = rock.moves
            self._rate = weighted_quantile(sums[there] / rock.mass[there], rock.mass[there], DAMPED.stiff)
            frequency = np.sqrt(self._rate)
            stable = stable_time_step(frequency, 2 * self._shaking.dashpots * frequency)
            self.memory = replace(self.memory, stable=self._shaking.time_step * stable)
            self.window_cycles = max(FREE.cycles, self._cycles_within(np.zeros((1, 3)), self.memory.stable))
        before = rock.mass
        rock.be_heavier(sums / self._rate)
        slower = np.divide(before, rock.mass, out=np.ones_like(before), where=rock.mass > before)
        self.memory = replace(self.memory, velocity=self.memory.velocity * slower[:, None])  # the momentum stays
