"""Every number of a model: its unit, its range and its usual values. Each range stands here and nowhere else.

A dataclass carries a quantity at its field, ``young: Annotated[float, YOUNG]``, and `bsm_mesh.model.values.Rules` holds
it to the range; the tables of the model file and its JSON Schema take the same object. Ranges are generous: a value
beyond is a slip of the pen, or more than double precision carries. An unusual value is noted
(`bsm_mesh.model.notes`), for a factor of a thousand is the commonest slip of all.
"""

from __future__ import annotations

import inspect
import sys
import types
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any, Union, get_args, get_origin, get_type_hints

from bsm_mesh.model.quantity import Quantity


@cache
def quantities_of(owner: type[Any]) -> dict[str, tuple[Quantity, bool]]:
    """Return the quantity of every field of a dataclass that carries one, and whether None may take its place."""
    if not is_dataclass(owner):  # a law of the user's own
        return {}
    found: dict[str, tuple[Quantity, bool]] = {}
    for field in fields(owner):
        parts = _members(hint_of(owner, field.name)) if "Annotated[" in str(field.type) else ()
        marks = [mark for part in parts for mark in getattr(part, "__metadata__", ()) if isinstance(mark, Quantity)]
        if marks:
            found[field.name] = marks[0], types.NoneType in parts
    return found


def hint_of(owner: type[Any], name: str) -> Any:
    """Return the type of a field of a dataclass, whatever other fields name for type checkers only."""
    base = next(base for base in owner.__mro__ if name in inspect.get_annotations(base))
    hint = inspect.get_annotations(base)[name]
    if not isinstance(hint, str):
        return hint
    one = types.SimpleNamespace(__annotations__={name: hint})
    return get_type_hints(one, vars(sys.modules[base.__module__]), include_extras=True)[name]


def _members(hint: Any) -> tuple[Any, ...]:
    """Return the members of a union; another type is its own only member."""
    return get_args(hint) if get_origin(hint) in (Union, types.UnionType) else (hint,)


# Rocks, joints and fillings.
NO_LIMIT = (
    "for strength without a limit give a joint without law, or a rock without cohesion, friction and tensile_strength"
)
UNIT_WEIGHT = Quantity(
    unit="N/m^3", least=0, most=1e12, usual=(5e3, 5e4), doubtful=(5.0, 50.0), example='"26 kN/m^3"'
)  # what would be usual in kN/m^3 is meant so
YOUNG = Quantity(unit="Pa", least=1e-6, most=1e18, usual=(1e5, 5e11), example='"20 GPa"')
POISSON = Quantity(least=0, most=0.499, example="0.25")
COHESION = Quantity(unit="Pa", least=0, most=1e9, usual=(0, 1e8), example='"1 MPa"', why=NO_LIMIT)
LINER_COMPRESSION = Quantity(unit="Pa", least=1e3, most=1e10, usual=(1e6, 2e8), example='"25 MPa"')
TENSILE_STRENGTH = Quantity(unit="Pa", least=0, most=1e9, usual=(0, 5e7), example='"0.1 MPa"', why=NO_LIMIT)
# Of joints: Barton (1974), A review of the shear strength of filled discontinuities in rock, NGI publication 105, lists
# 0 to 0.74 MPa; Wang Table A.3 0 to 0.14 MPa. More than twice the greatest is that of rock bridges, or a slip of kPa.
ON_JOINTS = "tests of joints give less than 1 MPa; kPa may be meant"
JOINT_COHESION = Quantity(
    unit="Pa", least=0, most=1e9, usual=(0, 2e6), usual_why=ON_JOINTS, example='"50 kPa"', why=NO_LIMIT
)
JOINT_TENSILE_STRENGTH = Quantity(
    unit="Pa", least=0, most=1e9, usual=(0, 2e6), usual_why=ON_JOINTS, example='"0.1 MPa"', why=NO_LIMIT
)
FRICTION = Quantity(
    unit="degrees", least=0, below=90, usual=(0, 70), example='35 or "35 deg"'
)  # 70: Barton and Choubey 1977
DILATION = Quantity(unit="degrees", least=0, below=90, usual=(0, 45), example="5")
JRC = Quantity(least=0, most=20, example="8", why="Barton's profiles end at 20")
WALL_STRENGTH = Quantity(unit="Pa", least=1e4, most=1e10, usual=(1e6, 4e8), example='"80 MPa"')
RESIDUAL_FRICTION = Quantity(
    unit="degrees", least=0, below=70, usual=(10, 40), example="28", why="70 is the cap of Barton's law"
)
JOINT_LENGTH = Quantity(
    unit="m", least=0.1, most=1e4, usual=(0.1, 50), example='"1 m"', why="0.1 m is the laboratory's sample"
)
CLOSURE = Quantity(unit="m", least=1e-6, most=1, usual=(1e-5, 5e-3), example='"0.2 mm"')
SLIP = Quantity(unit="m", least=1e-6, most=1e3, usual=(1e-4, 1), example='"5 mm"')
STRENGTH_FACTOR = Quantity(
    least=1e-6, most=1e6, usual=(1e-6, 1), usual_why="it is a part of the given strength, 1 all of it", example="0.8"
)
STIFFNESS = Quantity(unit="Pa/m", least=1, most=1e18, usual=(1e5, 1e14), example='"5 GPa/m"')
STIFFNESS_EXPONENT = Quantity(above=0, most=2, usual=(0.2, 1), example="0.5")
REFERENCE_STRESS = Quantity(unit="Pa", least=1e2, most=1e10, usual=(1e4, 1e8), example='"1 MPa"')
THICKNESS = Quantity(unit="m", least=1e-6, most=10, usual=(1e-5, 1), example='"1 mm"')

