"""Dupont Circle Station, first stage of excavation: the case history of Wang section 8.2, a reconstruction.

The middle of the crown is the origin, the top of rock y = 9 m. Sizes of the opening and the ranges of joint and
shear-zone spacings are the text's; where the joints lie stands in Figs. 8.2 and 8.3 only, and is assumed here.
"""

from __future__ import annotations

import math
import os
from pathlib import Path

from bsm_mesh.geometries.parameters import ParameterChecks

OPENING = (-3.0, -8.0, 3.0, 0.0)  # 6 m x 8 m: left, bottom, right, top
COVER = 9.0  # m of rock over the crown
CORNER, FOOT = (3.0, 0.0), (3.0, -8.0)  # of the right wall
SHORTEST = 0.5  # m: shorter sides are closed, so that no sliver is left where joints meet the outlines


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
    **unknown
        Refused, with the nearest parameter that there is.

    Returns
    -------
    Path
        The file.

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
    checks.raise_faults()
    if zone_width >= zone_spacing:
        checks.add(f"zone_width = {zone_width:g} m leaves no rock between zones {zone_spacing:g} m apart; give less")
    if width <= OPENING[2] - OPENING[0] or below <= -OPENING[1]:
        checks.add(f"the model, {width:g} m wide and {below:g} m below the crown, must be larger than the opening")
    checks.raise_faults()
    import shapely

    from bsm_mesh.geometries.cutting.cut import cut_blocks
    from bsm_mesh.geometries.joint_sets import Fault, JointSet
    from bsm_mesh.geometries.quarters import quarter_blocks
    from bsm_mesh.geometries.rock_mass import Excavation, Region, RockMass
    from bsm_mesh.geometries.shapes import band, rectangle
    from bsm_mesh.geometries.short_sides import close_short_sides

    along = math.cos(math.radians(dip)), math.sin(math.radians(dip))
    reach = width + below + COVER

    def line(offset: float) -> list[tuple[float, float]]:
        """Return a line parallel to the zones, at a distance from the first one."""
        x, y = FOOT[0] + offset * along[1], FOOT[1] - offset * along[0]
        return [(x + side * reach * along[0], y + side * reach * along[1]) for side in (-1, 1)]

    number = math.ceil(reach / zone_spacing) + 1
    zones = [zone_offset + k * zone_spacing for k in range(-number, number + 1)]
    clear = zone_spacing - zone_width
    parts = max(1, round(clear / joint_spacing))
    joints = [z + zone_width / 2 + k * clear / parts for z in zones for k in range(1, parts)]
    frame = rectangle(-width / 2, -below, width / 2, COVER)
    mass = RockMass(
        regions=[
            Region(outline=frame, rock="rock"),
            *(
                Region(outline=band(line(z), zone_width), rock="shear_zone", border="SZ", clipped=True)
                for z in zones
                if _crosses(line(z), zone_width, frame)
            ),
            Excavation(outline=rectangle(*OPENING), name="1"),
        ],
        joints=[
            JointSet(name="J2", dip=cross_dip, spacing=cross_spacing, start=CORNER),
            Fault(name="J1", lines=[line(offset) for offset in joints if _crosses(line(offset), 0.0, frame)]),
        ],
    )
    outlines = shapely.MultiPolygon([shapely.Polygon(frame), shapely.Polygon(rectangle(*OPENING))])
    return quarter_blocks(close_short_sides(cut_blocks(mass), SHORTEST, outlines), path)


def _crosses(line: list[tuple[float, float]], width: float, frame: object) -> bool:
    """Return whether a band around a line lies in the frame, more than a touching corner."""
    import shapely

    return bool(shapely.distance(shapely.LineString(line), shapely.Polygon(frame)) < width / 2 + 1e-9)
