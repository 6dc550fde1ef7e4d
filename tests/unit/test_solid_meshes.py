"""Meshes of volume elements: blocks of regions and elements, exact volumes, groups, the model file, what is refused."""

import json
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose

import bsm_mesh as bsm
from bsm_mesh.converters.three_d import read_polyhedra
from bsm_mesh.converters.three_d.elements import element_faces
from bsm_mesh.three_d.contacts.surfaces import Surfaces
from tests.scenes.faults import fault
from tests.scenes.rock_3d import wedge_factor
from tests.scenes.small_case import Case
from tests.scenes.solid_meshes import incline, layers, pocket, wedge

ROUNDING = 1e-9  # of coordinates that Gmsh's geometry kernel has computed
CUBE = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)], dtype=float)
MODEL = """
dimensions = 3
{mesh}
[rock.granite]
unit_weight = "26 kN/m^3"

[joint.J1]
normal_stiffness = "1 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 35
{cut}
[[support]]
boundary = "bottom"
fix = "all"

[[stage]]
name = "lid off"
excavate = ["lid"]

[[stage]]
name = "weaker"
strength = {{J1 = {strength}}}
"""
CUT = """
[[joint_plane]]
name = "J1"
dip = 30
dip_direction = 90
point = [1, 1, 1]

[[excavation]]
name = "lid"
polygon = [[-2, 2.5], [2, 2.5], [2, 3], [-2, 3]]
origin = [1, 1, 0]
"""
BOX = '[mesh]\nbox = [[0, 0, 0], [2, 2, 3]]\ndefault_joint = "J1"\n'
MESH = '[mesh]\nfile = "incline.msh"\ndefault_joint = "J1"\n'


@pytest.fixture(scope="module")
def mesh(tmp_path_factory):
    return incline(tmp_path_factory.mktemp("mesh") / "incline.msh")


@pytest.mark.parametrize("form", [{}, {"binary": True}, {"order": 2}])
def test_regions_between_joints_are_blocks(tmp_path, form):
    """Below the joint 4 m3, above it 6, the lid 2; the joint has 4 / cos 30 m2."""
    blocks = read_polyhedra(incline(tmp_path / "mesh.msh", **form))
    assert_allclose(sorted(blocks.moments.volume), [2, 4, 6], rtol=ROUNDING)
    polygons = blocks.contact_polygons
    assert_allclose(polygons.area[polygons.joint == 0].sum(), 4 / np.cos(np.radians(30)), rtol=ROUNDING)
    assert_allclose(polygons.area[polygons.joint < 0].sum(), 4, rtol=ROUNDING)  # under the lid
    assert_allclose(blocks.moments.volume[blocks.excavations["lid"]], 2, rtol=ROUNDING)
    (below,) = blocks.boundary_blocks("bottom")
    assert_allclose(blocks.moments.centroid[below, 2], (1 + 4 / 12 * np.tan(np.radians(30)) ** 2) / 2, rtol=ROUNDING)


@pytest.mark.parametrize("corners", [(0, 1, 2, 3, 4, 5, 6, 7), (4, 5, 6, 7, 0, 1, 2, 3)])
def test_faces_of_inverted_elements_look_outward(corners):
    loop = CUBE[element_faces("mesh", CUBE, [("hexahedron", np.array([corners]))]).loops]
    normal = np.cross(loop[:, 1] - loop[:, 0], loop[:, 2] - loop[:, 1])
    assert_allclose(((loop.mean(axis=1) - 0.5) * normal).sum(axis=1), 0.5)


def test_a_triangle_on_a_quadrilateral_does_not_conform():
    points = np.concatenate([CUBE, [(0.5, 0.5, 2)]])
    elements = [("hexahedron", np.arange(8)[None]), ("tetra", np.array([(4, 5, 6, 8)]))]
    with fault("mesh: 1 triangle of elements on a quadrilateral of another: the mesh does not conform"):
        element_faces("mesh", points, elements)


