"""Laboratory tests of a joint, and of a bolt across it, by the contacts, laws and bolts of a run."""

from bsm_mesh.joint_test.bolt_tests import BoltCurve, pull_bolt, shear_bolt
from bsm_mesh.joint_test.joint_tests import JointCurve, closure_test, direct_shear_test

__all__ = ["BoltCurve", "JointCurve", "closure_test", "direct_shear_test", "pull_bolt", "shear_bolt"]
