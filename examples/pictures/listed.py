"""The pictures of the pages, one by one, with what was judged of each."""

from __future__ import annotations

from examples.pictures.drawing import Drawn

FINAL, NEW_LOOK = "final_position", "new look; axes in metres"
EX = "examples"

PICTURES = (
    Drawn(
        target="docs/demo.png",
        models=("demo/unbolted.toml", "demo/model.toml"),
        name="joints_state",
        columns=2,
        window=(-20.0, -6.0, 20.0, 26.0),
        shows="The demo: without bolts the wedge in the roof comes down, with them it stands; joints that slip or open",
        mended="new; stood for a linear tunnel in which nothing can fail",
    ),
    Drawn(
        target="docs/thrust.png",
        models=("demo/model.toml",),
        name="thrust",
        shows="The demo: the forces go round the cavern from block to block",
        mended="new",
    ),
    Drawn(
        target="docs/method.png",
        script="examples/pictures/method.py",
        shows="The method: rigid blocks, springs at the contacts, the law of a joint",
        mended="new",
    ),
    Drawn(
        target="docs/tutorial_unbolted.png",
        models=("tutorial/cutting.toml",),
        name=FINAL,
        window=(-12.0, -8.0, 32.0, 16.0),
        shows="The road cutting of the tutorial without bolts: what slides on the bedding",
        mended="new",
    ),
    Drawn(
        target="docs/tutorial_bolted.png",
        models=("tutorial/bolted.toml",),
        name="joints_state",
        window=(-12.0, -8.0, 32.0, 16.0),
        shows="The bolted cutting: which joints stick, slip and are open",
        mended="new",
    ),
    Drawn(
        target="docs/safety.png",
        elsewhere="bsm-mesh safety",
        shows="Joints in the last stable state of the slope, blocks that fail in the first unstable one",
        mended="drawn as every other picture: colours that all eyes tell apart, shares, supports, a key",
    ),
    Drawn(
        target=f"{EX}/01_circular_tunnel/stresses.png",
        models=(f"{EX}/01_circular_tunnel/model.toml",),
        name="principal_stresses",
        shows="Principal stresses round half a tunnel, as Wang Fig. 3.18",
        mended=f"{NEW_LOOK}; 700 crosses for 1100 that touched; paper as narrow as the model",
    ),
    Drawn(
        target=f"{EX}/01_circular_tunnel/section.png",
        elsewhere=f"{EX}/01_circular_tunnel/section.py",
        shows="Stresses on section I-I by blocks, finite elements and Kirsch",
    ),
    Drawn(
        target=f"{EX}/02_pushed_block/final_position.png",
        models=(f"{EX}/02_pushed_block/model.toml", f"{EX}/02_pushed_block/apart.toml"),
        name=FINAL,
        columns=2,
        shows="The block that comes to rest against the next one, and the one that falls",
        mended=f"{NEW_LOOK}; the block is named; what falls is followed beyond the model's box",
    ),
    Drawn(
        target=f"{EX}/03_stratified_slope/movement.gif",
        models=(f"{EX}/03_stratified_slope/model.toml",),
        name="movement.gif",
        shows="The layers slide to the toe",
        mended=NEW_LOOK,
    ),
    Drawn(
        target=f"{EX}/03_stratified_slope/intermediate.png",
        models=(f"{EX}/03_stratified_slope/model.toml",),
        name="step 28",
        shows="Step 28 on the way",
        mended=NEW_LOOK,
    ),
    Drawn(
        target=f"{EX}/03_stratified_slope/final_position.png",
        models=(f"{EX}/03_stratified_slope/model.toml",),
        name=FINAL,
        shows="The layers at the toe",
        mended=f"{NEW_LOOK}; says that they rest after moving far",
    ),
    Drawn(
        target=f"{EX}/03_stratified_slope/floor.png",
        models=(f"{EX}/03_stratified_slope/floor.toml",),
        name=FINAL,
        shows="The layers at rest on a floor",
        mended="new",
    ),
    Drawn(
        target=f"{EX}/04_bolted_opening/final_position.png",
        models=tuple(f"{EX}/04_bolted_opening/{name}.toml" for name in ("unbolted", "roof_bolt", "two_bolts", "model")),
        name=FINAL,
        columns=2,
        shows="Four steps: no bolt, roof, roof and wall, all three; what comes down",
        mended=f"{NEW_LOOK}; falling blocks ringed and named with area and weight",
    ),
    Drawn(
        target=f"{EX}/04_bolted_opening/thick_displacement.png",
        models=tuple(f"{EX}/04_bolted_opening/{name}.toml" for name in ("thick_two_bolts", "thick")),
        name="displacement_arrows",
        columns=2,
        shows="A filling of 3 mm: the corner block comes into the opening, and does not with a bolt of its own",
        mended="new",
    ),
    Drawn(
        target=f"{EX}/04_bolted_opening/bolt_forces.png",
        models=(f"{EX}/04_bolted_opening/model.toml",),
        name="bolt_forces",
        shows="Axial and bond force along the three bolts, support pressure",
    ),
    Drawn(
        target=f"{EX}/05_dam_foundation/deformation.png",
        models=(f"{EX}/05_dam_foundation/slip.toml",),
        name="deformation",
        shows="The dam under its weight and a full reservoir, exaggerated, as Wang Fig. 6.10",
        mended=f"{NEW_LOOK}; the exaggeration is tied to the free space, and said; the toe rises",
    ),
    Drawn(
        target=f"{EX}/05_dam_foundation/displacement_arrows.png",
        models=(f"{EX}/05_dam_foundation/slip.toml",),
        name="displacement_arrows",
        shows="Displacements, as Wang Fig. 6.9",
        mended=NEW_LOOK,
    ),
    Drawn(
        target=f"{EX}/arch/final_position.png",
        models=(f"{EX}/arch/thin.toml",),
        name=FINAL,
        shows="The arch that is too thin, over where it was given",
        mended=f"{NEW_LOOK}; no ring round half the picture, but a name",
    ),
    Drawn(
        target=f"{EX}/cassiar_slope/section.png",
        elsewhere=f"{EX}/cassiar_slope/figures.py",
        shows="The section, its water tables, the movement under high water",
    ),
    Drawn(
        target=f"{EX}/cassiar_slope/groundwater.png",
        elsewhere=f"{EX}/cassiar_slope/figures.py",
        shows="Displacement of seven points against the groundwater",
    ),
    Drawn(
        target=f"{EX}/cassiar_slope/histories.png",
        models=(f"{EX}/cassiar_slope/model.toml",),
        name="histories",
        shows="The seven points of Wang Fig. 8.19 while the water rises, from `[[history]]`",
        mended="new; gravity's movement before the first stage is no jump in it; the key keeps clear of the axis",
    ),
    Drawn(
        target=f"{EX}/dupont_station/extensions.png",
        models=(f"{EX}/dupont_station/model.toml", f"{EX}/dupont_station/bolts.toml"),
        name="extensometers",
        shows="Extensions of four lines, as Wang Figs. 8.10 and 8.12, from `[[history]]`: Case 1, Case 2",
        mended="new",
    ),
    *(
        Drawn(target=f"{EX}/dupont_station/{name}.png", elsewhere=f"{EX}/dupont_station/figures.py", shows=shows)
        for name, shows in (
            ("mesh", "Mesh, bolts and extensometers"),
            ("vectors", "Displacement of blocks and finite elements"),
            ("settlement", "Settlement of the top of rock, computed and measured"),
            ("extensometers", "Movement along four lines"),
            ("bolts", "Forces in the bolts"),
        )
    ),
    Drawn(
        target=f"{EX}/falling_table/final_position.png",
        models=(f"{EX}/falling_table/rapid.toml",),
        name=FINAL,
        shows="The wedge after the rapid drawdown",
        mended=f"{NEW_LOOK}; the wedge is ringed and named",
    ),
    Drawn(
        target=f"{EX}/incline/final_position.png",
        models=(f"{EX}/incline/tall_slides.toml",),
        name=FINAL,
        shows="The tall block that slides, upright",
        mended=NEW_LOOK,
    ),
    Drawn(
        target=f"{EX}/rough_joint/joint_shear.png",
        elsewhere="bsm-mesh joint-test",
        shows="Direct shear of the joint under three normal stresses",
    ),
    Drawn(
        target="docs/joint_laws.png",
        elsewhere="python -m examples.numbers joint-laws",
        shows="Strength, shear and closure: formulas and what the bench finds",
    ),
    Drawn(
        target="docs/verification.png",
        elsewhere="python -m verification verification-convergence",
        shows="Errors over the number of blocks: Kirsch's hole, triangles as elastic rock",
    ),
    Drawn(
        target=f"{EX}/staged_tunnel/deformation.png",
        models=(f"{EX}/staged_tunnel/model.toml",),
        name="deformation",
        shows="Deformation after the invert",
        mended=f"{NEW_LOOK}; it looked as if the tunnel closed: exaggeration is tied to the opening",
    ),
    Drawn(
        target=f"{EX}/staged_tunnel/weak.png",
        models=(f"{EX}/staged_tunnel/weak.toml",),
        name=FINAL,
        shows="Weak joints: a block comes down with the bench",
        mended=f"{NEW_LOOK}; the block, which was lost among 600, is ringed and named",
    ),
    Drawn(
        target=f"{EX}/tilted_wall/final_position.png",
        models=(f"{EX}/tilted_wall/tilt_28.toml",),
        name=FINAL,
        shows="The wall at 28 degrees, over where it was given",
        mended=NEW_LOOK,
    ),
    Drawn(
        target=f"{EX}/toppling_column/movement.gif",
        models=(f"{EX}/toppling_column/steeper.toml",),
        name="movement.gif",
        shows="The column that falls",
        mended=NEW_LOOK,
    ),
    Drawn(
        target=f"{EX}/toppling_column/final_position.png",
        models=(f"{EX}/toppling_column/steeper.toml",),
        name=FINAL,
        shows="The column that falls, over where it was given",
        mended=f"{NEW_LOOK}; its parts that leave the model's box are followed",
    ),
    Drawn(
        target=f"{EX}/uncertain_slope/scatter.png",
        elsewhere="bsm-mesh study",
        shows="Share of runs that fail along each key",
    ),
)
