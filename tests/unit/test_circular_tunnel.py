"""The mesh of a circular tunnel against closed forms of its area and outline (Wang section 3.4)."""

import itertools
import math

import meshio
import numpy as np
import pytest

from bsm_mesh.geometries import circular_tunnel
from bsm_mesh.geometries.errors import GeometryError

gmsh = pytest.importorskip("gmsh")

MIN_QUALITY = 0.3  # minSICN; 1 is an equilateral triangle or a square
ROUND_OFF = 1e-9
VARIANTS = [
    dict(mesh=mesh, half=half, outline=outline, core=core)
    for mesh, half, outline, core in itertools.product(
        ("triangles", "quads", "radial"), (True, False), ("rectangle", "circle"), (False, True)
    )
]
RADIUS, DEPTH, BELOW, WIDTH = 2.0, 11.0, 13.0, 15.0


@pytest.fixture(params=VARIANTS, ids=lambda variant: "-".join(str(value) for value in variant.values()))
def variant(request):
    return request.param


def build(path, **parameters):
    """Write a mesh with unequal distances to the boundaries, and read it back."""
    if parameters.get("outline") != "circle":
        parameters = {"below": BELOW, "width": WIDTH, **parameters}
    circular_tunnel.build(path, radius=RADIUS, depth=DEPTH, **parameters)
    return meshio.read(path)


def cells(mesh, group=None):
    """Return the corners of all polygons (or of a group's polygons or edges), one array a cell type."""
    chosen = mesh.cell_sets.get(group, [np.arange(len(block.data)) for block in mesh.cells])
    found = {}
    for block, rows in zip(mesh.cells, chosen, strict=True):  # meshio has a block for each curve and surface
        if len(rows) and block.type != "vertex" and (group or not block.type.startswith("line")):
            found.setdefault(block.type, []).append(block.data[rows])
    return {kind: np.concatenate(parts) for kind, parts in found.items()}


def signed_areas(points, polygons):
    x, y = points[polygons, 0], points[polygons, 1]
    return 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)


def edges_of(polygons):
    pairs = np.stack([polygons, np.roll(polygons, -1, axis=1)], axis=2).reshape(-1, 2)
    return np.sort(pairs, axis=1)


def polygon_area(mesh, group):
    """Return the area between a curve around the origin and the origin: of the polygon, not of the circle."""
    ends = mesh.points[cells(mesh, group)["line"]]
    return 0.5 * np.abs(ends[:, 0, 0] * ends[:, 1, 1] - ends[:, 0, 1] * ends[:, 1, 0]).sum()


def total_area(mesh, group):
    return sum(signed_areas(mesh.points, polygons).sum() for polygons in cells(mesh, group).values())


def quality(path):
    """Return how many elements there are, and the worst minSICN."""
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.open(str(path))
        tags = np.concatenate(gmsh.model.mesh.getElements(2)[1])
        return len(tags), float(gmsh.model.mesh.getElementQualities(tags, "minSICN").min())
    finally:
        gmsh.finalize()


def test_area_is_the_closed_form(variant, tmp_path):
    mesh = build(tmp_path / "tunnel.msh", **variant)
    if variant["outline"] == "circle":
        outline = polygon_area(mesh, "boundary:outer")
    else:
        outline = (1.0 if variant["half"] else 2.0) * WIDTH * (DEPTH + BELOW)
    tunnel = polygon_area(mesh, "boundary:wall")
    if variant["core"]:
        np.testing.assert_allclose(total_area(mesh, "excavation:tunnel"), tunnel, rtol=ROUND_OFF)
    expected = outline if variant["core"] else outline - tunnel
    np.testing.assert_allclose(total_area(mesh, "rock:rock"), expected, rtol=ROUND_OFF)
    circle = math.pi * RADIUS**2 * (0.5 if variant["half"] else 1.0)
    assert 0.97 * circle < tunnel < circle


def test_elements_are_counter_clockwise(variant, tmp_path):
    mesh = build(tmp_path / "tunnel.msh", **variant)
    for polygons in cells(mesh).values():
        assert signed_areas(mesh.points, polygons).min() > 0.0


def test_boundaries_cover_the_outline_once_and_there_are_no_gaps(variant, tmp_path):
    mesh = build(tmp_path / "tunnel.msh", **variant)
    all_edges = np.concatenate([edges_of(polygons) for polygons in cells(mesh).values()])
    edges, counts = np.unique(all_edges, axis=0, return_counts=True)
    assert counts.max() == 2
    free = {tuple(edge) for edge in edges[counts == 1]}
    groups = {name for name in mesh.cell_sets if name.startswith("boundary:")}
    if variant["core"]:
        wall = {tuple(edge) for edge in np.sort(cells(mesh, "boundary:wall")["line"], axis=1)}
        assert wall <= {tuple(edge) for edge in edges[counts == 2]}
        groups.discard("boundary:wall")
    named = [tuple(edge) for name in groups for edge in np.sort(cells(mesh, name)["line"], axis=1)]
    assert len(named) == len(set(named))
    assert set(named) == free


def test_boundaries_lie_where_their_names_say(tmp_path):
    mesh = build(tmp_path / "tunnel.msh")
    expected = {"left": (0, 0.0), "right": (0, WIDTH), "bottom": (1, -BELOW), "top": (1, DEPTH)}
    for name, (axis, value) in expected.items():
        nodes = np.unique(cells(mesh, f"boundary:{name}")["line"])
        np.testing.assert_array_equal(mesh.points[nodes, axis], value)
    wall = mesh.points[np.unique(cells(mesh, "boundary:wall")["line"])]
    np.testing.assert_allclose(np.hypot(wall[:, 0], wall[:, 1]), RADIUS, rtol=ROUND_OFF)


