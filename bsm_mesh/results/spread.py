"""Spread: by how much equilibria differ to which several routes, or runs in time, lead. It chooses nothing."""

from __future__ import annotations

from dataclasses import dataclass

from bsm_mesh.movements import distances
from bsm_mesh.results.records import Status
from bsm_mesh.results.results import Results

FAR_APART = 0.1  # of the least permanent displacement: from there on the range is the answer


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
        Blocks that fall.
    difference : float or None [m]
        Greatest distance of a centroid from where the usual route leaves it, over all stages that both bring to rest;
        None where there are none.
    block : int or None
        The block where that is.
    permanent : float or None [m]
        Greatest displacement that a shaken stage leaves; None where none is shaken, or it has no verdict of rest.
    same_loads : bool
        Whether its loads are those of the usual route; False for a record turned over. With other loads another verdict
        does not show a limit.
    """

    route: str
    status: Status
    stage: str
    max_displacement: float
    unstable_blocks: tuple[int, ...]
    difference: float | None
    block: int | None
    permanent: float | None = None
    same_loads: bool = True


def route_end(route: str, results: Results, usual: Results, *, same_loads: bool = True) -> RouteEnd:
    """Return where a route led compared with the usual one; with other loads no distance between both is given."""
    last, difference, block = results.stages[-1], None, None
    for one, other in zip(results.stages, usual.stages, strict=False):
        if same_loads and one.status.is_at_rest and other.status.is_at_rest:
            apart = distances(one.displacement - other.displacement) * (one.present & other.present)
            if difference is None or apart.max() > difference:
                difference, block = float(apart.max()), int(apart.argmax())
    left = [one.max_stage_displacement for one in results.stages if one.shaking is not None and one.status.is_at_rest]
    return RouteEnd(
        permanent=max(left, default=None),
        same_loads=same_loads,
        route=route,
        status=results.status,
        stage=last.name,
        max_displacement=last.max_displacement,
        unstable_blocks=tuple(last.unstable_blocks.tolist()),
        difference=difference,
        block=block,
    )


def is_near_limit(ends: tuple[RouteEnd, ...]) -> bool:
    """Return whether routes under the same loads lead to different verdicts: then neither verdict is certain."""
    return len({end.status for end in ends if end.same_loads}) > 1


def spread_text(ends: tuple[RouteEnd, ...]) -> str:
    """Return what several routes say together, in words; the first is the usual one."""
    differ = [end for end in ends[1:] if end.status is not ends[0].status and end.same_loads]
    others = [end for end in ends if not end.same_loads]
    known = [end for end in ends[1:] if end.difference is not None]
    told = []
    if is_near_limit(ends):
        verdicts = ", ".join(f"{end.status.value} ({end.route})" for end in (ends[0], *differ))
        told.append(f"near its limit: the verdict depends on the route: {verdicts}")
    else:
        told.append(f"{len(ends) - len(others)} routes, one verdict")
    told += [f"another load, {end.route}: {end.status.value}" for end in others]
    if known:
        worst = max(known, key=lambda end: end.difference or 0.0)
        told.append(
            f"equilibria differ by up to {worst.difference:.3g} m (block {worst.block}, {worst.route}), "
            f"the greatest displacement being {ends[0].max_displacement:.3g} m"
        )
    left = [end.permanent for end in ends if end.permanent is not None]
    if len(left) > 1:
        apart = max(left) - min(left)
        what = f"greatest permanent displacement {min(left):.3g} to {max(left):.3g} m in {len(left)} runs"
        told.append(
            f"{what}: give this range, a single run is no answer here"
            if apart > FAR_APART * min(left)
            else f"{what}, less than a tenth apart"
        )
    return "; ".join(told)
