"""The reference of the Python interface, from the docstrings of what is public."""

from __future__ import annotations

import inspect
from importlib import import_module

# Pages, their titles, and their content in this order. A name without a dot is one of `bsm_mesh`.
PAGES: dict[str, tuple[str, str]] = {
    "running": (
        "Load, run, judge",
        """load run spread Options Falls limit_analysis factor_of_safety limit_value back_analysis newmark Failure
        Measured study ModelError MeshWarning ResultsWarning""",
    ),
    "model": (
        "Model",
        """Model Blocks Rock Joint Filling Fixed Roller NormalRoller PrescribedDisplacement PointLoad Pressure Traction
        EarthPressure EdgeTractions InSituTraction InSitu Water Bolt Stage History""",
    ),
    "laws": ("Joint laws", "Patton MohrCoulomb JointResponse bsm_mesh.model.joint_laws.JointLaw"),
    "results": (
        "Results",
        """Results liner_forces bsm_mesh.results.liner.LinerForces bsm_mesh.results.liner.Capacity
        bsm_mesh.results.records.StageResult bsm_mesh.results.records.ContactForces
        bsm_mesh.results.records.SupportForces bsm_mesh.results.records.StepRecord bsm_mesh.results.records.Status
        bsm_mesh.results.bolts.BoltForces bsm_mesh.results.check.Check bsm_mesh.results.falls.Fall
        bsm_mesh.solve.limit.analysis.LimitAnalysis bsm_mesh.safety.answer.Safety
        bsm_mesh.safety.measurements.BackAnalysis bsm_mesh.safety.earthquake.Newmark
        bsm_mesh.commands.study.StudyResults""",
    ),
    "three_d": (
        "Three dimensions: blocks and key blocks",
        """Polyhedra key_blocks bsm_mesh.three_d.key_blocks.record.KeyBlocks
        bsm_mesh.three_d.blocks.contact_polygons.ContactPolygons
        bsm_mesh.three_d.blocks.contact_polygons.ContactPoints bsm_mesh.three_d.blocks.moments.Moments
        bsm_mesh.three_d.blocks.polygons.PolygonMoments""",
    ),
    "libraries": ("Bolt patterns, published rocks and joints", "bolt_patterns library"),
}
PACKAGES = {
    "converters": ("Meshes and finite elements: converters", "bsm_mesh.converters"),
    "geometries": ("Geometries: joint sets, rock masses, Gmsh", "bsm_mesh.geometries"),
    "three_d_geometries": ("Rock in three dimensions: joints, bodies, cutting", "bsm_mesh.geometries.three_d"),
    "three_d_files": ("Three dimensions: VTU files and pictures", "bsm_mesh.converters.three_d"),
}
MEMBERS = "   :members:\n   :inherited-members: {bases}\n"
BASES = (
    "object, Portable, Protocol, Generic, ValueError, UserWarning, Exception, BaseException, int, str, IntEnum, StrEnum"
)


def entry(path: str) -> str:
    """Return the directive that shows something public."""
    home, _, name = path.rpartition(".")
    thing = getattr(import_module(home), name)
    if inspect.ismodule(thing):
        return f".. automodule:: {thing.__name__}\n   :members:\n"
    if inspect.isclass(thing):
        return f".. autoclass:: {path}\n{MEMBERS.format(bases=BASES)}"
    return f".. autofunction:: {path}\n" if callable(thing) else f".. autodata:: {path}\n"


def page(title: str, paths: list[str]) -> str:
    """Return a page of the reference."""
    entries = "\n".join(entry(path) for path in paths)
    return f"# {title}\n\n```{{eval-rst}}\n{entries}```\n"


def reference_pages() -> dict[str, str]:
    """Return the pages of the reference by their names; what is public and on no page is on one of its own."""
    import bsm_mesh

    pages = {}
    for name, (title, names) in PAGES.items():
        pages[name] = page(title, [path if "." in path else f"bsm_mesh.{path}" for path in names.split()])
    shown = {path for _, names in PAGES.values() for path in names.split()}
    if more := sorted(set(bsm_mesh.__all__) - shown):
        pages["more"] = page("Further names", [f"bsm_mesh.{name}" for name in more])
    for name, (title, package) in PACKAGES.items():
        pages[name] = page(title, [f"{package}.{public}" for public in import_module(package).__all__])
    return pages