def test_quality_and_kind_of_elements(variant, tmp_path):
    mesh = build(tmp_path / "tunnel.msh", **variant)
    assert quality(tmp_path / "tunnel.msh")[1] > MIN_QUALITY
    kinds = {"triangles": {"triangle"}, "quads": {"quad"}, "radial": {"quad"}}[variant["mesh"]]
    if variant["core"] and variant["mesh"] == "radial":
        kinds = {"quad", "triangle"}
    assert set(cells(mesh)) == kinds


@pytest.mark.parametrize(("size", "count"), [(0.52, 576), (0.26, 2304), (0.13, 9216)])
def test_radial_counts(size, count, tmp_path):
    path = circular_tunnel.build(tmp_path / "tunnel.msh", mesh="radial", size=size)
    assert quality(path)[0] == count


# Regression: bsm-mesh 0.1.0 with Gmsh 4.15.2; another Gmsh may differ by some elements.
@pytest.mark.parametrize(
    ("mesh", "size", "count"),
    [
        ("triangles", 0.9, 1094), ("triangles", 0.45, 4015), ("triangles", 0.225, 15606),
        ("quads", 0.75, 968), ("quads", 0.34, 3989), pytest.param("quads", 0.17, 15646, marks=pytest.mark.heavy),
    ],
)  # fmt: skip
def test_documented_counts(mesh, size, count, tmp_path):
    path = circular_tunnel.build(tmp_path / "tunnel.msh", mesh=mesh, size=size)
    measured, worst = quality(path)
    assert measured == pytest.approx(count, rel=0.05)
    assert worst > 2 * MIN_QUALITY


@pytest.mark.parametrize("outline", ["rectangle", "circle"])
def test_kirsch_domain_of_twenty_radii(outline, tmp_path):
    path = circular_tunnel.build(
        tmp_path / "hole.msh", radius=1.0, depth=20.0, half=False, outline=outline, mesh="radial",
        size=1.2, size_at_wall=0.06,
    )  # fmt: skip
    count, worst = quality(path)
    assert count >= 4000
    assert worst > 2 * MIN_QUALITY


def test_second_order_puts_mid_nodes_on_the_circle(tmp_path):
    mesh = build(tmp_path / "tunnel.msh", order=2)
    assert set(cells(mesh)) >= {"triangle6"}
    wall = mesh.points[np.unique(cells(mesh, "boundary:wall")["line3"])]
    np.testing.assert_allclose(np.hypot(wall[:, 0], wall[:, 1]), RADIUS, rtol=ROUND_OFF)


def test_size_grows_from_the_wall(tmp_path):
    mesh = build(tmp_path / "tunnel.msh", size=1.0, size_at_wall=0.2)
    lengths = {
        name: np.linalg.norm(np.diff(mesh.points[cells(mesh, f"boundary:{name}")["line"]], axis=1), axis=2).mean()
        for name in ("wall", "right")
    }
    assert lengths == {"wall": pytest.approx(0.2, rel=0.05), "right": pytest.approx(1.0, rel=0.05)}


def test_the_same_parameters_give_the_same_file(variant, tmp_path):
    first = circular_tunnel.build(tmp_path / "first.msh", **variant).read_bytes()
    circular_tunnel.build(tmp_path / "between.msh", size=1.3)
    assert circular_tunnel.build(tmp_path / "second.msh", **variant).read_bytes() == first


def test_the_rock_has_the_name_given(tmp_path):
    assert "rock:gneiss" in build(tmp_path / "tunnel.msh", rock="gneiss").cell_sets


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        (dict(radius=-2.0), r"radius = -2.0 is not a positive number; give radius in m"),
        (dict(radius=math.nan), r"radius = nan is not a positive number"),
        (dict(size="0.5"), r"size = '0.5' is not a positive number"),
        (dict(radius=12.0, below=20.0, width=20.0), r"depth = 11.0 m does not exceed radius = 12.0 m"),
        (dict(width=1.0), r"width = 1.0 m does not exceed radius = 2.0 m"),
        (dict(mesh="quad"), r"mesh = 'quad' is not known; did you mean 'quads'\?; give one of 'triangles', "),
        (dict(outline="square"), r"outline = 'square' is not known"),
        (dict(order=3), r"order = 3 is not known; give one of 1, 2"),
        (dict(order=True), r"order = True is not known; give one of 1, 2"),
        (dict(half="yes"), r"half = 'yes' is not known; give one of True, False"),
        (dict(rock=" "), r"rock = ' ' cannot name a group"),
        (dict(raduis=3.0), r"there is no parameter 'raduis'; did you mean 'radius'\?"),
        (dict(size_at_wall=5.0), r"size_at_wall = 5.0 m exceeds the radius"),
        (dict(outline="circle", width=15.0), r"width means nothing with outline = 'circle'"),
        (dict(mesh="radial", grading_distance=3.0), r"grading_distance means nothing with mesh = 'radial'"),
        (dict(size=0.001), r"size = 0.001 m, at the wall 0.0005 m, would make about .* elements"),
    ],
)
def test_a_bad_parameter_is_named_with_value_rule_and_cure(parameters, message, tmp_path):
    with pytest.raises(GeometryError, match=f"circular_tunnel: {message}"):
        circular_tunnel.build(tmp_path / "tunnel.msh", **parameters)
    assert list(tmp_path.iterdir()) == []


def test_all_bad_parameters_are_reported_together(tmp_path):
    with pytest.raises(GeometryError) as caught:
        circular_tunnel.build(tmp_path / "tunnel.msh", radius=0.0, order=4, mesh="hex", colour="red")
    assert len(caught.value.faults) == 4
