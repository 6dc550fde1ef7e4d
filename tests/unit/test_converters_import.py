"""``from bsm_mesh import converters`` loads neither meshio nor VTK nor Gmsh; its names appear when they are used."""

from __future__ import annotations

import subprocess
import sys

import pytest

from bsm_mesh import converters


def test_importing_loads_no_mesh_library() -> None:
    code = (
        "import sys; from bsm_mesh import converters; "
        "print([m for m in ('meshio', 'vtkmodules', 'gmsh', 'shapely', 'scipy', 'skfem') if m in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    assert said.strip() == "[]"


@pytest.mark.parametrize("name", converters.__all__)
def test_every_public_name_is_there(name: str) -> None:
    assert getattr(converters, name).__name__ == name
    assert name in dir(converters)


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="no_such"):
        _ = converters.no_such
