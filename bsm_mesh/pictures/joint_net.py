"""The joints of a model in space in a stereonet: poles, mean planes, and the circles of the least friction angle."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.model.kinds import in_space
from bsm_mesh.pictures.figures import entitle, paper
from bsm_mesh.results.results import Results

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SIZE = (8.0, 8.8)  # inches
SAME = 6  # digits of a normal: faces of one plane are one pole


def draw_joint_net(results: Results, title: str, figure: Figure | None = None) -> Figure | None:
    """Return the stereonet of the joints as given; None in the plane, and where there are no joints."""
    blocks = results.blocks
    return joint_net(blocks, _least_friction(results), title, figure) if in_space(blocks) else None


def joint_net(
    blocks: Any,
    friction: float | None,
    title: str,
    figure: Figure | None = None,
    *,
    face: tuple[float, float] | None = None,
) -> Figure | None:
    """Return the stereonet of the joints of polyhedra; None without any.

    It has the circles of a friction angle, and the great circle of a slope's face (dip, dip direction) [degrees].
    """
    from bsm_mesh.geometries.stereonet import draw_face, draw_net, draw_sets, finish_net, friction_circles

    polygons = blocks.contact_polygons
    sets = {
        name: orientations(polygons.normal[polygons.joint == number])
        for number, name in enumerate(blocks.joint_names)
        if (polygons.joint == number).any()
    }
    if not sets:
        return None
    figure = figure or paper(SIZE)
    axes = figure.add_subplot()
    draw_net(axes)
    draw_sets(axes, sets)
    turn = np.radians(np.arange(361))
    for radius, style, what in friction_circles(friction):
        axes.plot(radius * np.sin(turn), radius * np.cos(turn), style, color="firebrick", lw=1, label=what)
    if face is not None:
        draw_face(axes, face)
    finish_net(axes, "joints, equal area, lower hemisphere", below=True)
    entitle(figure, title)
    return figure


def orientations(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return dip and dip direction of the planes with these normals (k, 3), each plane once [degrees].

    Examples
    --------
    >>> dip, direction = orientations(np.array([[0.0, -0.6, -0.8], [0.0, 0.6, 0.8]]))
    >>> dip.round(3).tolist(), direction.tolist()
    ([36.87], [0.0])
    """
    up = normals * np.where(normals[:, 2] < 0, -1.0, 1.0)[:, None]
    up = np.unique(up.round(SAME) + 0.0, axis=0)
    return np.degrees(np.arccos(np.minimum(up[:, 2], 1.0))), np.degrees(np.arctan2(up[:, 0], up[:, 1])) % 360.0


def least_friction(angles: Iterable[float | None]) -> float | None:
    """Return the least of some friction angles between 0 and 90 degrees, or None where there is none [degrees]."""
    return min((float(angle) for angle in angles if angle is not None and 0 < angle < 90), default=None)


def _least_friction(results: Results) -> float | None:
    """Return that of the joints in the first stage."""
    stage = results.stages[0]
    if stage.evidence is None:
        return None
    of: IntArray = np.unique(stage.evidence.law[stage.contacts.joint >= 0])
    return least_friction(stage.evidence.laws[number].get("friction") for number in of.tolist())
