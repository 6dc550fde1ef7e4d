"""A wedge of rock on a bedding plane, a tension crack behind it (the slope of Hoek and Bray's plane failure)."""

from bsm_mesh.geometries.quadrilaterals import write_quadrilaterals

TOE, CRACK, TOP, CREST = (0.0, 0.0), (10.928, 7.652), (10.928, 12.0), (6.928, 12.0)


def build(path):
    """Write the wedge (block 0), the rock under it (1) and the rock behind it (2)."""
    under = ((0.0, -8.0), (10.928, -8.0), CRACK, TOE)
    behind = ((10.928, -8.0), (25.0, -8.0), (25.0, 12.0), TOP)
    return write_quadrilaterals(
        path,
        [(TOE, CRACK, TOP, CREST), under, behind],
        ["rock"],
        joints={"bedding": [(0, 0)], "crack": [(0, 1), (1, 1)]},
        name="slope",
    )
