"""Strength of contact points as cones: shear bounded by straight lines of the pressure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError, raise_faults
from bsm_mesh.model.joint_laws.law import JointLaw, StraightLaw
from bsm_mesh.model.materials import Joint, Rock, law_between, tension_between
from bsm_mesh.model.strength import law_name
from bsm_mesh.model.values import Rules
from bsm_mesh.three_d.blocks.contact_polygons import ContactPoints, ContactPolygons
from bsm_mesh.three_d.blocks.polyhedra import Polyhedra


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ConeStrength:
    """What contact points bear: ``|shear| <= slope * pressure + intercept`` for every line, ``pressure >= -tension``.

    Attributes
    ----------
    slope : (m, k) float64
        Of the lines.
    intercept : (m, k) float64 [N]
        Of the lines; infinite for no bound.
    tension : (m,) float64 [N]
        Greatest tension; infinite for no bound.
    """

    slope: FloatArray
    intercept: FloatArray
    tension: FloatArray

    @classmethod
    def coulomb(cls, area: FloatArray, friction: float, cohesion: float = 0.0) -> ConeStrength:
        """Return Coulomb's strength: friction [degrees], cohesion [Pa], of points that stand for areas (m,) [m2]."""
        slope = np.full((len(area), 1), np.tan(np.radians(friction)))
        return cls(slope=slope, intercept=cohesion * area[:, None], tension=np.zeros(len(area)))

    def divided(self, factor: float) -> ConeStrength:
        """Return the strength divided by a factor."""
        return replace(
            self, slope=self.slope / factor, intercept=self.intercept / factor, tension=self.tension / factor
        )


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
            faults += [
                f"there is no {kind} '{name}'; give bsm.{kind.title()}('{name}', ...)"
                for name in names
                if name not in known
            ]
        if default_joint is not None and default_joint not in {joint.name for joint in joints}:
            faults.append(f"default_joint: there is no joint '{default_joint}'")
        raise_faults(faults)
        return cls(rocks=tuple(rocks), joints=tuple(joints), default_joint=default_joint)

    def unit_weights(self, blocks: Polyhedra) -> FloatArray:
        """Return the unit weight of every block, (n,) [N/m3]."""
        by_name = {rock.name: rock.unit_weight for rock in self.rocks}
        return np.array([by_name[name] for name in blocks.rock_names])[blocks.rock]

    def law(self, blocks: Polyhedra, polygons: ContactPolygons, number: int) -> tuple[JointLaw | None, float]:
        """Return the law and the tensile strength [Pa] of a contact polygon; None: it bears whatever comes."""
        index = int(polygons.joint[number])
        name = self.default_joint if index < 0 else blocks.joint_names[index]
        if name is None:
            by_name = {rock.name: rock for rock in self.rocks}
            one, other = (
                by_name[blocks.rock_names[blocks.rock[b]]] for b in (polygons.block_a[number], polygons.block_b[number])
            )
            return law_between(one, other), tension_between(one, other)
        joint = next(joint for joint in self.joints if joint.name == name)
        return joint.law, joint.tensile_strength if joint.law is not None else np.inf

    def strength(self, blocks: Polyhedra, polygons: ContactPolygons, points: ContactPoints) -> ConeStrength:
        """Return the strength of contact points.

        Where a contact has tensile strength the lines are shifted by it: a little more than it bears.

        Raises
        ------
        ModelError
            For a law that has no straight lines.
        """
        ends = blocks.rock[np.stack([polygons.block_a, polygons.block_b])]
        kind = np.stack([polygons.joint, np.where(polygons.joint < 0, ends, -1).min(axis=0), ends.max(axis=0)], axis=1)
        kind[polygons.joint >= 0, 1:] = -1
        _, first, of_polygon = np.unique(kind, axis=0, return_index=True, return_inverse=True)
        slope, intercept = np.zeros((points.count, 1)), np.full((points.count, 1), np.inf)
        tension = np.full(points.count, np.inf)
        for number, polygon in enumerate(first):
            rows = np.flatnonzero(of_polygon.reshape(-1)[points.polygon] == number)
            law, pull = self.law(blocks, polygons, int(polygon))
            if law is None or np.isinf(pull):
                continue
            if not isinstance(law, StraightLaw):
                raise ModelError(
                    f"limit analysis needs strength as straight lines, and the law {law_name(law)} has none"
                )
            a, b = (np.asarray(values, dtype=np.float64) for values in law.strength_lines(points.area[rows]))
            if a.shape[1] > slope.shape[1]:
                more = ((0, 0), (0, a.shape[1] - slope.shape[1]))
                slope, intercept = np.pad(slope, more), np.pad(intercept, more, constant_values=np.inf)
            tension[rows] = pull * points.area[rows]
            slope[rows, : a.shape[1]] = a
            intercept[rows, : a.shape[1]] = b + a * tension[rows, None]
        return ConeStrength(slope=slope, intercept=intercept, tension=tension)
