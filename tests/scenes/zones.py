"""Bodies with zones whose answers are known in closed form, by name, with what zones find."""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt

import numpy as np

import bsm_mesh as bsm
from tests.scenes.kirsch import error_near, model_of, plate
from tests.scenes.shapes import rectangle, turned

E, NU = 50e9, 0.25
SHEAR = np.array([(0.0, 1e6), (1e6, 0.0)])
UNIAXIAL = np.array([(0.0, 0.0), (0.0, -1e6)])


def rock(name="rock", *, size=None, order=2, young=E, poisson=NU, **given):
    return bsm.Rock(
        name, unit_weight=0.0, young=young, poisson=poisson, zones=bsm.Zones(size=size, order=order), **given
    )


def joint(kn=10e9, ks=5e9, **given):
    return bsm.Joint("J", normal_stiffness=kn, shear_stiffness=ks, **given)


SIDES = {"left": (0, 0), "right": (0, 1), "bottom": (1, 0), "top": (1, 1)}


def box(polygons, names="rock", degrees=0.0):
    """Return blocks that fill a rectangle from the origin, turned about it, with its four sides as boundaries."""
    high = np.max([np.max(polygon, axis=0) for polygon in polygons], axis=0)
    blocks = bsm.Blocks.from_polygons([turned(polygon, degrees) for polygon in polygons], rock=names)
    for name, (axis, end) in SIDES.items():
        blocks = blocks.with_boundary(
            name,
            lambda x, y, axis=axis, end=end: (
                np.abs(turned(np.column_stack([x, y]), -degrees)[:, axis] - end * high[axis]) < 1e-9
            ),
        )
    return blocks


def tractions(blocks, stress):
    """Return the loads of a uniform stress on the four sides."""
    found = []
    for name in SIDES:
        along = blocks.edge_vectors[blocks.boundaries[name]]
        normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.hypot(*along.T)[:, None]
        found.append(bsm.EdgeTractions(boundary=name, values=np.repeat((normal @ stress)[:, None, :], 2, axis=1)))
    return found


def under_stress(polygons, stress, rocks, *, names="rock", degrees=0.0, **given):
    """Return a rectangle under the tractions of a uniform stress, its lower corners held, both turned."""
    blocks = box(polygons, names, degrees)
    far = turned((np.max([np.max(polygon, axis=0)[0] for polygon in polygons]), 0.0), degrees)
    held = [bsm.Roller(point=(0.0, 0.0), direction=degrees + angle) for angle in (0, 90)]
    turn = turned(np.eye(2), degrees)
    return bsm.Model(
        blocks=blocks,
        rocks=rocks,
        supports=[*held, bsm.Roller(point=tuple(far.tolist()), direction=degrees + 90)],
        loads=tractions(blocks, turn.T @ stress @ turn),
        **given,
    )


def solved(model):
    """Return the last stage of a model, which is in equilibrium and checked."""
    results = bsm.run(model)
    assert results.status == "stable", results.stages[-1].reason
    assert results.check().ok
    return results.stages[-1]


GRID = [rectangle(2 * i, 2 * j, 2 * i + 2, 2 * j + 2) for j in range(4) for i in range(4)]


def modulus(order):
    """Return the modulus [GPa] of a rock with a joint every 2 m across the load."""
    given = {"joints": [joint()], "default_joint": "J"}
    stage = solved(under_stress(GRID, UNIAXIAL, [rock(poisson=0.0, order=order)], **given))
    return -1e-3 / ((stage.displacement[12, 1] - stage.displacement[4, 1]) / 4)


def shear_modulus(order):
    """Return the shear modulus [GPa] of a rock with a joint every 2 m."""
    slabs = [rectangle(0, 2 * j, 8, 2 * j + 2) for j in range(4)]
    given = {"joints": [joint()], "default_joint": "J"}
    stage = solved(under_stress(slabs, SHEAR, [rock(young=40e9, poisson=0.0, order=order)], **given))
    sideways = (stage.displacement[2, 0] - stage.displacement[1, 0]) / 2
    low = stage.zones.points[:, 1] < 1e-9
    upwards = np.polyfit(stage.zones.points[low, 0], stage.zones.displacement[low, 1], 1)[0]
    return 1e-3 / (sideways + upwards)