def test_elements_are_blocks(mesh):
    whole, regions = read_polyhedra(mesh, blocks="elements"), read_polyhedra(mesh)
    assert whole.count == len(whole.cell_block) > 20
    assert_allclose(whole.moments.volume.sum(), 12, rtol=ROUNDING)
    assert len(whole.face_cells) == len(regions.face_cells)


@pytest.mark.parametrize(("recombine", "count"), [(False, 4), (True, 2)])
def test_prisms_and_hexahedra(tmp_path, recombine, count):
    blocks = read_polyhedra(layers(tmp_path / "mesh.msh", recombine=recombine), blocks="elements", unit_scale=0.1)
    assert blocks.count == 2 * count
    assert_allclose(blocks.moments.volume, 1e-3 / count, rtol=ROUNDING)
    polygons = blocks.contact_polygons
    assert_allclose(polygons.area[polygons.joint == 0].sum(), 0.02, rtol=ROUNDING)
    rocks = np.array(blocks.rock_names)[blocks.rock]
    assert set(rocks[blocks.moments.centroid[:, 2] > 0.05]) == {"gneiss"}
    assert set(rocks[blocks.moments.centroid[:, 2] < 0.05]) == {"slate"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("friction", "verdict"), [(30.001, "stable"), pytest.param(29.999, "unstable", marks=pytest.mark.heavy)]
)
def test_the_block_on_the_joint_of_a_mesh_slides_below_the_friction_of_its_dip(tmp_path, mesh, friction, verdict):
    """To a thousandth of a degree: the strength of 35 degrees is reduced to the friction; the joint dips 30."""
    (tmp_path / "incline.msh").write_bytes(mesh.read_bytes())
    strength = np.tan(np.radians(friction)) / np.tan(np.radians(35))
    (tmp_path / "model.toml").write_text(MODEL.format(mesh=MESH, cut="", strength=strength))
    results = bsm.run(bsm.load(tmp_path / "model.toml"))
    assert [stage.status for stage in results.stages] == ["stable", "stable", verdict]


@pytest.mark.parametrize(("direction", "size", "slide"), [(90, 1.0, 0.06), (291, 0.76, 0.5), (35, 0.6, 0.2)])
def test_triangles_that_end_at_an_edge_have_no_contact_there(tmp_path, direction, size, slide):
    """The block has slid over the edge of its base. Triangles of the side below the edge touched it in a corner.

    A contact of theirs had the normal of two edges of the mesh; it held blocks that slide off.
    """
    mesh = incline(tmp_path / "mesh.msh", direction=direction, size=size)
    blocks = read_polyhedra(mesh, blocks="regions")
    (base,) = blocks.boundary_blocks("bottom")
    (upper,) = np.setdiff1d(np.arange(3), [base, *blocks.excavations["lid"]])
    down, east = np.radians([30, 90 - direction])
    across, position = np.array([np.cos(east), np.sin(east)]), np.zeros((3, 6))
    position[upper, :3] = slide * np.array([*across, -np.tan(down)])
    free = np.arange(3) == upper
    found = Surfaces(blocks=blocks, rule="both").polygons(position, free, ~free, band=0.05, narrow=5e-3)
    touch = found.some(((found.block_a == base) | (found.block_b == base)) & (found.found_gap < 5e-3))
    normal = np.array([*(np.sin(down) * across), np.cos(down)])
    assert_allclose(np.abs(touch.geometry[:, 6:9] @ normal), 1, rtol=ROUNDING)
    assert_allclose(touch.area.sum(), np.prod(2 - slide * np.abs(across)) / np.cos(down), rtol=1e-3)


