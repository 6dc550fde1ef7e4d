"""Small good models: four blocks in a mesh, and model files that use every key between them."""

from __future__ import annotations

import copy
import tomllib
from typing import Any

from tests.scenes.square_mesh import QUADS, msh22

CURVES = {
    "boundary:bottom": [(0, 1), (1, 2)],
    "boundary:left": [(0, 3), (3, 6)],
    "boundary:top": [(6, 7), (7, 8)],
    "joint:J1": [(3, 4), (4, 5)],
    "joint:J2": [(1, 4), (4, 7)],
    "bolt:B1": [(0, 7)],
}
SURFACES = {"rock:gneiss": [0, 1, 2, 3], "excavation:1": [3]}
MESH = msh22(curves=CURVES, more={"excavation:1": [QUADS[k] for k in SURFACES["excavation:1"]]}).encode()
_BASE = """
title = "Four blocks"
[mesh]
file = "mesh.msh"
[rock.gneiss]
unit_weight = "26 kN/m^3"
young = "10 GPa"
poisson = 0.25
[joint.J1]
normal_stiffness = "5 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 35
[joint.J2]
normal_stiffness = "5 GPa/m"
shear_stiffness = "1 GPa/m"
law = "patton"
friction = 30
dilation = 5
cohesion = "20 kPa"
residual_friction = 28
[[support]]
boundary = "bottom"
fix = "all"
"""
_LOADED = """
[[load]]
boundary = "top"
pressure = "1 MPa"
[[load]]
boundary = "left"
traction = ["1 kPa", 0]
[[load]]
block = 3
point = [1.5, 1.5]
force = ["1 kN/m", -2000]
[gravity]
direction = -85
[solver]
scheme = "continuation"
tolerance = 1e-6
max_steps = 100
displacement_limit = "5 m"
linear_solver = "auto"
threads = 1
[output]
folder = "out"
snapshots = "stages"
"""
_GROUND = """
[in_situ]
method = "direct"
surface = "2 m"
surcharge = "10 kPa"
k0 = 0.5
[water]
table = [[0, 1.5], [2, 1]]
unit_weight = "9.81 kN/m^3"
head = "vertical"
joint_pressure = { J2 = "1 kPa" }
[[stage]]
name = "dig"
excavate = ["1"]
relaxation = [0.5, 1.0]
pressure = "1 kPa"
water = { table = [[0, 0.5]] }
[[stage.load]]
boundary = "top"
pressure = "2 kPa"
[[stage]]
name = "fill"
fill = ["1", [[1, 1], [2, 1], [2, 2], [1, 2]]]
excavate = [2]
"""
_BOLTED = """
[[bolt]]
name = "A"
start = [0.5, 1.9]
end = [0.5, 0.3]
kind = "grouted"
diameter = "25 mm"
young = "200 GPa"
yield_strength = "500 MPa"
pretension = "5 kN"
spacing = "1.5 m"
bond_strength = "150 kN/m"
bond_stiffness = "1 GPa"
bearing_stiffness = "2 GPa"
bearing_strength = "60 MPa"
plate = "100 kN"
[[bolt]]
start = [1.5, 1.9]
end = [1.5, 0.3]
kind = "end_anchored"
diameter = 0.025
anchor_capacity = "80 kN"
pretension = "10 kN"
[[bolt]]
radial = { centre = [1, 0.6], radius = 0.1, length = 0.7, count = 2, first = 60, last = 120 }
diameter = "20 mm"
hole_diameter = "30 mm"
bond_steel_grout = "1 MPa"
bond_grout_rock = "1 MPa"
[[bolt]]
row = { boundary = "top", length = 1.5, interval = 0.6, offset = 0.3, direction = -90 }
diameter = "25 mm"
[[bolt]]
curve = "B1"
diameter = "25 mm"
[[bolt]]
table = "bolts.csv"
"""
_STRONG = """
title = "Filled"
[mesh]
file = "mesh.msh"
unit = "m"
merge_tolerance = 1e-9
contact_points = "gauss"
blocks = "elements"
default_joint = "J1"
[groups]
"joint:J2" = "joint:J1"
[rock.gneiss]
unit_weight = 26e3
young = "20 GPa"
poisson = 0.2
cohesion = "1 MPa"
friction = 40
tensile_strength = "0.1 MPa"
stiffness = "wang"
[joint.J1]
filling = { thickness = "1 mm", young = "50 MPa", poisson = 0.3 }
law = "mohr_coulomb"
friction = 30
cohesion = "5 kPa"
tensile_strength = 0
[[support]]
blocks = [0]
fix = ["x", "y"]
[[support]]
point = [1.5, 1.5]
direction = 90
displacement = "-1 mm"
[[support]]
boundary = "left"
fix = "normal"
[in_situ]
stress = { xx = [-1e5, 0, 0], yy = "-0.1 MPa", xy = 0 }
[[load]]
boundary = "top"
in_situ = true
"""
MODELS: list[dict[str, Any]] = [
    tomllib.loads(text) for text in (_BASE, _BASE + _LOADED, _BASE + _GROUND, _BASE + _BOLTED, _STRONG)
]


def model(number: int) -> dict[str, Any]:
    """Return a copy of one of `MODELS`, to be changed."""
    return copy.deepcopy(MODELS[number])
