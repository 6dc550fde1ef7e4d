"""The hanging wall slope of the Cassiar open pit: the case history of Wang (section 8.3).

The text gives the height, the two rocks, the dyke, two faults, contact and five joints by name, and that a wedge above
the fault and to the right of the dyke moves; where they lie is in Figs. 8.15 and 8.16 only. The section here
is a reconstruction. The toe of the slope is the origin; the slope rises to the left.

The dyke is the back of the wedge, the North Fault its steep base, Fault A1 its flat one, which daylights in the face.
Joints B to E divide the wedge into five layers, joint F runs through the rock below it. Rock between two of these is
one block.
"""

from __future__ import annotations

import math
import os
from itertools import pairwise
from pathlib import Path
from typing import Any

from bsm_mesh.geometries.parameters import ParameterChecks

WEDGE_JOINTS = "BCDE"


def monitoring_points(
    *, height: float = 330.0, slope_angle: float = 40.0, fault_level: float = 120.0, joint_f_level: float = 30.0
) -> list[tuple[float, float]]:
    """Return the points 1 to 7 on the face at which the displacements are compared, from the crest down [m].

    Point 1 is the crest; 2 to 5 lie in the middle of the layers of the wedge below it, so that 5 is the lowest of the
    wedge; 6 and 7 at the thirds of the face between Fault A1 and joint F.
    """
    layer = (height - fault_level) / (len(WEDGE_JOINTS) + 1)
    below = (fault_level - joint_f_level) / 3
    levels = [height, *(height - (k + 0.5) * layer for k in range(1, 5)), fault_level - below, fault_level - 2 * below]
    return [(-level / _tan(slope_angle), level) for level in levels]


def build(
    path: str | os.PathLike[str],
    *,
    height: float = 330.0,
    slope_angle: float = 40.0,
    dyke_setback: float = 20.0,
    dyke_dip: float = 75.0,
    dyke_width: float = 15.0,
    fault_level: float = 120.0,
    fault_a1_dip: float = 10.0,
    fault_a1_length: float = 100.0,
    north_fault_dip: float = 25.0,
    joint_dip: float = 20.0,
    joint_f_level: float = 30.0,
    joint_f_dip: float = 10.0,
    contact_level: float = 10.0,
    contact_dip: float = 60.0,
    behind: float = 250.0,
    ahead: float = 200.0,
    below: float = 150.0,
    size: float | None = None,
    **unknown: object,
) -> Path:
    """Write the mesh of the Cassiar slope and return its path.

    Surfaces ``rock:argillite`` and ``rock:serpentinite``; curves ``joint:dyke`` (both walls), ``joint:north_fault``,
    ``joint:fault_a1``, ``joint:contact``, ``joint:B`` to ``joint:F``, ``boundary:left``, ``right``, ``bottom`` and
    ``ground``. To be read with ``blocks = "regions"``.

    Parameters
    ----------
    path : str or path-like
        The file to write, ``.msh``.
    height : float
        Height of the slope [m].
    slope_angle : float
        Overall angle of the face [degrees].
    dyke_setback : float
        From the crest to the dyke's outcrop [m].
    dyke_dip : float
        Dip of the dyke towards the pit [degrees].
    dyke_width : float
        Width across the dyke [m].
    fault_level : float
        Height over the toe at which Fault A1 daylights [m].
    fault_a1_dip : float
        Dip of Fault A1 towards the pit [degrees].
    fault_a1_length : float
        Level distance from the face to where Fault A1 meets the North Fault [m].
    north_fault_dip : float
        Dip of the North Fault towards the pit, from the dyke down to Fault A1 [degrees].
    joint_dip : float
        Dip of joints B to E towards the pit [degrees]; they leave the face at equal intervals of height.
    joint_f_level : float
        Height at which joint F daylights below the fault [m].
    joint_f_dip : float
        Its dip towards the pit [degrees].
    contact_level : float
        Height at which the contact of argillite over serpentinite leaves the face [m].
    contact_dip : float
        Its dip into the slope [degrees].
    behind : float
        From the crest to the left boundary [m].
    ahead : float
        From the toe to the right boundary [m].
    below : float
        From the pit floor to the bottom [m].
    size : float, optional
        Size of the elements [m]; where not given, few elements a block.
    **unknown
        Refused, with the nearest parameter that there is.

    Raises
    ------
    GeometryError
        With all faults of the parameters.
    """
    given = {name: value for name, value in locals().items() if name not in ("path", "unknown")}
    section = _Section(_checked(given, unknown))
    from bsm_mesh.geometries.block_files import mesh_blocks, write_blocks
    from bsm_mesh.geometries.cutting.cut import cut_blocks

    cut = cut_blocks(section.rock_mass())
    return write_blocks(cut, path) if size is None else mesh_blocks(cut, path, size=size)


def _checked(given: dict[str, Any], unknown: dict[str, object]) -> dict[str, Any]:
    """Return the parameters, or raise all their faults."""
    checks = ParameterChecks(build, unknown)
    lengths = (
        "height dyke_setback dyke_width fault_level fault_a1_length joint_f_level contact_level behind ahead below"
    )
    good = checks.positive(**{name: given[name] for name in lengths.split()})
    checks.positive_or_none(size=given["size"])
    good &= checks.within(10.0, 80.0, "degrees", slope_angle=given["slope_angle"])
    good &= checks.within(45.0, 90.0, "degrees", dyke_dip=given["dyke_dip"])
    good &= checks.within(10.0, 90.0, "degrees", contact_dip=given["contact_dip"])
    dips = "fault_a1_dip north_fault_dip joint_dip joint_f_dip"
    good &= checks.within(0.0, given["slope_angle"], "degrees (the slope's)", **{n: given[n] for n in dips.split()})
    if good:
        for fault in _Section(given).faults():
            checks.add(fault)
    checks.raise_faults()
    return given


