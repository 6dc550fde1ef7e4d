"""--no-scripts: a model file runs no code, and neither reads nor writes outside its folder."""

from __future__ import annotations

from pathlib import Path

import pytest

import bsm_mesh as bsm
from bsm_mesh.errors import ModelError
from tests.scenes.small_case import FILE, LINEAR, MODEL, Case, tree
from tests.scenes.square_mesh import msh, msh22

SCRIPT = "from pathlib import Path\n\ndef build(path):\n    Path(__file__).with_name('was_run').touch()\n"
BOLTS = '[[bolt]]\ntable = "NAME"\ndiameter = "25 mm"\nyield_strength = "500 MPa"\n'
TABLE = "start_x,start_y,end_x,end_y\n0.1,1,0.9,1\n"


@pytest.fixture
def inside(case: Case) -> Case:
    """Return a model in a folder of its own, beside which there are a mesh and a table of bolts."""
    case.write("mesh.msh", msh())
    case.write("bolts.csv", TABLE)
    case.write("model/mesh.msh", msh())
    case.write("model/model.toml", MODEL + LINEAR)
    return case


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (FILE, 'file = "../mesh.msh"\n', '[mesh] file = "../mesh.msh" leads out of the folder of the model file'),
        (FILE, 'file = "/etc/hostname"\n', 'file = "/etc/hostname" leads out of the folder'),
        (FILE, 'file = "link.msh"\n', 'file = "link.msh" leads out of the folder'),
        (FILE, 'file = "linked/mesh.msh"\n', 'file = "linked/mesh.msh" leads out of the folder'),
        (FILE, 'file = "mesh.xdmf"\n', "a mesh of this format may name further files"),
        (FILE, 'file = "mesh.inp"\n', "a mesh of this format may name further files"),
        (FILE, 'geometry = "ours.py"\n', '[mesh] geometry = "ours.py" is a script, which is not run'),
        (FILE, 'geometry = "../ours"\n', '[mesh] geometry = "../ours" is a script, which is not run'),
        (LINEAR, LINEAR + BOLTS.replace("NAME", "../bolts.csv"), '[[bolt]] number 1: table = "../bolts.csv" leads out'),
        (LINEAR, LINEAR + BOLTS.replace("NAME", "link.csv"), '[[bolt]] number 1: table = "link.csv" leads out'),
        (LINEAR, LINEAR + '[output]\nfolder = "../out"\n', '[output] folder = "../out" leads out'),
        (LINEAR, LINEAR + '[output]\nfolder = "linked"\n', '[output] folder = "linked" leads out'),
        (LINEAR, LINEAR + '[output]\nfolder = "old"\n', "the link blocks_000.vtu in it leads elsewhere"),
    ],
)
@pytest.mark.parametrize("command", ["check", "run"])
def test_what_a_model_file_may_not_do(inside: Case, command: str, old: str, new: str, says: str) -> None:
    folder = inside.folder / "model"
    (folder / "link.msh").symlink_to("../mesh.msh")
    (folder / "link.csv").symlink_to("../bolts.csv")
    (folder / "linked").symlink_to("..")
    (folder / "old").mkdir()
    (folder / "old" / "blocks_000.vtu").symlink_to("../../mesh.msh")
    inside.write("model/ours.py", SCRIPT)
    inside.write("model/mesh.inp", "*include, INPUT=/etc/hostname\n")
    inside.write("model/mesh.xdmf", "<Xdmf/>")
    inside.write("model/model.toml", (MODEL + LINEAR).replace(old, new))
    err = inside.refuses(command, "model/model.toml", "--no-scripts", says=[says])
    assert "leave out --no-scripts" in err


@pytest.mark.parametrize("command", ["check", "run", "compare", "limit"])
def test_every_command_of_a_model_file_has_it(inside: Case, command: str) -> None:
    inside.write("model/model.toml", MODEL.replace(FILE, 'geometry = "ours.py"\n'))
    inside.write("model/ours.py", SCRIPT)
    inside.refuses(command, "model/model.toml", "--no-scripts", says=["is a script, which is not run"])


def test_a_harmless_model_runs(inside: Case) -> None:
    before = tree(inside.folder)
    outcome = inside.run("run", "model/model.toml", "--no-scripts", "-q")
    assert outcome.code == 0, outcome
    assert all(name.startswith("model/out") for name in outcome.new)
    assert before.items() <= tree(inside.folder).items()


def test_a_folder_reached_by_a_link_is_the_models_own(inside: Case) -> None:
    (inside.folder / "by_link").symlink_to("model")
    assert inside.run("check", "by_link/model.toml", "--no-scripts").code == 0


def test_built_in_geometries_are_ours(inside: Case) -> None:
    inside.write("model/model.toml", MODEL.replace(FILE, 'geometry = "no-such"\n'))
    inside.refuses("check", "model/model.toml", "--no-scripts", says=["there is no case 'no-such'"])
    inside.write("model/pushed_block.py", "raise SystemExit('a stranger was run')")
    inside.write("model/model.toml", MODEL.replace(FILE, 'geometry = "pushed_block"\n'))
    inside.refuses("check", "model/model.toml", "--no-scripts", says=["rock"])


def test_abaqus_files_that_name_no_others_are_read(inside: Case) -> None:
    from bsm_mesh.modelfile.reach import Reach

    inside.write("model/mesh.inp", "*NODE\n1, 0, 0\n")
    inside.write("model/mesh22.msh", msh22())
    reach = Reach(folder=inside.folder / "model", scripts=False)
    assert reach.mesh("mesh.inp").name == "mesh.inp"
    assert reach.mesh("mesh22.msh").name == "mesh22.msh"


def test_from_python(inside: Case) -> None:
    path = inside.folder / "model" / "model.toml"
    inside.write("model/ours.py", SCRIPT)
    inside.write("model/model.toml", MODEL.replace(FILE, 'geometry = "ours.py"\n'))
    with pytest.raises(ModelError, match="scripts=False"):
        bsm.load(path, scripts=False)
    with pytest.raises(ModelError, match="is a script, which is not run"):
        bsm.run(path, scripts=False)
    assert not (path.parent / "was_run").exists()
    with pytest.raises(ModelError, match="build wrote no file"):  # without it the script is run
        bsm.load(path)
    assert (path.parent / "was_run").exists()


def test_a_path_with_a_nul_is_none(inside: Case) -> None:
    for old, new in (
        (FILE, r'file = "a\u0000.msh"' + "\n"),
        (FILE, r'geometry = "a\u0000.py"' + "\n"),
        (LINEAR, LINEAR + BOLTS.replace("NAME", r"a\u0000.csv")),
        (LINEAR, LINEAR + r"[output]" + "\n" + r'folder = "a\u0000"' + "\n"),
    ):
        inside.write("model/model.toml", (MODEL + LINEAR).replace(old, new))
        inside.refuses("run", "model/model.toml", says=[r"a\x00", "must be the name of a file or folder"])
    assert not list(Path(inside.folder).glob("a*"))
