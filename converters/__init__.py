"""From meshes to blocks and joints, from results to VTU, and the continuum solution beside it."""