# Places, directions and movements.
COORDINATE = Quantity(unit="m", least=-1e8, most=1e8, example='"2.5 m"')
DIRECTION = Quantity(unit="degrees", least=-360, most=360, example="-90")
AZIMUTH = Quantity(unit="degrees", least=-360, most=360, example="135")
GRAVITY_PART = Quantity(
    part_of="of the weight", least=-2, most=2, usual=(-0.5, 0.5), example="0.15", why="it is a part of the unit weight"
)
DISPLACEMENT = Quantity(unit="m", least=-1e3, most=1e3, usual=(-1, 1), example='"2 mm"')
BLOCK = Quantity(least=0, most=2**31 - 1, whole=True, example="7")

# Joints in three dimensions.
HEAD_DIP = Quantity(unit="degrees", least=0, most=80, example="5")
DIP = Quantity(unit="degrees", least=0, most=90, example="60", why="the dip direction says to which side")
JOINT_SPACING = Quantity(unit="m", least=1e-3, most=1e5, usual=(0.02, 100), example='"1.5 m"')
JOINT_DENSITY = Quantity(unit="1/m", least=1e-6, most=1e3, usual=(0.01, 50), example="0.8")
FISHER = Quantity(least=1, most=1e6, usual=(5, 1000), example="80", why="joints of a smaller constant are no set")
SEED = Quantity(least=0, most=2**31 - 1, whole=True, example="0")
REQUIRED_FACTOR = Quantity(above=0, most=100, usual=(1, 5), example="1.5")

