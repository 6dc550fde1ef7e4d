"""``bsm-mesh check``: the quality of the blocks as a table, as a picture, and corrected on request."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh import space
from bsm_mesh.arrays import IntArray
from bsm_mesh.errors import ModelError, counted, placed
from bsm_mesh.folder.results_folder import ResultsFolder
from bsm_mesh.model.blocks import Blocks
from bsm_mesh.model.kinds import in_space
from bsm_mesh.model.model import Model
from bsm_mesh.model.notes import notes_of
from bsm_mesh.model.zones import has_zones
from bsm_mesh.modelfile.build import LoadedModel, inputs_of, load_model_file
from bsm_mesh.modelfile.space_tables import SpaceFile
from bsm_mesh.pictures.figures import paper, save
from bsm_mesh.solve.continuation.time_steps import time_steps_of
from bsm_mesh.solve.linear.readiness import make_ready, solver_faults
from bsm_mesh.solve.zones.scheme import zone_time_steps, zoned
from bsm_mesh.text.flow_given import given_flow, given_rows
from bsm_mesh.text.progress import Progress
from bsm_mesh.text.quality import Thresholds, poor_blocks, quality_rows, quality_summary
from bsm_mesh.text.shaking_given import expected_notes, expected_rows, record_rows
from bsm_mesh.text.space_quality import space_rows, space_summary
from bsm_mesh.text.tables import print_table
from bsm_mesh.text.terminal import say, say_json

SLIVERS = ("tiny", "thin")  # a large block with a short edge is none: snapping corrects it
COLOURS = {  # the last that fits a block colours it
    "many_edged": "#c7b9e0",
    "elongated": "#f2d16b",
    "deeply_concave": "#8fbce6",
    "short_edged": "#f0a35e",
    "thin": "#e5694b",
    "tiny": "#b3242c",
    "without_contact": "#7a3e9d",
    "unsupported": "#4a4a4a",
}
PLAIN = "#e9e5dc"
SIDES = ("west", "east", "south", "north", "bottom")  # of a box, behind which there is rock


@dataclass(frozen=True, slots=True, kw_only=True)
class Repair:
    """Repairs to be made.

    Attributes
    ----------
    file : Path
        VTU file for the repaired blocks.
    snap : float [m]
        Corners nearer than this become one.
    across_joints : bool
        Whether slivers with joints on all sides are merged too.
    """

    file: Path
    snap: float = 0.0
    across_joints: bool = False


def check_model(
    path: Path,
    *,
    as_json: bool = False,
    picture: Path | None = None,
    settings: Sequence[str] = (),
    repair: Repair | None = None,
    scripts: bool = True,
    quiet: bool = False,
) -> None:
    """Validate a model file, print the quality of its blocks, draw and repair them where asked.

    Raises
    ------
    ModelError
        For a model that is not valid.
    """
    limits = Thresholds.parse(settings)
    if repair is not None and not 0 <= repair.snap < np.inf:
        raise ModelError(f"--snap {repair.snap}: must be a length of 0 m or more")
    with Progress(quiet=quiet) as progress:
        loaded = load_model_file(path, progress.report, scripts=scripts, space=True)
        progress.report("contacts")
        if in_space(loaded.model.blocks):
            _refuse_of_the_plane(picture, settings, repair)
            _tell_of_space(loaded, as_json)
            return
        with placed(path.name):
            if has_zones(loaded.model):
                zoned(loaded.model, loaded.options)
            ready = make_ready(loaded.model, loaded.options)
        notes = (*ready.notes, *_free_rigid_faces(loaded.model), *_folder_notes(loaded))
        if any(stage.shaking is not None for stage in loaded.model.stages):
            progress.report("time steps of shaken stages")
        expected = zone_time_steps if has_zones(loaded.model) else time_steps_of
        shaken = expected(ready.model, loaded.options)
        notes += tuple(expected_notes(shaken, loaded.model))
        progress.report("quality of the blocks")
        report = quality_summary(loaded.model, ready.system, limits, loaded.dangling)
    flow = [] if ready.flow is None else given_flow(loaded.model, ready.flow.joints)
    if picture is not None:
        draw_quality(loaded.model.blocks, report, picture, loaded.model.title)
    changes = () if repair is None else _repair(loaded, repair, limits)
    if as_json:
        say_json(
            {
                **report,
                "flow": flow,
                "shaking": [asdict(each) for each in shaken],
                "notes": [*loaded.notes, *notes],
                "changes": changes,
            }
        )
        return
    for line in loaded.mesh_lines:
        say(f"mesh: {line.strip()}")
    rows = [*quality_rows(report), *given_rows(flow), *record_rows(loaded.model.stages), *expected_rows(shaken)]
    print_table(f"{path}: the model is valid", ("", ""), rows, texts=2)
    for note in notes:
        say(f"note: {note}")
    if picture is not None:
        say(f"written: {picture}")
    for change in changes:
        say(f"repair: {change}")
    if repair is not None:
        say(f"written: {repair.file}: the repaired blocks as a mesh (VTU), a cell each; the model file is as it was")
        say(f'to use it: [mesh] file = "{repair.file.name}", blocks = "elements"')


def _refuse_of_the_plane(picture: Path | None, settings: Sequence[str], repair: Repair | None) -> None:
    """Refuse options that polyhedra do not have."""
    for option, given in (("--picture", picture), ("--threshold", settings or None), ("--repair", repair)):
        if given is not None:
            raise ModelError(f"check: {option} is for models of the plane; leave it out")


def _tell_of_space(loaded: LoadedModel, as_json: bool) -> None:
    """Refuse a model of polyhedra that cannot be run, unless it is for key blocks; print the quality of its blocks."""
    notes = [*loaded.notes, *notes_of(loaded.model), *_free_sides(loaded), *_folder_notes(loaded)]
    touching = np.zeros((0, 2), dtype=np.int32)
    if not loaded.model.supports and _asks_for_key_blocks(loaded):
        notes.append("for bsm-mesh key-blocks only: bsm-mesh run needs a [[support]]")
    else:
        with placed(loaded.path.name):
            space.refuse_unready(loaded.model, solver_faults(loaded.options), loaded.options.scheme)
            system = space.BlockSystem(loaded.model)  # refuses contacts, bolts and supports as the run does
            touching = system.touching_pairs
    report = space_summary(loaded.model, touching)
    if as_json:
        say_json({**report, "notes": notes})
        return
    print_table(f"{loaded.path}: the model is valid", ("", ""), space_rows(report), texts=2)
    for note in notes:
        say(f"note: {note}")


def _free_sides(loaded: LoadedModel) -> tuple[str, ...]:
    """Return a note on sides of a box, the top apart, that nothing holds or loads: rock beyond them is missing."""
    if not isinstance(loaded.file, SpaceFile) or loaded.file.mesh.box is None or not loaded.model.supports:
        return ()
    given: list[Any] = [*loaded.model.supports, *loaded.model.loads]
    held = {getattr(part, "boundary", None) for part in given}
    free = [side for side in SIDES if side in loaded.model.blocks.boundaries and side not in held]
    if not free or any(getattr(part, "blocks", None) for part in given):
        return ()
    return (f"no support on these sides of the box: {', '.join(free)}; blocks are free to leave there",)


def _asks_for_key_blocks(loaded: LoadedModel) -> bool:
    file = loaded.file
    return isinstance(file, SpaceFile) and bool(file.excavation or file.slope or file.key_blocks.free)


def _free_rigid_faces(model: Model) -> tuple[str, ...]:
    """Return a note on outer faces of rigid rock without a joint: no run can continue where two meet."""
    blocks = model.blocks
    rigid = np.isin(blocks.rock_names, [rock.name for rock in model.rocks if np.isinf(rock.contact_moduli[0])])
    outer = blocks.outer_edges
    bare = int((rigid[blocks.rock][blocks.owner[outer]] & (blocks.edge_joint[outer] < 0)).sum())
    if not bare or model.default_joint is not None or has_zones(model):
        return ()
    return (
        f"{counted(bare, 'outer face')} of rigid rock without a joint: where two of them meet, a run ends with an "
        "error; give default_joint",
    )


def _folder_notes(loaded: LoadedModel) -> tuple[str, ...]:
    """Return why a run would not write into the model's own folder: no fault of the model, which can go elsewhere."""
    try:
        ResultsFolder(loaded.output_folder).refuse(inputs_of(loaded.file, loaded.path))
    except ModelError as error:
        return (f"to run it give another folder (-o): {error}",)
    return ()


