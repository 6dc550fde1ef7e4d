"""Small good models of what `small_models` leaves out: zones, shaking, flow, laws, histories, three dimensions.

Each comes with the files that it needs beside the small mesh.
"""

from __future__ import annotations

import tomllib
from typing import Any

RECORD = b"time [s],acceleration [g]\n0,0\n0.01,0.2\n0.02,-0.2\n0.03,0\n"
MEASURED = b"history,source,stage,u [mm],v [mm]\ncrest,prism 7,dig,0.4,-0.1\n"
PROFILE = b"x,z\n-0.5,1.5\n0.5,1.5\n0.5,2\n-0.5,2\n"
_HEAD = """
title = "Four blocks"
[mesh]
file = "mesh.msh"
[[support]]
boundary = "bottom"
fix = "all"
[rock.gneiss]
unit_weight = "26 kN/m^3"
young = "10 GPa"
poisson = 0.25
"""
_JOINTS = """
[joint.J1]
normal_stiffness = "5 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 35
[joint.J2]
normal_stiffness = "5 GPa/m"
shear_stiffness = "1 GPa/m"
friction = 30
"""
_ZONES = """
zones = { size = "0.7 m", order = 1 }
cohesion = "1 MPa"
friction = 40
residual_friction = 30
residual_cohesion = "0.1 MPa"
softening_slip = "1 cm"
[[load]]
boundary = "top"
[load.earth_pressure]
surface = "3 m"
state = "active"
unit_weight = "20 kN/m^3"
friction = 30
theory = "rankine"
cohesion = "1 kPa"
surcharge = "10 kPa"
factor = 1.5
[[load]]
boundary = "left"
[load.earth_pressure]
surface = [[-2, 3], [0, 2]]
state = "passive"
unit_weight = 2e4
friction = 30
theory = "coulomb"
wall_friction = 5
[report]
project = "Road cut"
author = "A. Engineer"
date = "2026-11-26"
"""
_SHAKEN = """
[[stage]]
name = "earthquake"
[stage.shaking]
record = "record.csv"
quantity = "acceleration"
direction = 10
scale = 0.5
duration = "0.02 s"
every = "1 ms"
contact_damping = 0.2
mass_damping = { ratio = 0.02, frequency = "20 Hz" }
time_step = 0.5
mass_scaling = 1.5
max_imbalance = 0.05
integrator = "explicit"
[[stage]]
name = "weathered"
gravity = { horizontal = 0.1, vertical = -0.05 }
strength = { J1 = 0.8, "*" = 0.9 }
[[stage]]
name = "blast"
[stage.shaking]
waveform = "sine"
frequency = "50 Hz"
amplitude = 0.1
cycles = 1
quantity = "velocity"
"""
_LAWS = """
[joint.J1]
normal_stiffness = "5 GPa/m"
shear_stiffness = "1 GPa/m"
law = "barton_bandis"
jrc = 8
jcs = "60 MPa"
residual_friction = 28
joint_length = "1 m"
roughness_wears = true
max_closure = "0.5 mm"
shear_stiffness_exponent = 0.5
reference_stress = "1 MPa"
aperture = "0.3 mm"
residual_aperture = "0.05 mm"
crushing_strength = "60 MPa"
[joint.J2]
normal_stiffness = "5 GPa/m"
shear_stiffness = "1 GPa/m"
law = "ladanyi_archambault"
friction = 30
dilation = 10
jcs = "50 MPa"
dilation_angle = 4
dilation_slip = "5 mm"
aperture = "0.2 mm"
residual_aperture = "0.02 mm"
[flow]
head = { left = "1.5 m" }
seepage = ["top"]
unit_weight = "9.81 kN/m^3"
viscosity = 1e-3
coupling = "two_way"
tolerance = 1e-3
max_rounds = 20
[[flow.drain]]
start = [0.2, 0.5]
end = [1.8, 1.5]
level = "0.6 m"
[[flow.well]]
point = [1, 0.5]
discharge = 1e-6
[[flow.grout]]
polygon = [[0.5, 0.5], [1.5, 0.5], [1.5, 1.5], [0.5, 1.5]]
aperture = "0.01 mm"
[[history]]
name = "crest"
point = [0.5, 1.9]
measured = "measured.csv"
[[history]]
name = "rod"
line = [[0.5, 1.9], [0.5, 0.5]]
[[history]]
name = "wedge"
block = 2
[[history]]
name = "bedding"
joint = "J1"
[falls]
ignore_below = 0.05
on_fall = "remove"
[boundary.right]
right_of = "1.99 m"
[boundary.rim]
along = [[2, 0], [2, 2]]
[output]
snapshots = "steps"
tables = "csv"
compression = "lz4"
[[stage]]
name = "dig"
excavate = ["1"]
[stage.flow]
head = { left = "1 m" }
closed = ["bottom"]
"""
_SPACE = """
dimensions = 3
title = "Block under a lid"
[mesh]
box = [[0, 0, 0], [2, 2, 3]]
default_joint = "J1"
seed = 1
contact_points = "both"
[rock.granite]
unit_weight = "26 kN/m^3"
young = "10 GPa"
poisson = 0.25
[joint.J1]
normal_stiffness = "1 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 35
[joint.J2]
normal_stiffness = "1 GPa/m"
shear_stiffness = "1 GPa/m"
law = "mohr_coulomb"
friction = 35
cohesion = "5 kPa"
[[joint_plane]]
name = "J1"
dip = 30
dip_direction = 90
point = [1, 1, 1]
[[joint_set]]
name = "J2"
dip = 80
dip_direction = 180
spacing = { law = "normal", mean = "1.2 m", deviation = "0.1 m" }
origin = [1, 1, 1]
persistence = 0.9
scatter = { fisher = 200 }
[[excavation]]
name = "lid"
polygon = [[-2, 2.5], [2, 2.5], [2, 3], [-2, 3]]
origin = [1, 1, 0]
axis = { trend = 0, plunge = 0 }
[[support]]
boundary = "bottom"
fix = "all"
[[support]]
boundary = "west"
fix = "normal"
[[load]]
boundary = "east"
pressure = "1 kPa"
[[load]]
block = 4
point = [1, 1, 0.3]
force = ["1 kN", 0, -2000]
[water]
plane = { point = [0, 0, 1], dip = 5, dip_direction = 90 }
joint_pressure = { J1 = "1 kPa" }
unit_weight = "9.81 kN/m^3"
[gravity]
horizontal = 0.05
vertical = -0.05
[key_blocks]
required = 1.5
rounds = 2
free = ["top"]
gravity = [0.1, 0, -1]
joint_pressure = { J1 = "1 kPa" }
[solver]
max_steps = 60
[falls]
ignore_below = 0.02
[[stage]]
name = "lid off"
excavate = ["lid"]
relaxation = [0.5]
pressure = "1 kPa"
[[stage]]
name = "weaker"
strength = { J1 = 0.9 }
[[stage.load]]
boundary = "east"
pressure = "1 kPa"
"""
_SLOPE = """
dimensions = 3
[mesh]
box = [[-4, -4, -1], [4, 4, 4]]
rock = "granite"
[rock.granite]
unit_weight = "26 kN/m^3"
young = "10 GPa"
poisson = 0.25
[joint.A]
normal_stiffness = "1 GPa/m"
shear_stiffness = "1 GPa/m"
friction = 35
[[joint_set]]
name = "A"
dip = 45
dip_direction = 150
density = 0.3
radius = { law = "lognormal", mean = "3 m", deviation = "1 m" }
[slope]
toe = [0, -2, 0]
face = { dip = 70, dip_direction = 180 }
height = "3 m"
top = { dip = 5, dip_direction = 180 }
[[excavation]]
name = "adit"
profile = "profile.csv"
from = -1
to = 1
[[support]]
boundary = "bottom"
fix = "all"
"""
Given = tuple[dict[str, Any], dict[str, bytes]]
PLANE: list[Given] = [
    (tomllib.loads(_HEAD + _ZONES + _JOINTS), {}),
    (tomllib.loads(_HEAD + _JOINTS + _SHAKEN), {"record.csv": RECORD}),
    (tomllib.loads(_HEAD + _LAWS), {"measured.csv": MEASURED}),
]
SPACE: list[Given] = [
    (tomllib.loads(_SPACE), {}),
    (tomllib.loads(_SLOPE), {"profile.csv": PROFILE}),
]
