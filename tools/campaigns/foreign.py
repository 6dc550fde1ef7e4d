"""Files of users of other programs and of strangers, small: what is expected of each, and what the program does.

Each kind was once read wrongly, refused untruly or obeyed as a command. ``python -m tools.campaigns seeds`` prints a
table of them.
"""

from __future__ import annotations

import contextlib
import io
import math
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import tomli_w

from tests.scenes.square_mesh import NODES, QUADS, msh_of

from .place import Place
from .seeds import ABAQUS, DRAWING, FEATURES, FORMS, HALVES, TABLES_OF_LINES, write_forms

Tree = dict[str, Any]


@dataclass(frozen=True)
class Foreign:
    """Files, what is done with them, and what must come of it.

    Attributes
    ----------
    kind, name : str
        What sort of file, and which.
    expected : str
        What must come of it, for people.
    files : mapping of str to bytes
        In a folder of their own; `model.toml` is among them.
    commands : tuple of tuple of str
        Done one after the other; the last one counts.
    code : int
        Its exit code.
    says : tuple of str
        Words of what it prints.
    links : mapping of str to str
        Links in the folder, and where they lead.
    after : callable
        What is wrong with the folder afterwards; empty where nothing is.
    """

    kind: str
    name: str
    expected: str
    files: Mapping[str, bytes]
    commands: tuple[tuple[str, ...], ...]
    code: int
    says: tuple[str, ...] = ()
    links: Mapping[str, str] = field(default_factory=dict)
    after: Callable[[Path], str] = lambda folder: ""


def done(there: Place, given: Foreign) -> tuple[str, list[str]]:
    """Return what a command printed last, and what is not as expected."""
    there.clean()
    there.put(given.files)
    for link, target in given.links.items():
        (there.folder / link).symlink_to(target)
    for words in given.commands:
        code, told = command(*words)
    missing = [f"does not say {word!r}" for word in given.says if word not in told]
    wrong = [
        *([] if code == given.code else [f"exit code {code}"]),
        *missing,
        *filter(None, [given.after(there.folder)]),
    ]
    return told, wrong


def command(*words: str) -> tuple[int, str]:
    """Return the exit code of a command of ``bsm-mesh``, and all that it prints."""
    from bsm_mesh.commands.cli import main

    out = io.StringIO()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
            main(list(words))
    except SystemExit as leaving:
        return leaving.code if isinstance(leaving.code, int) else int(leaving.code is not None), out.getvalue()
    return 0, out.getvalue()


JOINT = {"normal_stiffness": 1e10, "shear_stiffness": 2e9, "law": "mohr_coulomb", "friction": 30}
ROCK = {"unit_weight": 26e3, "young": 20e9, "poisson": 0.25}
RUN, CHECK = ("run", "model.toml", "-o", "out", "--json"), ("check", "model.toml")
TWO = '"blocks": 2'


def model(
    mesh: Tree, *, rock: str = "gneiss", base: str = "bottom", joints: Tree | None = None, **tables: Any
) -> bytes:
    """Return a model file."""
    tree = {"mesh": mesh, "rock": {rock: ROCK}, "joint": joints or {}, "support": [{"boundary": base, "fix": "all"}]}
    return tomli_w.dumps(tree | tables).encode()


WEDGE = [(0.0, 0.0), (10.0, 0.0), (10.0, 8.390996), (5.0, 4.195498), (10.0, 10.390996), (0.0, 2.0)]  # on 40 degrees
FACES = [(0, 1, 3), (1, 2, 3), (3, 2, 4), (0, 3, 5), (3, 4, 5)]
FACTOR = math.tan(math.radians(30)) / math.tan(math.radians(40))
Named = tuple[str | None, str | None]


def wedge(
    names: Named, version: str, place: Callable[[float], str] = repr, scale: float = 1.0, by: Any = (0, 0)
) -> bytes:
    """Return the mesh of a wedge on a plane of two parts, in groups of these names."""
    nodes = [(place(x / scale + by[0]), place(y / scale + by[1])) for x, y in WEDGE]
    curves = [(1, names[0], [(0, 3)]), (1, names[1], [(3, 2)]), (1, "boundary:bottom", [(0, 1)])]
    return msh_of(nodes, [*curves, (2, "rock:gneiss", FACES)], version).encode()


def _of_wedge(unit: str = "m") -> bytes:
    return model({"file": "mesh.msh", "blocks": "regions", "unit": unit}, joints={"plane": JOINT})


def groups() -> Iterator[Foreign]:
    """Yield groups of one name, and without a name: the wedge slides, for its factor is tan(30) / tan(40) = 0.69."""
    same = ("joint:plane", "joint:plane")
    for version in ("4.1", "2.2"):
        files = {"mesh.msh": wedge(same, version), "model.toml": _of_wedge()}
        name = f"two groups of one name, MSH {version}"
        yield Foreign("groups", name, "added up: unstable", files, (RUN,), 0, ('"status": "unstable"', TWO))
        files = {"mesh.msh": wedge(("joint:plane", None), version), "model.toml": _of_wedge()}
        says = ("gmsh:physical=2", "one addPhysicalGroup")
        yield Foreign("groups", f"one has no name, MSH {version}", "refused, with its number", files, (RUN,), 2, says)
    halves = {"mesh.msh": msh_of(NODES, HALVES, "2.2").encode()}
    halves["model.toml"] = model({"file": "mesh.msh", "blocks": "regions"}, joints={"J1": JOINT})
    says = ("4 m2", "2 blocks")
    yield Foreign("groups", "halves of joint, base and rock", "all of the rock, two blocks", halves, (CHECK,), 0, says)