def stress_ratio(order):
    """Return the horizontal over the vertical stress of jointed rock between smooth, rigid sides."""
    model = bsm.Model(
        blocks=box(GRID),
        rocks=[rock(order=order)],
        joints=[joint()],
        default_joint="J",
        supports=[bsm.NormalRoller(boundary=side) for side in ("left", "right", "bottom")],
        loads=[bsm.Pressure(boundary="top", pressure=1e6)],
    )
    mean = solved(model).stress.mean(axis=0)
    return mean[0, 0] / mean[1, 1]


CRACK = {"modulus": 88.9e9, "stiffness": 220e9, "phi": radians(16), "slips": 0.54, "length": sqrt(2)}


def crack_exact():
    """Return the stiffness [GN/m] of loading, of unloading before and of unloading after the crack slips back."""
    k, phi, slips, length = (CRACK[name] for name in ("stiffness", "phi", "slips", "length"))
    stick = 1 / (2 / CRACK["modulus"] + 1 / (k * length))

    def sliding(sign):
        more = slips * sin(pi / 4) * sin(pi / 4 + sign * phi) / (length * (length - slips) * cos(phi) * k)
        return 1 / (1 / stick + more)

    return np.array([sliding(-1), stick, sliding(1)]) / 1e9


def crack(order):
    """Return the same of an elastic column under two stiff halves, on whose joint the crack lies."""
    k, length = CRACK["stiffness"], CRACK["length"]
    s = (length - CRACK["slips"]) / 2 / length
    a, b = (s, 2 + s), (1 - s, 3 - s)
    base = [(0, 0), (1, 0), (1, 2), (0, 2)]
    lower, upper = [(0, 2), (1, 2), (1, 3), b, a], [(0, 2), a, b, (1, 3), (0, 3)]
    blocks = bsm.Blocks.from_polygons([base, lower, upper], rock=["rock", "stiff", "stiff"])
    blocks = blocks.with_joint("firm", lambda x, y: np.abs(y - x - 2) < 1e-9)
    blocks = blocks.with_joint("crack", lambda x, y: (np.abs(y - x - 2) < 1e-9) & (np.abs(x - 0.5) < 0.5 - s + 1e-9))
    blocks = blocks.with_boundary("bottom", lambda x, y: y < 1e-9).with_boundary("top", lambda x, y: y > 3 - 1e-9)
    steps = [4e6, 4e6, -0.05e6, -3e6, -1e6, -1e6]
    model = bsm.Model(
        blocks=blocks,
        rocks=[
            rock(young=CRACK["modulus"], poisson=0.0, order=order),
            rock("stiff", young=2e15, poisson=0.0, order=order),
        ],
        joints=[bsm.Joint("crack", k, k, law=bsm.MohrCoulomb(friction=16)), bsm.Joint("firm", k, k)],
        supports=[bsm.Fixed(boundary="bottom")],
        loads=[bsm.Pressure(boundary="top", pressure=1e5)],
        stages=[bsm.Stage(name=f"{n}", loads=[bsm.Pressure(boundary="top", pressure=p)]) for n, p in enumerate(steps)],
    )
    results = bsm.run(model)
    assert results.status == "stable", results.stages[-1].reason
    down = np.array([-stage.displacement[2, 1] for stage in results.stages])
    return (np.diff(np.cumsum([1e5, *steps])) / np.diff(down))[[1, 2, 5]] / 1e9