# Loads, in-situ stress and water.
FORCE = Quantity(unit="N/m", least=-1e13, most=1e13, example='"120 kN/m"')
FORCE_IN_SPACE = Quantity(unit="N", least=-1e13, most=1e13, example='"120 kN"')
STRESS = Quantity(unit="Pa", least=-1e10, most=1e10, usual=(-2e8, 2e8), example='"220 kPa"')
STRESS_GRADIENT = Quantity(unit="Pa/m", least=-1e8, most=1e8, usual=(-1e6, 1e6), example='"26 kN/m^3"')
PRESSURE = Quantity(unit="Pa", least=0, most=1e10, usual=(0, 2e8), example='"220 kPa"')
LOAD_FACTOR = Quantity(least=-1e9, most=1e9, example="1.5")
EARTH_FACTOR = Quantity(least=0, most=1e9, usual=(0.1, 10), example="1.35", why="soil presses and does not pull")
OVERCONSOLIDATION = Quantity(least=1, most=1e3, usual=(1, 50), example="2")
RELAXATION = Quantity(least=0, most=1, example="0.5")
STRESS_RATIO = Quantity(least=0, most=20, usual=(0, 5), example="0.5", why="it is horizontal over vertical stress")
RATIO_BY_DEPTH = Quantity(unit="m", least=0, most=1e4, example="267")
RATIO_PER_DEPTH = Quantity(unit="1/m", least=-0.1, most=0.1, example="0.001")
WATER_WEIGHT = Quantity(unit="N/m^3", least=1e-9, most=1e6, usual=(9e3, 1.4e4), example='"9.81 kN/m^3"')

# Flow in joints.
APERTURE = Quantity(unit="m", least=0, most=0.1, usual=(0, 5e-3), example='"0.2 mm"', why="0 is a sealed joint")
VISCOSITY = Quantity(unit="Pa s", least=1e-6, most=1e3, usual=(2e-4, 2e-3), example='"1.3 mPa s"')
DISCHARGE = Quantity(unit="m^2/s", least=-100, most=100, usual=(-0.1, 0.1), example='"0.2 l/s/m"')
FLOW_TOLERANCE = Quantity(least=1e-9, most=1e-2, example="1e-4", why="it is a part of the greatest pressure")
ROUNDS = Quantity(least=1, most=10_000, whole=True, example="50")

# Bolts; forces are those of one bolt.
BOLT_DIAMETER = Quantity(unit="m", least=1e-3, most=0.5, usual=(5e-3, 0.1), example='"25 mm"')
HOLE_DIAMETER = Quantity(unit="m", least=1e-3, most=1, usual=(5e-3, 0.3), example='"38 mm"')
BOLT_YOUNG = Quantity(unit="Pa", least=1e6, most=1e13, usual=(1e9, 5e11), example='"200 GPa"')
BOLT_STIFFNESS = Quantity(unit="N", least=1e2, most=1e13, usual=(1e6, 1e10), example='"98 MN"')
YIELD_STRENGTH = Quantity(unit="Pa", least=1e3, most=1e11, usual=(1e7, 3e9), example='"500 MPa"')
BOLT_FORCE = Quantity(unit="N", least=0, most=1e9, usual=(0, 1e7), example='"100 kN"')
BOLT_CAPACITY = Quantity(unit="N", above=0, most=1e9, usual=(1e3, 1e7), example='"100 kN"')
BOLT_SPACING = Quantity(unit="m", least=0.01, most=100, usual=(0.2, 10), example='"1.5 m"')
BOND_STRENGTH = Quantity(unit="N/m", least=0, most=1e9, usual=(0, 1e7), example='"150 kN/m"')
BOND_SHEAR_STRENGTH = Quantity(unit="Pa", least=0, most=1e9, usual=(0, 1e8), example='"1 MPa"')
BOND_STIFFNESS = Quantity(unit="N/m^2", least=1, most=1e15, usual=(1e5, 1e13), example='"1 GPa"')
BEARING_STRENGTH = Quantity(unit="Pa", least=1, most=1e11, usual=(1e4, 1e9), example='"60 MPa"')
BOLT_LENGTH = Quantity(unit="m", least=1e-3, most=1e3, usual=(0.1, 100), example='"3 m"')
BOLT_INTERVAL = Quantity(unit="m", least=1e-3, most=1e4, example='"1.5 m"')
BOLT_COUNT = Quantity(least=1, most=10_000, whole=True, example="9")
RADIUS = Quantity(unit="m", least=0, most=1e5, example='"2 m"')
DISTANCE = Quantity(unit="m", least=0, most=1e6, example='"0.75 m"')

