"""How far a model is from failure: the same model tried at several values, and the bracket of its last stable one."""

from bsm_mesh.safety.answer import Safety
from bsm_mesh.safety.criterion import Failure
from bsm_mesh.safety.earthquake import Newmark, newmark
from bsm_mesh.safety.factor import factor_of_safety
from bsm_mesh.safety.limits import limit_value
from bsm_mesh.safety.measurements import BackAnalysis, Measured, back_analysis

__all__ = [
    "BackAnalysis",
    "Failure",
    "Measured",
    "Newmark",
    "Safety",
    "back_analysis",
    "factor_of_safety",
    "limit_value",
    "newmark",
]
