"""Spread: by how much the equilibria differ to which several routes lead. It reports, and chooses nothing."""

from __future__ import annotations

from dataclasses import dataclass

from bsm_mesh.movements import distances
from bsm_mesh.results.records import Status
from bsm_mesh.results.results import Results


@dataclass(frozen=True, slots=True, kw_only=True)
class RouteEnd:
    """Where one route led.

    Attributes
    ----------
    route : str
        Its name.
    status : Status
        The verdict by it.
    stage : str
        The stage in which it ended.
    max_displacement : float [m]
        Greatest displacement of a centroid there.
    unstable_blocks : tuple of int
        Blocks that come down.
    difference : float or None [m]
        Greatest distance of a centroid from where the usual route leaves it, over all stages that both bring to rest;
        None where there are none.
    block : int or None
        The block where that is.
    """

    route: str
    status: Status
    stage: str
    max_displacement: float
    unstable_blocks: tuple[int, ...]
    difference: float | None
    block: int | None


def route_end(route: str, results: Results, usual: Results) -> RouteEnd:
    """Return where a route led, beside the usual one."""
    last, difference, block = results.stages[-1], None, None
    for one, other in zip(results.stages, usual.stages, strict=False):
        if one.status.is_at_rest and other.status.is_at_rest:
            apart = distances(one.displacement - other.displacement) * (one.present & other.present)
            if difference is None or apart.max() > difference:
                difference, block = float(apart.max()), int(apart.argmax())
    return RouteEnd(
        route=route,
        status=results.status,
        stage=last.name,
        max_displacement=last.max_displacement,
        unstable_blocks=tuple(last.unstable_blocks.tolist()),
        difference=difference,
        block=block,
    )


def spread_text(ends: tuple[RouteEnd, ...]) -> str:
    """Return what several routes say together, in words; the first is the usual one."""
    differ = [end for end in ends[1:] if end.status is not ends[0].status]
    known = [end for end in ends[1:] if end.difference is not None]
    told = []
    if differ:
        verdicts = ", ".join(f"{end.status.value} ({end.route})" for end in (ends[0], *differ))
        told.append(f"the verdict depends on the route: {verdicts}")
    else:
        told.append(f"{len(ends)} routes, one verdict")
    if known:
        worst = max(known, key=lambda end: end.difference or 0.0)
        told.append(
            f"equilibria differ by up to {worst.difference:.3g} m (block {worst.block}, {worst.route}), "
            f"the greatest displacement being {ends[0].max_displacement:.3g} m"
        )
    return "; ".join(told)
