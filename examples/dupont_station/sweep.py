"""Everything that Case 1 assumes, and the bolts of Case 2, one thing changed at a time."""

from examples.dupont_station import station

KS = 0.136e9
SEEDS = range(1, 13)
PARTS = (1, 2, 4, 8)


def of_the_ground(base):
    """Yield name and model with other numbers on the same mesh."""
    for k in (0.7, 0.85, 1.3, 1.6):
        yield f"K = {k:g} (1)", station.with_k(base, k)
    for parts in (1, 2, 8):
        yield f"K = 0.85 (1), released in {parts} (4)", station.released_in(station.with_k(base, 0.85), parts)
    for factor in (2, 5, 20, 100):
        yield f"normal stiffness {factor} Ks (10)", station.with_joints(base, normal_stiffness=factor * KS)
    for degrees in (13.0, 17.0):
        law = station.bsm.MohrCoulomb(friction=degrees)
        yield f"joints of {degrees:g} degrees (15)", station.with_joints(base, law=law)
    for weight in (18e3, 22e3):
        yield f"soil of {weight / 1e3:g} kN/m3 (20)", station.with_soil(base, weight)
    for pressure in (48e3, 83e3):
        yield f"P_i = {pressure / 1e3:g} kPa (69)", station.with_pressure(base, pressure)
    yield "rock carries 3.45 MPa of tension (none)", station.with_rock_tension(base, 3.45e6)


def of_the_mesh(base):
    """Yield name and model with zones, joints and boundaries elsewhere."""
    for name, parameters in (
        ("model 60 m wide (92)", {"width": 60.0}),
        ("model 140 m wide (92)", {"width": 140.0}),
        ("15 m below the crown (25)", {"below": 15.0}),
        ("40 m below the crown (25)", {"below": 40.0}),
        *((f"zones and J1 dip {d} (60)", {"dip": d, "cross_dip": d - 90.0}) for d in (50, 55, 65, 70)),
        *((f"J2 dips {abs(d):g} (30)", {"cross_dip": d}) for d in (-20.0, -10.0, 0.0)),
        *((f"J1 {d:g} m apart (2.25)", {"joint_spacing": d}) for d in (1.5, 3.0)),
        *((f"J2 {d:g} m apart (2)", {"cross_spacing": d}) for d in (1.5, 3.0)),
        *((f"zones {d:g} m apart (10)", {"zone_spacing": d}) for d in (6.0, 15.0)),
        *((f"zones {d:g} m wide (1)", {"zone_width": d}) for d in (0.5, 2.0)),
        ("zone 2 m nearer the crown", {"zone_offset": -2.0}),
        ("zone through the upper right corner", {"zone_offset": -4.0}),
        ("zone 2 m further", {"zone_offset": 2.0}),
    ):
        yield name, station.on_layout(base, **parameters)


def of_the_bolts(base):
    """Yield name and model of Case 2 with other bolts."""
    for bond in (150e3, 600e3):
        yield f"bond of {bond / 1e3:g} kN/m (300)", station.with_bolts(base, bond_strength=bond)
    yield "grout of 2 GPa (rigid until it slips)", station.with_bolts(base, bond_stiffness=2e9)
    yield "plates of 200 kN (none)", station.with_bolts(base, plate=200e3)
    for spacing in (1.0, 2.0):
        yield f"{spacing:g} m apart along the station (1.5)", station.with_bolts(base, spacing=spacing)
    yield "every other bolt left out", base.replace(bolts=base.bolts[::2])


def layouts(base):
    """Yield seed and model on layouts drawn from the text's ranges."""
    for seed in SEEDS:
        yield f"seed {seed}", station.on_layout(base, seed=seed)
