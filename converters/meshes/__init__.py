"""From meshes to blocks, step by step: file, cells, outlines, groups, curves, blocks."""