def test_groups_by_other_names(tmp_path):
    path = incline(tmp_path / "mesh.msh", names={"rock:granite": "Body", "joint:J1": "Fault 1"})
    with fault("in no group of a rock (groups that are not used: Fault 1, Body); call the group rock:NAME, name it in"):
        read_polyhedra(path)
    blocks = read_polyhedra(path, groups={"Body": "rock:granite", "Fault 1": "joint:J1"})
    assert (blocks.rock_names, blocks.joint_names) == (("granite",), ("J1",))
    with pytest.warns(bsm.MeshWarning, match="not used: Fault 1, Body; to use one, name it kind:name"):
        assert read_polyhedra(path, rock="tuff").rock_names == ("tuff",)
    with fault("there is no group 'Bodi' of surfaces or volumes in the mesh"):
        read_polyhedra(path, groups={"Bodi": "rock:granite"})


@pytest.mark.parametrize(
    ("names", "match"),
    [
        ({"joint:J1": "rock:J1"}, "group 'rock:J1' holds surfaces; rock:NAME is for volumes"),
        ({"excavation:lid": "rock:tuff"}, "a volume is in rock:"),
        ({"boundary:bottom": "joint:base"}, "group 'joint:base': none of its"),
        ({"joint:J1": "boundary:J1"}, "surface elements lies on the outside"),
    ],
)
def test_groups_that_lead_nowhere(tmp_path, names, match):
    with fault(match):
        read_polyhedra(incline(tmp_path / "mesh.msh", names=names))


def test_bent_elements_and_other_files_are_refused(tmp_path):
    with fault("a hexahedron whose faces are not plane, or that is not convex; mesh this part with tetrahedra"):
        read_polyhedra(layers(tmp_path / "bent.msh", recombine=True, bent=0.1))
    with fault("volume elements are read from MSH 4.1 alone; convert it: gmsh old.msh -save -format msh41"):
        read_polyhedra(incline(tmp_path / "old.msh", version=2.2))
    with fault("there is no such file"):
        read_polyhedra(tmp_path / "none.msh")
    broken = tmp_path / "broken.msh"
    broken.write_bytes((tmp_path / "bent.msh").read_bytes()[:2000])
    with fault("is cut off or damaged"):
        read_polyhedra(broken)


def test_surfaces_that_are_not_embedded_are_refused(tmp_path, mesh):
    """Node 1 is moved out of a triangle's nodes by naming others: the surface is no face of an element."""
    text = layers(tmp_path / "mesh.msh", recombine=False).read_text()
    section = re.search(r"\$Elements\n(.*?)\$EndElements", text, re.DOTALL)[1].splitlines()
    row = next(k for k, line in enumerate(section) if line.startswith("2 ")) + 1
    tag, a, b, _ = section[row].split()
    other = next(n for n in range(1, 18) if str(n) not in (a, b) and n > 12)
    (tmp_path / "cut.msh").write_text(text.replace(section[row], f"{tag} {a} {b} {other}"))
    with fault("no face of a volume element; embed the surface in the volumes, by fragment in Gmsh"):
        read_polyhedra(tmp_path / "cut.msh")


@pytest.mark.parametrize(
    ("given", "cut", "match"),
    [
        ("[mesh]\n", "", "[mesh] needs one of the keys 'box', 'file' and 'geometry'; given: none"),
        (MESH + "box = [[0, 0, 0], [2, 2, 3]]\n", "", "given: box, file"),
        (MESH, CUT, "[[joint_plane]] cuts a box, and [mesh] has a file"),
        (BOX + 'unit = "mm"\n', CUT, "[mesh] unit is for a mesh, and [mesh] has a box"),
        (MESH + 'unit = "bar"\n', "", '[mesh] unit = "bar"'),
        (MESH + '[groups]\n"joint:J1" = "joint:J2"\n', "", "joint:J2 of the mesh: there is no [joint.J2]"),
        (MESH.replace("default_joint", "#") + '[groups]\n"joint:J1" = "x"\n', "", "the mesh has no group joint:J1"),
    ],
)
def test_model_files_that_do_not_fit_the_mesh(case: Case, mesh, given, cut, match):
    case.write("incline.msh", mesh.read_text())
    case.write("model.toml", MODEL.format(mesh=given, cut=cut, strength=1.0))
    outcome = case.run("run", "model.toml")
    assert outcome.code == 2
    assert match in " ".join(outcome.err.split())


