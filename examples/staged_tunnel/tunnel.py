"""A circular tunnel in three parts, each an excavation group: heading, bench, invert."""

from bsm_mesh.geometries import gmsh_session, name_groups, write_mesh

RADIUS, DEPTH, BELOW, WIDTH = 4.0, 30.0, 20.0, 25.0
PARTS = {"heading": (0.5, RADIUS), "bench": (-2.0, 0.5), "invert": (-RADIUS, -2.0)}


def build(path, size: float = 4.0, size_at_wall: float = 1.2):
    """Write the mesh; the centre of the tunnel is the origin.

    Parameters
    ----------
    path : str
        The file.
    size, size_at_wall : float
        Lengths of the elements' edges far from the tunnel and in it [m].
    """
    with gmsh_session("staged_tunnel") as gmsh:
        occ = gmsh.model.occ
        ground = occ.addRectangle(-WIDTH, -BELOW, 0, 2 * WIDTH, BELOW + DEPTH)
        slices = []
        for low, high in PARTS.values():
            disk = occ.addDisk(0, 0, 0, RADIUS, RADIUS)
            box = occ.addRectangle(-2 * RADIUS, low, 0, 4 * RADIUS, high - low)
            slices += occ.intersect([(2, disk)], [(2, box)])[0]
        _, parts = occ.fragment([(2, ground)], slices)
        occ.synchronize()
        gmsh.model.mesh.setSize(gmsh.model.getEntities(0), size)
        inside = [surface for entity in parts[1:] for surface in entity]
        gmsh.model.mesh.setSize(gmsh.model.getBoundary(inside, recursive=True), size_at_wall)
        gmsh.model.mesh.generate(2)
        names = {f"excavation:{name}": [tag for _, tag in part] for name, part in zip(PARTS, parts[1:], strict=True)}
        sides = {"left": (-WIDTH, None), "right": (WIDTH, None), "bottom": (None, -BELOW)}
        for side, place in sides.items():
            names[f"boundary:{side}"] = [tag for dim, tag in gmsh.model.getEntities(1) if _lies_on(gmsh, tag, place)]
        name_groups({"rock:rock": [tag for _, tag in gmsh.model.getEntities(2)], **names})
        write_mesh(path)


def _lies_on(gmsh, curve, place):
    """Return whether a curve lies on x = place[0], or y = place[1]."""
    x, y, _ = gmsh.model.occ.getCenterOfMass(1, curve)
    return any(abs(at - given) < 1e-6 for at, given in zip((x, y), place, strict=True) if given is not None)