# Shaking.
FREQUENCY = Quantity(unit="Hz", least=1e-3, most=1e6, usual=(0.05, 1e3), example='"2 Hz"')
MOTION = Quantity(least=-1e9, most=1e9, example="3.0", why="an acceleration [m/s^2], a velocity [m/s], a stress [Pa]")
COUNT_OF_WAVES = Quantity(above=0, most=1e6, example="10")
MOTION_FACTOR = Quantity(least=-1e6, most=1e6, usual=(-10, 10), example="0.5")
DURATION = Quantity(unit="s", least=1e-6, most=1e5, usual=(1e-4, 600), example='"20 s"')
MASS_SCALING = Quantity(least=1, most=1e6, usual=(1, 10), example="2", why="1 leaves every block its real mass")
DAMPING = Quantity(least=0, most=1, usual=(0, 1), example="0.2", why="1 is critical damping")
IMBALANCE = Quantity(above=0, most=1, usual=(0, 0.05), example="0.01")

# Meshes.
UNIT_OF_LENGTH = Quantity(unit="m", least=1e-6, most=1e4, example='"mm"', why="rock is measured in um to km")
MERGE_TOLERANCE = Quantity(unit="m", least=0, most=1, usual=(0, 0.01), example="1e-9")

# How a model is solved.
TOLERANCE = Quantity(
    least=1e-12,
    most=1e-4,
    example="1e-6",
    why="with a greater one blocks that slide or topple slowly count as at rest, a smaller one is lost in rounding",
)
STEPS = Quantity(least=1, most=10**9, whole=True, example="500")
DISPLACEMENT_LIMIT = Quantity(unit="m", least=1e-9, most=1e6, example='"5 m"')
PART = Quantity(above=0, most=1, example="1.0")
SHARE = Quantity(least=0, most=0.25, example="0.01", why="of the mean area; larger blocks matter to an engineer")
GSI = Quantity(least=0, most=100, usual=(5, 100), example="50", why="the Geological Strength Index ends there")
HOEK_BROWN_MI = Quantity(least=0.1, most=100, usual=(1, 40), example="10")
DISTURBANCE = Quantity(least=0, most=1, example="0", why="1 is a heavily disturbed rock mass")
HOEK_BROWN_MB = Quantity(least=1e-3, most=100, usual=(0.01, 40), example="1.7")
HOEK_BROWN_S = Quantity(least=0, most=1, example="0.004", why="1 is intact rock")
HOEK_BROWN_A = Quantity(least=0.3, most=1, usual=(0.5, 0.67), example="0.5", why="1 is a straight line")
REDUCTION = Quantity(least=1e-6, most=1e6, example="1.2")
ZONE_SIZE = Quantity(unit="m", least=1e-6, most=1e6, example='"0.5 m"')
ZONE_ORDER = Quantity(least=1, most=2, whole=True, example="2")
THREADS = Quantity(least=0, most=4096, whole=True, example="0, all cores")
WIDTH = Quantity(
    least=1e-4, most=0.2, example="0.005", why="of a bracket over its value; runs differ by more than a narrower one"
)
MOVEMENT = Quantity(above=0, most=10, example="0.05", why="of a block's size; a smaller displacement is no failure")
TRIALS = Quantity(least=1, most=1000, whole=True, example="40")
PROCESSES = Quantity(least=1, most=4096, whole=True, example="2")

# Laboratory tests of joints and bolts.
TEST_STRESS = Quantity(unit="Pa", above=0, most=1e10, usual=(1e3, 1e8), example='"1 MPa"')
SHEAR_MOVEMENT = Quantity(unit="m", above=0, most=1e3, usual=(1e-4, 1), example='"10 mm"')
COUNT_OF_CYCLES = Quantity(least=0, most=1000, whole=True, example="2")
STEPS_OF_TEST = Quantity(least=2, most=100_000, whole=True, example="200")
BOLT_INCLINATION = Quantity(unit="degrees", above=-90, below=90, example="30")
