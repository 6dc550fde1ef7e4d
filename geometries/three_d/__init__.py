"""Three-dimensional geometries."""