def stack(zones):
    """Return 300 square blocks under their weight between smooth sides, rigid or with zones."""
    elastic = {} if zones is None else {"young": 20e9, "poisson": NU, "zones": zones}
    return bsm.Model(
        blocks=box([rectangle(i, j, i + 1, j + 1) for j in range(15) for i in range(20)]),
        rocks=[bsm.Rock("rock", unit_weight=26e3, **elastic)],
        joints=[joint(1e9, 5e8, law=bsm.MohrCoulomb(friction=30))],
        default_joint="J",
        supports=[bsm.Fixed(boundary="bottom"), *(bsm.NormalRoller(boundary=side) for side in ("left", "right"))],
    )


def slab(size):
    """Return a square of rock under its weight, in one block."""
    return bsm.Model(
        blocks=box([rectangle(0, 0, 1, 1)]),
        rocks=[bsm.Rock("rock", unit_weight=26e3, young=E, poisson=NU, zones=bsm.Zones(size=size, order=1))],
        supports=[bsm.Fixed(boundary="bottom")],
    )


def slab_by_skfem(zones):
    """Return the displacements of `slab` on the same zones, by scikit-fem alone."""
    import skfem
    from skfem.models.elasticity import lame_parameters, linear_elasticity

    mesh = skfem.MeshTri(zones.points.T.copy(), zones.cells[:, :3].T.copy())
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementTriP1()))
    stiffness = linear_elasticity(*lame_parameters(E, NU)).assemble(basis)
    weight = skfem.LinearForm(lambda v, w: -26e3 * v[1]).assemble(basis)
    bottom = basis.get_dofs(lambda x: x[1] < 1e-9)
    return skfem.solve(*skfem.condense(stiffness, weight, D=bottom))[basis.nodal_dofs].T


def kirsch_error(order):
    """Return the error of the mean stress of 496 quads about a hole, up to three radii, relative to Kirsch's."""
    corners = plate(16)
    return error_near(solved(model_of(corners, "wang").replace(rocks=[rock(order=order)])).stress, corners)


def cantilever(order, size):
    """Return the deflection of a beam of 4 by 1 m over that by bending and shear."""
    load, length = 1e5, 4.0
    model = bsm.Model(
        blocks=box([rectangle(0, 0, length, 1)]),
        rocks=[rock(size=size, order=order)],
        supports=[bsm.Fixed(boundary="left")],
        loads=[bsm.Traction(boundary="right", traction=(0.0, load))],
    )
    zones = solved(model).zones
    tip = zones.displacement[zones.points[:, 0] > length - 1e-9, 1].mean()
    bending = load * length**3 / (3 * E / (1 - NU**2) / 12)
    return tip / (bending + 1.2 * load * length / (E / (2 * (1 + NU))))


def disc(order, size):
    """Return the stresses about the middle of a disc under two opposite loads, over 2 P/(pi D) and -6 P/(pi D)."""
    sides, load = 72, 1e6
    angle = 2 * pi * (np.arange(sides) + 0.5) / sides
    corners = np.column_stack([np.cos(angle), np.sin(angle)])
    blocks = bsm.Blocks.from_polygons([corners], rock="rock")
    for name, sign in (("top", 1), ("bottom", -1)):
        blocks = blocks.with_boundary(name, lambda x, y, sign=sign: sign * y > np.cos(pi / sides) - 1e-9)
    pressure = load / (2 * np.sin(pi / sides))
    model = bsm.Model(
        blocks=blocks,
        rocks=[rock(size=size, order=order)],
        supports=[
            bsm.Fixed(point=tuple(corners[0])),
            bsm.Roller(point=tuple(corners[sides // 2 - 1]), direction=90),
        ],
        loads=[bsm.Pressure(boundary=name, pressure=pressure) for name in ("top", "bottom")],
    )
    zones = solved(model).zones
    near = np.hypot(*zones.points[zones.cells[:, :3]].mean(axis=1).T) < 0.1
    stress = zones.stress[near].mean(axis=0)
    return stress[0, 0] / (load / pi), stress[1, 1] / (-3 * load / pi)
