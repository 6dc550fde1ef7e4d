"""Shaken stages as ``check`` shows them: the time steps and the processor time to expect."""

from __future__ import annotations

from collections.abc import Iterable

from bsm_mesh.errors import counted, named_stage, place
from bsm_mesh.model.base_motion import BaseMotion
from bsm_mesh.model.model import Model
from bsm_mesh.model.stages import Stage
from bsm_mesh.model.zones import has_zones, zoned_blocks
from bsm_mesh.solve.motion.time_steps import TimeSteps
from bsm_mesh.text.tables import engineering

ORDERS = (
    (30, "less than a minute"),
    (600, "minutes"),
    (3600, "tens of minutes"),
    (86_400, "hours"),
    (3e6, "days"),
)  # up to so many s
SHORT = 5.0  # times shorter than the time step of the median block: a block that decides how long a run takes


def expected_rows(estimates: Iterable[TimeSteps]) -> list[tuple[str, str]]:
    """Return a row a shaken stage: integrator, number and length of its time steps, order of its processor time."""
    return [(f"shaking in {named_stage(each.stage)}", _expected(each)) for each in estimates]


def record_rows(stages: Iterable[Stage]) -> list[tuple[str, str]]:
    """Return a row a stage whose base moves: the greatest acceleration and velocity, which show a missing unit."""
    shaken = [(stage.name, stage.shaking) for stage in stages]
    return [
        (f"base in {named_stage(name)}", BaseMotion(shaking).peaks_in_words)
        for name, shaking in shaken
        if shaking is not None and shaking.boundary is None
    ]


def expected_notes(estimates: Iterable[TimeSteps], model: Model) -> list[str]:
    """Return a note on every shaken stage whose time step one block decides, small or stiff: which, and the cures."""
    blocks = model.blocks
    return [
        f"{named_stage(each.stage)}: block {each.block} at {place(blocks.moments.centroid[each.block].round(3))} m, "
        f"{engineering(float(blocks.moments.area[each.block]), 'm2')}, makes the time step {each.shorter:.2g} times "
        f"shorter than the median block does; {_cure(each, each.block, model)}"
        for each in estimates
        if each.block is not None and each.shorter >= SHORT
    ]


def _cure(each: TimeSteps, block: int, model: Model) -> str:
    if has_zones(model) and not zoned_blocks(model)[block]:
        rock = model.blocks.rock_names[model.blocks.rock[block]]
        return (
            f"its rock '{rock}' has no zones, so it is nearly rigid; give the rock zones, or hold the whole block by a "
            "support with blocks instead of a boundary"
        )
    return (
        f"merge slivers with bsm-mesh check --repair FILE, or change spacing or seed of the joints{_with_scaling(each)}"
    )


def _with_scaling(each: TimeSteps) -> str:
    """Return the cure of heavier blocks, where there is one, and its effect."""
    if each.scaling == 1:
        return ""
    blocks = f"{counted(each.heavier, 'block')} up to {each.scaling:g} times as heavy"
    return (
        f"; or set mass_scaling = {each.scaling:g} in [stage.shaking], with {blocks} and the time step "
        f"{each.longer:.2g} times as long"
    )


def _expected(each: TimeSteps) -> str:
    step = engineering(float(f"{each.time_step:.2g}"), "s")
    steps = counted(int(float(f"{each.steps:.2g}")), "time step")
    return f"{each.integrator}, about {steps} of {step}; processor time: {order_of(each.seconds)}"


def order_of(seconds: float) -> str:
    """Return the order of a processor time in words.

    Examples
    --------
    >>> order_of(4.0), order_of(200.0), order_of(3e5), order_of(5e7)
    ('less than a minute', 'minutes', 'days', 'months or more')
    """
    return next((words for most, words in ORDERS if seconds <= most), "months or more")
