"""Polyhedral blocks from meshes; blocks and their contact polygons as VTU files."""

from bsm_mesh.converters.three_d.solid_meshes import read_polyhedra
from bsm_mesh.converters.three_d.vtu import block_grid, contact_grid, write_blocks, write_contacts, write_mechanism

__all__ = [
    "block_grid",
    "contact_grid",
    "read_polyhedra",
    "write_blocks",
    "write_contacts",
    "write_mechanism",
]
