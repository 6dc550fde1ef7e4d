"""Polyhedral blocks and their contact polygons as VTU files."""

from bsm_mesh.converters.three_d.vtu import block_grid, contact_grid, write_blocks, write_contacts

__all__ = ["block_grid", "contact_grid", "write_blocks", "write_contacts"]
