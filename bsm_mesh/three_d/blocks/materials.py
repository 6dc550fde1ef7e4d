"""Rocks and joints of polyhedral blocks: unit weights, and the law of every contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.errors import nearest, raise_faults
from bsm_mesh.model.joint_laws.law import JointLaw
from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.model.rock_faces import law_between, tension_between
from bsm_mesh.model.values import Rules
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Materials:
    """Laws of the contacts between blocks.

    Attributes
    ----------
    rocks : tuple of Rock
        A rock for every name in ``blocks.rock_names``.
    joints : tuple of Joint
        A joint for every name in ``blocks.joint_names``.
    default_joint : str, optional
        Joint of the faces between blocks that bear none; where not given they are faces of rock.
    """

    rocks: tuple[Rock, ...]
    joints: tuple[Joint, ...] = ()
    default_joint: str | None = None

    @classmethod
    def checked(
        cls, blocks: Polyhedra, rocks: Sequence[Rock], joints: Sequence[Joint], default_joint: str | None
    ) -> Materials:
        """Return materials that name everything that blocks do.

        Raises
        ------
        ModelError
            With every rock and joint that is missing.
        """
        rules = Rules("model")
        rocks, joints = rules.things("rocks", rocks, Rock), rules.things("joints", joints, Joint)
        faults = list(rules.faults)
        for kind, names, things in (("rock", blocks.rock_names, rocks), ("joint", blocks.joint_names, joints)):
            known = {thing.name for thing in things}
            missing = [name for name in names if name not in known]
            faults += [f"there is no {kind} '{name}' among the {kind}s{nearest(name, known)}" for name in missing]
        if default_joint is not None and default_joint not in {joint.name for joint in joints}:
            faults.append(f"default_joint: there is no joint '{default_joint}'")
        raise_faults(faults)
        return cls(rocks=tuple(rocks), joints=tuple(joints), default_joint=default_joint)

    def unit_weights(self, blocks: Polyhedra) -> FloatArray:
        """Return the unit weight of every block, (n,) [N/m3]."""
        by_name = {rock.name: rock.unit_weight for rock in self.rocks}
        return np.array([by_name[name] for name in blocks.rock_names])[blocks.rock]

    def laws(
        self, blocks: Polyhedra, pair: IntArray, joint: IntArray
    ) -> tuple[tuple[JointLaw | None, ...], IntArray, FloatArray]:
        """Return the different laws, that of every contact, and its tensile strength [Pa].

        A law that is None, or an infinite tensile strength: its strength has no limit.

        Parameters
        ----------
        blocks : Polyhedra
            The blocks.
        pair : (2, m) int
            The two blocks of every contact.
        joint : (m,) int
            Number of its joint in ``blocks.joint_names``; -1 for none.
        """
        ends, bare = blocks.rock[pair], joint < 0
        kind = np.stack([joint, np.where(bare, ends.min(axis=0), -1), np.where(bare, ends.max(axis=0), -1)])
        kinds, number = np.unique(kind, axis=1, return_inverse=True)
        found = [self._law(blocks, *map(int, one)) for one in kinds.T]
        tension = np.array([pull for _, pull in found])
        return tuple(law for law, _ in found), number.reshape(-1), tension[number.reshape(-1)]

    def _law(self, blocks: Polyhedra, joint: int, one: int, other: int) -> tuple[JointLaw | None, float]:
        name = self.default_joint if joint < 0 else blocks.joint_names[joint]
        if name is None:
            by_name = {rock.name: rock for rock in self.rocks}
            both = by_name[blocks.rock_names[one]], by_name[blocks.rock_names[other]]
            return law_between(*both), tension_between(*both)
        found = next(known for known in self.joints if known.name == name)
        return found.law, found.tensile_strength if found.law is not None else np.inf