def coordinates() -> Iterator[Foreign]:
    """Yield the wedge elsewhere, to few digits, in other units: the factor is the same."""
    far, digits = (512345.0, 4501234.0), f"{math.floor(1e5 * FACTOR) / 1e5:.5f}"
    for name, unit, mesh in (
        ("at the origin", "m", {}),
        ("map", "m", {"by": far}),
        ("map, 4 decimals", "m", {"by": far, "place": lambda x: f"{x:.4f}"}),
        ("6 decimals", "m", {"place": lambda x: f"{x:.6f}"}),
        ("mm", "mm", {"scale": 1e-3}),
        ("feet", "ft", {"scale": 0.3048}),
    ):
        files = {"mesh.msh": wedge(("joint:plane",) * 2, "4.1", **mesh), "model.toml": _of_wedge(unit)}  # type: ignore[arg-type]
        words = ("limit", "model.toml", "--strength", "--json")
        yield Foreign("coordinates", name, f"factor {FACTOR:.4f}", files, (words,), 0, (digits,))


def along(name: str, data: bytes, group: str | None) -> dict[str, bytes]:
    """Return four squares in the rock of which a joint lies along the lines of a file."""
    lines = name if group is None else {"file": name, "set": group}
    text = model(
        {"file": "mesh.msh", "blocks": "regions"},
        base="base",
        joints={"L": {**JOINT, "along": lines}},
        boundary={"base": {"below": 0.01}},
    )
    return {"mesh.msh": msh_of(NODES, [(2, "rock:gneiss", QUADS)], "4.1").encode(), "model.toml": text, name: data}


def lines() -> Iterator[Foreign]:
    """Yield lines of joints in files of GIS, of drawings, and of spreadsheets of several countries."""
    for number, name, group, expected, says in (
        (0, "a line in a GeometryCollection", "J1", "a line: two blocks", ()),
        (1, "a polygon, and a feature without geometry", None, "the line; the others counted", ("1 Polygon",)),
        (2, "the set is the number 0", "0", "the set '0': two blocks", ()),
        (3, "a CRS in feet", "J1", "metres, with a note", ("US survey foot",)),
    ):
        files = along("t.geojson", FEATURES[number], group)
        yield Foreign("GeoJSON", name, expected, files, (RUN,), 0, (TWO, *says))
    says = ("$INSUNITS", "mm", "xz plane")
    yield Foreign(
        "DXF",
        "in the front view, in mm",
        "turned and in metres, with notes",
        along("t.dxf", DRAWING, None),
        (RUN,),
        0,
        says,
    )
    for name, data in TABLES_OF_LINES.items():
        yield Foreign("CSV", name, "the line: two blocks", along("t.csv", data, None), (RUN,), 0, (TWO,))


def abaqus() -> Iterator[Foreign]:
    """Yield keywords of Abaqus that make, copy or move nodes and elements."""
    refused = {"system": "line 1: *SYSTEM", "elgen": "*ELGEN", "ngen": "*NGEN", "ncopy": "*NCOPY"}
    names = {"*": "rock:gneiss", "BASE": "boundary:bottom"}
    for name, text in ABAQUS.items():
        files = {"mesh.inp": text.encode(), "model.toml": model({"file": "mesh.inp"}, groups=names)}
        if name in refused:
            yield Foreign("Abaqus", f"*{name.upper()}", "refused by name and line", files, (RUN,), 2, (refused[name],))
        else:
            yield Foreign("Abaqus", "*NODE, NSET=BASE", "the set is read", files, (RUN,), 0, (TWO,))


@cache
def _forms() -> dict[str, bytes]:
    """Return the mesh of a wedge as Gmsh writes it in forms that few readers know."""
    from bsm_mesh.geometries import gmsh_session

    with tempfile.TemporaryDirectory() as folder, gmsh_session() as gmsh:
        path = Path(folder) / "mesh.msh"
        path.write_bytes(wedge(("joint:plane", "joint:upper"), "2.2"))
        gmsh.open(str(path))
        write_forms(gmsh, Path(folder))
        return {name: (Path(folder) / name).read_bytes() for name in FORMS}


def meshes() -> Iterator[Foreign]:
    """Yield forms of meshes that few readers know."""
    unnamed = {
        "gmsh:physical=4": "rock:gneiss",
        "gmsh:physical=1": "joint:plane",
        "gmsh:physical=2": "joint:plane",
        "gmsh:physical=3": "boundary:bottom",
    }
    for name, told, code, says in (
        ("parametric.msh", "read: unstable", 0, ('"status": "unstable"', TWO)),
        ("of_2018.msh", "read: unstable", 0, ('"status": "unstable"', TWO)),
        ("of_2003.msh", "read by the groups' numbers: unstable", 0, ('"status": "unstable"', TWO)),
        ("all.msh", "refused with the cure", 2, ("Mesh.SaveAll",)),
        ("gmsh.bdf", "refused: names of groups are not in it", 2, ("nastran:ref=",)),
    ):
        mesh = {"file": name, "blocks": "regions"}
        names = unnamed if name == "of_2003.msh" else {"joint:upper": "joint:plane"} if code == 0 else {}
        files = {name: _forms()[name], "model.toml": model(mesh, joints={"plane": JOINT}, groups=names)}
        yield Foreign("meshes", name, told, files, (RUN,), code, says)