def _repair(loaded: LoadedModel, repair: Repair, limits: Thresholds) -> tuple[str, ...]:
    from bsm_mesh.converters.meshes.block_files import write_polygons
    from bsm_mesh.converters.meshes.repair import repair_blocks

    def slivers(blocks: Blocks) -> IntArray:
        found = poor_blocks(blocks, limits)
        return np.unique(np.concatenate([found[key] for key in SLIVERS]))

    mended = repair_blocks(loaded.model.blocks, slivers, snap=repair.snap, across_joints=repair.across_joints)
    write_polygons(mended.blocks, repair.file)
    return mended.changes or ("nothing to repair",)


def draw_quality(blocks: Blocks, report: dict[str, Any], path: Path, title: str) -> None:
    """Draw the blocks, the poor ones in the colour of their fault, as PNG.

    Raises
    ------
    ModelError
        If the name does not end in ``.png``.
    """
    if path.suffix.lower() != ".png":
        raise ModelError(f"{path}: the picture is a PNG; give a name that ends in .png")
    colour = np.full(blocks.count, PLAIN, dtype="<U7")
    for key, value in COLOURS.items():
        colour[report[key]] = value
    low, high = blocks.vertices.min(axis=0), blocks.vertices.max(axis=0)
    aspect = float(np.clip((high - low)[1] / (high - low)[0], 0.3, 2.0))
    figure = paper((10, 10 * aspect + 1.2))
    from matplotlib.collections import PolyCollection
    from matplotlib.patches import Patch

    axes = figure.add_subplot()
    outlines = np.split(blocks.vertices, blocks.offsets[1:-1])
    width = 0.6 if blocks.count < 5000 else 0.1
    axes.add_collection(PolyCollection(outlines, facecolors=colour, edgecolors="#555555", linewidths=width))
    small = np.unique(np.concatenate([report[key] for key in SLIVERS])).astype(np.int64)  # too small to be seen
    axes.plot(*blocks.moments.centroid[small].T, "o", ms=9, mfc="none", mec=COLOURS["tiny"], mew=1.2)
    margin = 0.02 * (high - low).max()
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin), aspect="equal")
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.set_title(f"{title or path.stem}: {blocks.count} blocks", parse_math=False)  # a $ is a $
    shown = [
        Patch(facecolor=value, edgecolor="#555555", label=f"{key.replace('_', ' ')}: {len(report[key])}")
        for key, value in reversed(COLOURS.items())
        if report[key]
    ]
    figure.legend(handles=shown or [Patch(facecolor=PLAIN, label="no poor block")], loc="outside lower center", ncols=4)
    save(figure, path)
