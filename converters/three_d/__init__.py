"""Polyhedral blocks from meshes and surfaces; blocks and their contact polygons as files."""

from bsm_mesh.converters.three_d.polyhedra_files import read_polyhedra_file, write_polyhedra
from bsm_mesh.converters.three_d.solid_meshes import read_polyhedra
from bsm_mesh.converters.three_d.stones import read_stones, write_surfaces
from bsm_mesh.converters.three_d.vtu import block_grid, contact_grid, write_blocks, write_contacts, write_mechanism

__all__ = [
    "block_grid",
    "contact_grid",
    "read_polyhedra",
    "read_polyhedra_file",
    "read_stones",
    "write_blocks",
    "write_contacts",
    "write_mechanism",
    "write_polyhedra",
    "write_surfaces",
]