class _Section:
    """Where the lines of the section run, from the parameters of `build`."""

    def __init__(self, given: dict[str, Any]) -> None:
        self.given = given
        self.height, self.bottom = given["height"], -given["below"]
        self.crest = self.face(self.height)
        self.left, self.right = self.crest[0] - given["behind"], given["ahead"]
        self.outcrop = self.crest[0] - given["dyke_setback"]
        self.daylight = self.face(given["fault_level"])
        length = given["fault_a1_length"]
        self.bend = (self.daylight[0] - length, self.daylight[1] + length * _tan(given["fault_a1_dip"]))
        self.back = self.at_dyke(self.bend, given["north_fault_dip"])
        self.joint_f = self.face(given["joint_f_level"])
        self.joint_f_back = self.at_dyke(self.joint_f, given["joint_f_dip"])
        contact = self.face(given["contact_level"])
        run = (contact[1] - self.bottom) / _tan(given["contact_dip"])
        self.contact = ((contact[0] - run, self.bottom), contact)

    def face(self, level: float) -> tuple[float, float]:
        """Return the point of the face at a level."""
        return -level / _tan(self.given["slope_angle"]), level

    def dyke_at(self, level: float) -> float:
        """Return where the dyke's wall on the pit side is at a level."""
        return float(self.outcrop + (self.height - level) / _tan(self.given["dyke_dip"]))

    def at_dyke(self, start: tuple[float, float], dip: float) -> tuple[float, float]:
        """Return where the line that rises from `start` to the left meets the dyke."""
        rise, lean = _tan(dip), 1 / _tan(self.given["dyke_dip"])
        level = (start[1] + rise * (start[0] - self.outcrop - self.height * lean)) / (1 - rise * lean)
        return self.dyke_at(level), level

    def faults(self) -> list[str]:
        """Return what does not fit together."""
        given, levels = self.given, ("contact_level", "joint_f_level", "fault_level", "height")
        found = []
        for low, high in pairwise(levels):
            if given[low] >= given[high]:
                found.append(f"{low} = {given[low]:g} m must be below {high} = {given[high]:g} m")
        if found:
            return found
        if self.bend[0] <= self.dyke_at(self.bend[1]):
            found.append(f"fault_a1_length = {given['fault_a1_length']:g} m reaches the dyke; give less")
        elif not self.joint_f_back[1] < self.back[1] < self.height:
            found.append(
                f"the North Fault meets the dyke at the level {self.back[1]:.4g} m, which must lie between joint F "
                f"({self.joint_f_back[1]:.4g} m) and the crest; change the dips"
            )
        if self.contact[0][0] <= self.dyke_at(self.bottom):
            found.append(f"contact_dip = {given['contact_dip']:g} degrees: the contact reaches the dyke; give more")
        if self.outcrop - given["dyke_width"] / math.sin(math.radians(given["dyke_dip"])) <= self.left:
            found.append(f"behind = {given['behind']:g} m does not reach beyond the dyke; give more")
        return found

    def rock_mass(self) -> Any:
        """Return the rock and its joints, ready to be cut."""
        from bsm_mesh.geometries.joint_sets import Fault
        from bsm_mesh.geometries.rock_mass import Region, RockMass

        low, high = self.bottom, self.height
        ground = [(self.left, high), self.crest, (0.0, 0.0), (self.right, 0.0)]
        ore = [*self.contact, (0.0, 0.0), (self.right, 0.0), (self.right, low)]
        return RockMass(
            regions=[
                Region(outline=[*ground, (self.right, low), (self.left, low)], rock="argillite"),
                Region(outline=ore, rock="serpentinite"),
                Region(outline=self.dyke(), rock="serpentinite", border="dyke", clipped=True),
            ],
            joints=[
                Fault(name="contact", lines=[self.contact]),
                Fault(name="north_fault", lines=[[self.back, self.bend]]),
                Fault(name="fault_a1", lines=[[self.bend, self.daylight]]),
                *self.wedge_joints(),
                Fault(name="F", lines=[[self.joint_f_back, self.joint_f]]),
            ],
            boundaries={"ground": ground},
        )

    def dyke(self) -> list[tuple[float, float]]:
        """Return the dyke's outline, drawn on beyond the frame."""
        over, under = self.height + self.given["dyke_width"], self.bottom - self.given["dyke_width"]
        width = self.given["dyke_width"] / math.sin(math.radians(self.given["dyke_dip"]))
        wall = [(self.dyke_at(level), level) for level in (over, under)]
        return [*wall, *((x - width, level) for x, level in reversed(wall))]

    def wedge_joints(self) -> list[Any]:
        """Return joints B to E, from the face to the dyke or the North Fault."""
        import numpy as np

        from bsm_mesh.geometries.joint_sets import Fault, clip_traces

        wedge = [self.daylight, self.crest, (self.outcrop, self.height), self.back, self.bend]
        layer = (self.height - self.given["fault_level"]) / (len(WEDGE_JOINTS) + 1)
        rise = -self.outcrop * np.array([-1.0, _tan(self.given["joint_dip"])])  # more than the dyke
        found = []
        for number, name in enumerate(WEDGE_JOINTS, start=1):
            start = np.array(self.face(self.height - number * layer))
            found.append(Fault(name=name, lines=list(clip_traces(np.array([[start, start + rise]]), wedge))))
        return found


def _tan(degrees: float) -> float:
    return math.tan(math.radians(degrees))