def test_a_joint_by_another_name_is_not_left_out_in_silence(case: Case):
    """A file without tables of joints is valid; the blocks on both sides of the joint are one, which is stable."""
    incline("incline.msh", names={"joint:J1": "Fault 1"})
    given = MESH.replace('default_joint = "J1"', 'blocks = "regions"')
    text = MODEL.format(mesh=given, cut="", strength=1.0).replace(
        "[joint.J1]", "young = 1e10\npoisson = 0.2\n[joint.J1]"
    )
    case.write(
        "model.toml", text[: text.index("[joint.J1]")] + text[text.index("[[support]]") : text.index("[[stage]]")]
    )
    outcome = case.run("check", "model.toml", "-q")
    assert outcome.code == 0
    assert "groups that are not used: Fault 1; to use one, " in outcome.err
    assert '"Fault 1" = "joint:Fault 1" or "boundary:Fault 1"' in outcome.err


def test_a_file_without_blocks_is_answered_with_the_default(case: Case, mesh):
    """4 blocks or hundreds: check and run say which, where the file does not."""
    case.write("incline.msh", mesh.read_text())
    said = {}
    for name, given in {"left out": MESH, "regions": MESH + 'blocks = "regions"\n'}.items():
        case.write("model.toml", MODEL.format(mesh=given, cut="", strength=1.0))
        said[name] = case.run("check", "model.toml").out
    note = re.search(
        r"note: (\d) blocks of (\d+) elements: by default every region between joints is", said["left out"]
    )
    assert note is not None
    assert int(note[1]) == read_polyhedra(mesh).count
    assert int(note[2]) == read_polyhedra(mesh, blocks="elements").count
    assert "by default" not in said["regions"]


WEDGE = """
dimensions = 3
[mesh]
file = "wedge.msh"

[rock.granite]
unit_weight = "26 kN/m^3"

[joint.A]
normal_stiffness = "1 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 40

[joint.B]
normal_stiffness = "1 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 50

[key_blocks]
required = 1.5
free = ["face", "top"]
"""


def test_key_blocks_of_a_mesh(case: Case):
    """A tetrahedron of 1.125 m3: (tan 40 + tan 50) / 2 times 1.2247 by Hoek & Bray; its neighbours reach the sides."""
    wedge(case.folder / "wedge.msh")
    case.write("model.toml", WEDGE)
    outcome = case.run("key-blocks", "model.toml", "--json", "--no-picture")
    assert outcome.code == 0, outcome.err
    told = json.loads(outcome.out)
    assert (told["blocks"], told["removable"]) == (4, 1)
    assert_allclose(told["volume"], 1.125, rtol=ROUNDING)
    (factor,) = told["slides"].values()
    dip = np.degrees(np.arccos(1 / np.sqrt(3)))
    assert_allclose(
        factor, wedge_factor((dip, 135), (dip, 225), 1.125, (0, 0), 26e3, (40, 50), (0, 0)), rtol=1e-6
    )  # six digits are printed


def test_an_excavation_of_space_that_no_stage_takes_is_told(case: Case):
    text = MODEL.format(mesh=BOX, cut=CUT, strength=1.0)
    case.write("model.toml", text[: text.index("[[stage]]")])
    outcome = case.run("check", "model.toml", "-q")
    assert outcome.code == 0
    assert "note: excavation 'lid' (1 block) is left in place: no stage excavates it" in outcome.out


def test_a_joint_of_a_mesh_that_bounds_no_two_blocks_is_refused(case: Case):
    """A square inside the rock is in the group of the joint, and the rock is one block around it."""
    pocket("incline.msh")
    text = MODEL.format(mesh='[mesh]\nfile = "incline.msh"\nblocks = "regions"', cut="", strength=1.0)
    case.write("model.toml", text[: text.index("[[stage]]")])
    outcome = case.run("check", "model.toml", "-q")
    assert outcome.code == 2
    assert "joint:J1 of the mesh bounds no two blocks; extend its surfaces to other joints or to the" in outcome.err
