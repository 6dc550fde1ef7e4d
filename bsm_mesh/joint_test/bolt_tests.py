"""A bolt pulled out across a joint, and sheared by it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from bsm_mesh.arrays import FloatArray, show_only
from bsm_mesh.errors import raise_faults
from bsm_mesh.joint_test.joint_tests import STEPS
from bsm_mesh.joint_test.specimen import Specimen, position_of
from bsm_mesh.model.bolts import Bolt
from bsm_mesh.model.materials import Joint
from bsm_mesh.model.quantities import BOLT_INCLINATION, SHEAR_MOVEMENT, STEPS_OF_TEST
from bsm_mesh.model.values import Rules


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class BoltCurve:
    """A test of a bolt, a row a step; forces are those of one bolt, without the joint's.

    Attributes
    ----------
    displacement : (k,) float64 [m]
        Of the upper block, off the joint or along it.
    force : (k,) float64 [N]
        Against that displacement.
    tension : (k,) float64 [N]
        Greatest in the bolt.
    shear : (k,) float64 [N]
        Greatest across the bolt, where it crosses the joint (dowel action).
    """

    displacement: FloatArray
    force: FloatArray
    tension: FloatArray
    shear: FloatArray

    def __post_init__(self) -> None:
        show_only(self)


def pull_bolt(bolt: Bolt, displacement: float, *, inclination: float = 0.0, steps: int = STEPS) -> BoltCurve:
    """Return the response of a bolt whose joint opens.

    Parameters
    ----------
    bolt : Bolt
        The bolt; one half of it is on either side of the joint, whatever its ends were.
    displacement : float [m]
        Opening of the joint.
    inclination : float [degrees]
        Of the bolt to the joint's normal, towards where the upper block goes when it is sheared.
    steps : int
        In which it is opened.
    """
    return _tested("bolt pulled out", bolt, displacement, inclination, steps, axis=1)


def shear_bolt(bolt: Bolt, displacement: float, *, inclination: float = 0.0, steps: int = STEPS) -> BoltCurve:
    """Return the response of a bolt whose joint is sheared by a displacement [m], the rest as `pull_bolt` takes it."""
    return _tested("bolt sheared", bolt, displacement, inclination, steps, axis=0)


def _tested(what: str, bolt: Bolt, displacement: float, inclination: float, steps: int, *, axis: int) -> BoltCurve:
    rules = Rules(what)
    rules.a_thing("bolt", bolt, Bolt)
    rules.number("displacement", displacement, SHEAR_MOVEMENT)
    rules.number("inclination", inclination, BOLT_INCLINATION)
    rules.number("steps", steps, STEPS_OF_TEST)
    raise_faults(rules.faults)
    length = bolt.length
    along = 0.5 * length * np.array([np.sin(np.radians(inclination)), np.cos(np.radians(inclination))])
    middle = np.array([length, 0.0])
    placed = replace(bolt, start=tuple((middle + along).tolist()), end=tuple((middle - along).tolist()))
    specimen = Specimen(Joint("bare", 1.0, 1.0), length=2 * length, height=length, bolts=(placed,))
    bolts, rows = specimen.system.bolts, []
    for moved in np.linspace(0.0, displacement, steps + 1).tolist():
        at = bolts.evaluate(position_of(*((moved, 0.0) if axis == 0 else (0.0, moved))))
        force = -at.forces[1, axis] * bolt.spacing
        shear = np.abs(at.dowels.force).max(initial=0.0)
        rows.append((moved, force, at.tension.max(initial=0.0), shear))
        bolts = bolts.commit(at)
    names = ("displacement", "force", "tension", "shear")
    return BoltCurve(**dict(zip(names, np.array(rows).T, strict=True)))
