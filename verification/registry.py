"""All cases, by topic. A new topic is a module with `CASES` and one line here."""

from __future__ import annotations

from dataclasses import dataclass

from verification import (
    continuum,
    flow,
    joint_laws,
    laid_lines,
    masonry,
    programs,
    rockbolts,
    slopes,
    thesis_blocks,
    thesis_bolts,
    thesis_examples,
    thesis_joints,
    thesis_water,
    three_dimensions,
)
from verification.case import Case


@dataclass(frozen=True)
class Topic:
    """Cases of one kind.

    Attributes
    ----------
    name, title : str
        Of its table, and of its heading.
    cases : tuple of Case
        In the order of the table.
    """

    name: str
    title: str
    cases: tuple[Case, ...]


TOPICS: tuple[Topic, ...] = (
    Topic("blocks", "Blocks and contacts (thesis, chapter 3 and appendix B)", thesis_blocks.CASES),
    Topic("joints", "Strength of joints, iteration, ground stress (chapter 4)", thesis_joints.CASES),
    Topic("bolts", "Bolts, equation by equation (chapter 5)", thesis_bolts.CASES),
    Topic("water", "Groundwater (chapter 6)", thesis_water.CASES),
    Topic("flow", "Flow of water in joints", flow.CASES),
    Topic("examples", "The thesis's examples", thesis_examples.CASES),
    Topic("slopes", "Blocks on planes and slopes", slopes.CASES),
    Topic("laid", "Joints laid through meshes", laid_lines.CASES),
    Topic("masonry", "Arches, stacks, columns", masonry.CASES),
    Topic("space", "Key blocks and limit analysis in three dimensions", three_dimensions.CASES),
    Topic("continuum", "Elastic rock", continuum.CASES),
    Topic("laws", "Laws of joints on the bench", joint_laws.CASES),
    Topic("rockbolts", "Bolts in models", rockbolts.CASES),
    Topic("programs", "Other solvers, run here", programs.CASES),
)
CASES: dict[str, Case] = {case.name: case for topic in TOPICS for case in topic.cases}
