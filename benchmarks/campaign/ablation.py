"""What a method or a setting is worth: the same models without it, or with another value."""

from __future__ import annotations

import importlib
import pkgutil
import sys
from dataclasses import dataclass, is_dataclass, replace
from typing import Any

import bsm_mesh.solve


@dataclass(frozen=True, kw_only=True)
class Ablation:
    """A change of the engine for a campaign.

    Attributes
    ----------
    without : tuple of str
        Methods that no plan has.
    settings : tuple of str
        ``module.field=value``, as ``dynamic_relaxation.ramp=20`` or ``following.going_on.damping=0.1``: of the
        `SETTINGS` of a module of `bsm_mesh.solve`.
    """

    without: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()

    def __str__(self) -> str:
        return "; ".join([*(f"without {name}" for name in self.without), *self.settings])

    def apply(self) -> None:
        """Change the engine of this process.

        Raises
        ------
        ValueError
            For a method or a setting that there is not.
        """
        for name in self.without:
            _remove(name)
        for setting in self.settings:
            _set(setting)


def _remove(name: str) -> None:
    from bsm_mesh.solve.continuation.plan import PLANS

    known = {method.name for plan in PLANS.values() for method in plan}
    if name not in known:
        raise ValueError(f"there is no method '{name}'; there are {', '.join(sorted(known))}")
    for phase, plan in PLANS.items():
        PLANS[phase] = tuple(method for method in plan if method.name != name)


def _set(setting: str) -> None:
    path, _, value = setting.partition("=")
    module, *fields = path.split(".")
    owners = {name: owner for name, owner in _modules().items() if hasattr(owner, "SETTINGS")}
    if module not in owners or not fields or not value:
        raise ValueError(f"'{setting}' sets nothing; write module.field=value, of {', '.join(sorted(owners))}")
    old = owners[module].SETTINGS
    new = _changed(old, fields, value)
    for other in list(sys.modules.values()):  # others may have imported it under a name of their own
        for key, held in list(vars(other).items()) if other else []:
            if held is old:
                setattr(other, key, new)


def _changed(settings: Any, fields: list[str], value: str) -> Any:
    name, *rest = fields
    if not hasattr(settings, name):
        raise ValueError(f"{type(settings).__name__} has no field '{name}'")
    held = getattr(settings, name)
    if rest or is_dataclass(held):
        return replace(settings, **{name: _changed(held, rest, value)})
    return replace(settings, **{name: type(held)(float(value))})


def _modules() -> dict[str, Any]:
    """Return the modules of the solver by their last name."""
    found = pkgutil.walk_packages(bsm_mesh.solve.__path__, "bsm_mesh.solve.")
    names = [f.name for f in found if f.name.split(".")[2] in ("continuation", "methods", "motion")]
    return {name.rpartition(".")[2]: importlib.import_module(name) for name in names}
