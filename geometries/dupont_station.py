"""Dupont Circle Station, first stage of excavation: the case history of Wang section 8.2, a reconstruction.

The middle of the crown is the origin, the top of rock y = 9 m. Sizes of the opening and the ranges of joint and
shear-zone spacings are the text's; where the joints lie is in Figs. 8.2 and 8.3 only, and is assumed here: regular,
or drawn from the text's ranges by a seed.
"""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from bsm_mesh.geometries.parameters import ParameterChecks

OPENING = (-3.0, -8.0, 3.0, 0.0)  # 6 m x 8 m: left, bottom, right, top
COVER = 9.0  # m of rock over the crown
CORNER, FOOT = (3.0, 0.0), (3.0, -8.0)  # of the right wall
SHORTEST = 0.5  # m: shorter sides are closed, so that no sliver is left where joints meet the outlines
JOINTS_APART = (1.0, 3.0)  # m, of both joint sets: the range of the text, drawn from evenly, as are the next two
ZONES_APART = (3.0, 15.0)  # m, from the middle of a zone to that of the next
ZONE_WIDTH = (SHORTEST, 3.0)  # m; the text begins at 1/3 m, which the mesh would close

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Where shear zones and joints lie.

    Attributes
    ----------
    zones, widths : (n,) float64 [m]
        Distances of the zones' middles from the foot of the right wall, to the right and down; their widths.
    joints : (m,) float64 [m]
        The same of the joints J1.
    cross_joints : (k,) float64 [m]
        Distances of the joints J2 from the upper right corner, upwards.
    """

    zones: FloatArray
    widths: FloatArray
    joints: FloatArray
    cross_joints: FloatArray


def build(
    path: str | os.PathLike[str],
    *,
    width: float = 92.0,
    below: float = 25.0,
    dip: float = 60.0,
    joint_spacing: float = 2.0,
    cross_dip: float = -30.0,
    cross_spacing: float = 2.0,
    zone_spacing: float = 10.0,
    zone_width: float = 1.0,
    zone_offset: float = 0.0,
    seed: int | None = None,
    **unknown: object,
) -> Path:
    """Write the mesh of the station before excavation and return its path.

    Quadrilaterals alone, every joint block divided around its centroid; to be read with ``blocks = "elements"``.
    Surfaces ``rock:rock``, ``rock:shear_zone`` and ``excavation:1``; curves ``joint:J1`` (parallel to the shear zones),
    ``joint:J2`` (across), ``joint:SZ`` (borders of the zones), ``boundary:bottom``, ``left``, ``right``, ``top``.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    width : float
        Width of the model, the opening in its middle [m].
    below : float
        Depth of the model under the crown [m].
    dip : float
        Angle of shear zones and of the joints J1 from the x axis, rising to the right [degrees].
    joint_spacing : float
        Distance of the joints J1, about: they divide the rock between two zones evenly [m].
    cross_dip : float
        Angle of the cross joints J2 from the x axis, falling to the right if negative [degrees].
    cross_spacing : float
        Distance of the joints J2 [m].
    zone_spacing : float
        Distance of the middles of the shear zones, across them [m].
    zone_width : float
        Width of a shear zone [m].
    zone_offset : float
        Distance of the middle of a zone from the foot of the right wall, to the right and down [m]. At 0 the crown and
        the right wall are faces of the same panel of rock between two zones, which rests on the zone below.
    seed : int, optional
        Draw the layout by it instead. Distances, widths and first places of zones, joints and cross joints are drawn
        evenly from the text's ranges. Spacings, `zone_width` and `zone_offset` must then be left out.
    **unknown
        Refused, with the nearest parameter that there is.

    Raises
    ------
    GeometryError
        With all faults of the parameters, and for networks that leave slivers.
    """
    checks = ParameterChecks(build, unknown)
    sizes = {"width": width, "below": below, "joint_spacing": joint_spacing, "cross_spacing": cross_spacing}
    checks.positive(**sizes, zone_spacing=zone_spacing, zone_width=zone_width)
    checks.within(20.0, 90.0, "degrees", dip=dip)
    checks.within(-60.0, 15.0, "degrees", cross_dip=cross_dip)
    checks.within(-100.0, 100.0, "m", zone_offset=zone_offset)
    if seed is not None and checks.count(0, seed=seed):
        regular = joint_spacing, cross_spacing, zone_spacing, zone_width, zone_offset
        if regular != (2.0, 2.0, 10.0, 1.0, 0.0):
            checks.add(f"seed = {seed} draws the layout; leave out spacings, zone_width and zone_offset, or the seed")
    checks.raise_faults()
    if zone_width >= zone_spacing:
        checks.add(f"zone_width = {zone_width:g} m leaves no rock between zones {zone_spacing:g} m apart; give less")
    if width <= OPENING[2] - OPENING[0] or below <= -OPENING[1]:
        checks.add(f"the model, {width:g} m wide and {below:g} m below the crown, must be larger than the opening")
    checks.raise_faults()
    reach = width + below + COVER
    if seed is None:
        layout = regular_layout(reach, joint_spacing, cross_spacing, zone_spacing, zone_width, zone_offset)
    else:
        layout = drawn_layout(reach, seed)
    return _mesh(path, width, below, dip, cross_dip, layout)


def regular_layout(
    reach: float, joint_spacing: float, cross_spacing: float, zone_spacing: float, zone_width: float, zone_offset: float
) -> Layout:
    """Return zones and joints at even distances up to `reach` to both sides, all in m, as `build` says."""
    number = math.ceil(reach / zone_spacing) + 1
    zones = zone_offset + zone_spacing * np.arange(-number, number + 1)
    clear = zone_spacing - zone_width
    parts = max(1, round(clear / joint_spacing))
    joints = zones[:, None] + zone_width / 2 + clear / parts * np.arange(1, parts)
    across = math.ceil(reach / cross_spacing)
    return Layout(
        zones=zones.astype(np.float64),
        widths=np.full(len(zones), zone_width),
        joints=joints.ravel(),
        cross_joints=(cross_spacing * np.arange(-across, across + 1)).astype(np.float64),
    )


def drawn_layout(reach: float, seed: int) -> Layout:
    """Return zones and joints up to `reach` to both sides [m], drawn evenly from the text's ranges.

    The joints of a panel between two zones are stretched a little, so that they fill it.
    """
    generator = np.random.default_rng(seed)

    def stations(least: float, most: float) -> FloatArray:
        steps = generator.uniform(least, most, math.ceil(2 * reach / least))
        drawn: FloatArray = -reach + np.cumsum(steps) - generator.uniform(0, most)
        return drawn[drawn < reach]

    zones = stations(*ZONES_APART)
    widths = generator.uniform(*ZONE_WIDTH, len(zones))
    joints = []
    for low, high in zip(zones[:-1] + widths[:-1] / 2, zones[1:] - widths[1:] / 2, strict=True):
        parts = max(1, round((high - low) / float(np.mean(JOINTS_APART))))
        ends = np.cumsum(generator.uniform(*JOINTS_APART, parts))
        joints.append(low + (high - low) * ends[:-1] / ends[-1])
    cross_joints = stations(*JOINTS_APART)
    return Layout(zones=zones, widths=widths, joints=np.concatenate(joints), cross_joints=cross_joints)


def _mesh(
    path: str | os.PathLike[str], width: float, below: float, dip: float, cross_dip: float, layout: Layout
) -> Path:
    """Write the mesh of a layout, as `build` says."""
    import shapely

    from bsm_mesh.geometries.cutting.cut import cut_blocks
    from bsm_mesh.geometries.joint_sets import Fault
    from bsm_mesh.geometries.quarters import quarter_blocks
    from bsm_mesh.geometries.rock_mass import Excavation, Region, RockMass
    from bsm_mesh.geometries.shapes import band, rectangle
    from bsm_mesh.geometries.short_sides import close_short_sides

    reach = width + below + COVER

    def line(angle: float, through: tuple[float, float], offset: float) -> list[tuple[float, float]]:
        """Return a line at an angle [degrees], at a distance from a point, to the right of its direction [m]."""
        along = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        x, y = through[0] + offset * along[1], through[1] - offset * along[0]
        return [(x + side * reach * along[0], y + side * reach * along[1]) for side in (-1, 1)]

    frame = rectangle(-width / 2, -below, width / 2, COVER)
    bands = [(line(dip, FOOT, zone), wide) for zone, wide in zip(layout.zones, layout.widths, strict=True)]
    joints = [line(dip, FOOT, offset) for offset in layout.joints]
    cross_joints = [line(cross_dip, CORNER, -offset) for offset in layout.cross_joints]
    mass = RockMass(
        regions=[
            Region(outline=frame, rock="rock"),
            *(
                Region(outline=band(middle, wide), rock="shear_zone", border="SZ", clipped=True)
                for middle, wide in bands
                if _crosses(middle, wide, frame)
            ),
            Excavation(outline=rectangle(*OPENING), name="1"),
        ],
        joints=[
            Fault(name=name, lines=[each for each in lines if _crosses(each, 0.0, frame)])
            for name, lines in (("J2", cross_joints), ("J1", joints))
        ],
    )
    outlines = shapely.MultiPolygon([shapely.Polygon(frame), shapely.Polygon(rectangle(*OPENING))])
    return quarter_blocks(close_short_sides(cut_blocks(mass), SHORTEST, outlines), path)


def _crosses(line: list[tuple[float, float]], width: float, frame: object) -> bool:
    """Return whether a band around a line lies in the frame, more than a touching corner."""
    import shapely

    return bool(shapely.distance(shapely.LineString(line), shapely.Polygon(frame)) < width / 2 + 1e-9)
