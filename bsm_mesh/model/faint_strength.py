"""Notes on strength too small to have an effect: most often a number in kPa or kN/m that was given without its unit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from numbers import Real
from typing import Any

from bsm_mesh.model.materials import Joint, Rock
from bsm_mesh.model.model import Model

FAINT = 0.01  # of a block's weight: what carries less has no effect on a verdict
KILO = 1000.0  # Pa or N/m: usual values in kPa or kN/m are below this number
OF_FACES = ("cohesion", "tensile_strength")


def of_faint_strength(model: Model, rocks: Sequence[Rock], joints: Sequence[Joint]) -> Iterator[str]:
    """Say which strengths carry less than a hundredth of a block's weight, and may be in kPa or kN/m."""
    size = float(model.blocks.moments.median_size)
    stress = size * max((rock.unit_weight for rock in rocks), default=0.0)  # weight of a block over one of its sides
    for rock in rocks:
        yield from _of_faces(f"rock '{rock.name}'", (rock,), stress)
    for joint in joints:
        yield from _of_faces(f"joint '{joint.name}'", (joint, joint.law), stress)
    weight = stress * size ** (model.blocks.vertices.shape[1] - 1)  # in the plane per metre of thickness
    for bolt in model.bolts:
        bond = bolt.bond_strength or 0.0
        if 0 < bond < KILO and bond * bolt.length / bolt.spacing < FAINT * weight:
            yield (
                f"bolts: bond_strength = {bond:g} N/m holds less than {100 * FAINT:g} % of a block's weight along a "
                f'whole bolt; a number without its unit is in N/m: write "{bond:g} kN/m" for kN/m'
            )


def _of_faces(thing: str, owners: Sequence[Any], stress: float) -> Iterator[str]:
    for name in OF_FACES:
        for given in (getattr(owner, name, None) for owner in owners):
            value = float(given) if isinstance(given, Real) else 0.0
            if 0 < value < min(FAINT * stress, KILO):
                cure = (
                    f'write "{value:g} kPa" for kPa' if value >= 1 else "write MPa for megapascal, for mPa is 0.001 Pa"
                )
                yield (
                    f"{thing}: {name} = {value:g} Pa carries less than {100 * FAINT:g} % of a block's weight on a side "
                    f"of the block; a number without its unit is in Pa: {cure}"
                )
