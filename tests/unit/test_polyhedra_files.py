"""Blocks of three dimensions in a VTU file: written and read back, of other programs, and in the model as run."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import bsm_mesh as bsm
from bsm_mesh.certificate import verify_certificate
from bsm_mesh.converters.meshes.block_files import write_polygons
from bsm_mesh.converters.three_d import read_polyhedra_file, write_polyhedra
from bsm_mesh.converters.vtk_files import Faces, Grid, write_vtu
from bsm_mesh.converters.vtk_library import POLYHEDRON
from tests.scenes.faults import fault
from tests.scenes.polyhedra import BOX_FACES, box, model_in_space
from tests.unit.test_space_run import SLOPE

ARRAYS = ("face_joint", "cell_block", "rock", "rock_names", "joint_names")
GALLERY = "[[-0.4, 2], [0.4, 2], [0.4, 2.4], [-0.4, 2.4]]"


@pytest.fixture(scope="module")
def rock(tmp_path_factory):
    """Return a model of blocks of several cells round a gallery to come, which is a block too."""
    path = tmp_path_factory.mktemp("rock") / "model.toml"
    path.write_text(SLOPE.replace("[[-2, 2.5], [2, 2.5], [2, 3], [-2, 3]]", GALLERY), encoding="utf-8")
    return bsm.load(path)


def test_blocks_are_read_as_they_were_written(rock, tmp_path):
    blocks = rock.blocks
    assert len(blocks.cell_block) > blocks.count
    again = read_polyhedra_file(write_polyhedra(blocks, tmp_path / "mesh.vtu"))
    for name in ARRAYS[1:]:
        assert_array_equal(getattr(again, name), getattr(blocks, name), err_msg=name)
    assert_allclose(again.moments.volume, blocks.moments.volume, rtol=1e-12)
    assert_allclose(again.moments.centroid, blocks.moments.centroid, atol=1e-12)
    for name, ids in blocks.excavations.items():
        assert_array_equal(again.excavations[name], ids)
    for name, faces in blocks.boundaries.items():
        assert_allclose(again.areas[again.boundaries[name]].sum(), blocks.areas[faces].sum(), rtol=1e-12)
    for joint in range(len(blocks.joint_names)):
        assert_allclose(
            again.areas[again.face_joint == joint].sum(), blocks.areas[blocks.face_joint == joint].sum(), rtol=1e-12
        )


def cubes(path, *, inside_out=False, cell_type=POLYHEDRON):
    """Write two cubes on each other without arrays, as another program would, in mm; return the path."""
    points = np.concatenate([box((0, 0, z), (1, 1, z + 1))[0] for z in (0, 1)]) * 1e3
    loops = [[8 * cube + corner for corner in face] for cube in range(2) for face in BOX_FACES]
    loops = [loop[::-1] for loop in loops] if inside_out else loops
    faces = Faces(cell_offsets=np.array([0, 6, 12]), offsets=4 * np.arange(13), connectivity=np.concatenate(loops))
    grid = Grid(
        points=points, offsets=np.array([0, 8, 16]), connectivity=np.arange(16), cell_type=cell_type, faces=faces
    )
    write_vtu(path, grid)
    return path


@pytest.mark.parametrize("inside_out", [False, True])
@pytest.mark.parametrize(("whole", "count"), [("elements", 2), ("regions", 1)])
def test_polyhedra_of_other_programs_are_blocks(tmp_path, inside_out, whole, count):
    file = cubes(tmp_path / "cubes.vtu", inside_out=inside_out)
    blocks = read_polyhedra_file(file, rock="granite", blocks=whole, unit_scale=1e-3)
    assert blocks.count == count
    assert_allclose(blocks.moments.volume, 2 / count)
    assert blocks.rock_names == ("granite",)
    assert len(blocks.face_cells) == 11  # the face between them is one


def test_what_is_no_mesh_of_polyhedra_is_refused(tmp_path):
    with fault("2 cells without a rock; give one rock for them all"):
        read_polyhedra_file(cubes(tmp_path / "cubes.vtu"))
    squares = bsm.Blocks.from_polygons([[(0, 0), (1, 0), (1, 1), (0, 1)]], rock="granite")
    with fault("blocks are read from VTU with polyhedra alone (VTK's cell type 42), and this has the types 7"):
        read_polyhedra_file(write_polygons(squares, tmp_path / "squares.vtu"), rock="granite")
    with fault("there is no such file"):
        read_polyhedra_file(tmp_path / "none.vtu")


def test_a_model_file_reads_polyhedra(tmp_path):
    cubes(tmp_path / "cubes.vtu")
    mesh = '[mesh]\nfile = "cubes.vtu"\nunit = "mm"\nblocks = "elements"\ndefault_joint = "J1"\n'
    text = SLOPE[: SLOPE.index("[mesh]")] + mesh + SLOPE[SLOPE.index("[rock.") : SLOPE.index("[[joint_plane]]")]
    path = tmp_path / "model.toml"
    path.write_text(f'{text}[[support]]\nblocks = [0]\nfix = "all"\n', encoding="utf-8")
    results = bsm.run(path, output=False)
    assert results.status == "stable"
    assert_allclose(results.stages[0].displacement[1, 2], -26e3 / 1e9, rtol=1e-6)  # a weight of 26 kN on 1 GPa/m
    path.write_text(f'{text}[groups]\nb = "joint:J1"\n', encoding="utf-8")
    with fault("[groups] are of MSH files"):
        bsm.load(path)


@pytest.mark.heavy
def test_a_model_of_python_is_saved_and_run_again(tmp_path):
    """Every part of a model in space has its form in the file; the certificate is compared with both files."""
    solids = [box((0, 0, -1), (2, 1, 0)), box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 1))]
    plane = bsm.HeadPlane(point=(0, 0, 0.5), dip=5, dip_direction=90)
    blocks = model_in_space(solids).blocks.with_boundary("west", lambda x, y, z: (x < 1e-9) & (z > -1e-9))
    model = model_in_space(solids).replace(
        blocks=blocks,
        loads=[
            bsm.PointLoad(block=1, point=(0.5, 0.5, 1.0), force=(0, 0, -1e3)),
            bsm.Traction(boundary="west", traction=(0, 0, (-1e3, 0, 100, 0))),
            bsm.InSituTraction(boundary="west"),
        ],
        bolts=[bsm.Bolt(start=(0.5, 0.5, 1), end=(0.5, 0.5, -0.9), diameter=0.025, bond_strength=2e5, stage="wet")],
        in_situ=bsm.InSitu(surface=1.0, k0=0.1, k0_across=0.2, trend=30.0),
        water=bsm.Water(joint_pressure={"J1": 1e3}),
        gravity_trend=20.0,
        stages=[bsm.Stage("wet", water=bsm.Water(plane=plane), gravity=(0.01, 0.0), gravity_trend=70.0)],
        histories=[bsm.History("top", point=(0.5, 0.5, 1.0)), bsm.History("all", joint="J1")],
        contact_points="both",
        title="In space",
    )
    results = bsm.run(model, bsm.Options(threads=1))
    folder = results.save(tmp_path / "out")
    assert bsm.load(folder / "model.toml").replace(options=None) == model
    again = bsm.run(folder / "model.toml", output=False)
    assert_allclose(again.stages[-1].displacement, results.stages[-1].displacement, atol=1e-12)
    assert verify_certificate.main(folder) == 0


def test_the_certificate_is_compared_with_the_mesh(tmp_path, capsys):
    solids = [box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (1, 1, 1))]
    folder = bsm.run(model_in_space(solids), bsm.Options(threads=1)).save(tmp_path / "out")
    assert verify_certificate.main(folder) == 0
    assert "as model.toml and mesh.vtu give them" in capsys.readouterr().out
    higher = model_in_space([solids[0], box((0, 0, 0), (1, 1, 1.1))]).blocks
    write_polyhedra(higher, folder / "mesh.vtu")
    assert verify_certificate.main(folder) == 1
    assert "block 1 has another volume than in mesh.vtu" in capsys.readouterr().out


def test_a_joint_without_a_face_is_allowed_where_the_file_says_so(tmp_path):
    model = model_in_space([box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (1, 1, 1))])
    more = bsm.Joint("J9", normal_stiffness=1e9, shear_stiffness=1e9, law=bsm.MohrCoulomb(friction=30))
    folder = bsm.run(model.replace(joints=[*model.joints, more]), bsm.Options(threads=1)).save(tmp_path / "out")
    text = (folder / "model.toml").read_text(encoding="utf-8")
    assert "allow_unused = true" in text
    assert [joint.name for joint in bsm.load(folder / "model.toml").joints] == ["J1", "J9"]
    (folder / "model.toml").write_text(text.replace("allow_unused = true\n", ""), encoding="utf-8")
    with fault("[joint.J9]: the mesh has no group joint:J9"):
        bsm.load(folder / "model.toml")
