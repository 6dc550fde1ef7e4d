"""What the site is made of besides the pages, without Sphinx; `sh bootstrap.sh test` builds it whole."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import bsm_mesh as bsm
from bsm_mesh import converters, geometries
from docs.build import not_named
from docs.site.gallery import gallery, with_files
from docs.site.links import dead_links
from docs.site.reference import reference_pages

ROOT = Path(__file__).parents[2]


def test_whatever_is_public_is_in_the_reference_once() -> None:
    lines = [line for text in reference_pages().values() for line in text.splitlines() if line.startswith(".. auto")]
    for package in (bsm, converters, geometries):
        for name in package.__all__:
            home = "bsm_mesh.model" if name in ("bolt_patterns", "library") else package.__name__
            assert sum(line.endswith(f":: {home}.{name}") for line in lines) == 1, name


def test_the_gallery_shows_every_example_with_a_picture_and_its_model_files() -> None:
    page = gallery(ROOT / "examples")
    folders = [path.parent for path in (ROOT / "examples").glob("*/README.md")]
    assert page.count("{grid-item-card}") == len(folders) > 10
    for folder in folders:
        assert f":link: examples/{folder.name}/README\n" in page
        text = with_files(folder / "README.md")
        for file in folder.glob("*.toml"):
            assert f"{{literalinclude}} {file.name}\n" in text
    pictures = [line.removeprefix(":img-top: ") for line in page.splitlines() if line.startswith(":img-top: ")]
    assert all((ROOT / picture).is_file() for picture in pictures)


def test_a_page_that_no_list_names_is_found(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    for name in ("one", "two", "three"):
        (tmp_path / "docs" / f"{name}.md").touch()
    assert not_named(tmp_path, ["docs/one\nTitle <docs/two>\n"]) == ["docs/three"]


def test_dead_links_of_a_site_are_found(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub" / "b.html").write_text('<h1 id="there">B</h1>', encoding="utf-8")
    (tmp_path / "a.html").write_text(
        '<p id="here"><a href="sub/b.html#there"></a><a href="#here"></a><a href="https://example.org/x"></a>'
        '<a href="sub/b.html#gone"></a><a href="c.html"></a><img src="gone.png"><a href="#nowhere"></a>',
        encoding="utf-8",
    )
    assert dead_links(tmp_path) == [f"a.html: {x}" for x in ("sub/b.html#gone", "c.html", "gone.png", "#nowhere")]


MOST_WORDS = 1200  # of a page, without code and tables made by commands
LONGER = {
    "docs/architecture.md": "a map of the rooms",
    "docs/campaign.md": "a protocol of measurements",
    "docs/experiments/continuation.md": "a protocol of an engine that is gone",
    "docs/experiments/thresholds.md": "tables of settings",
    "docs/glossary.md": "a table of words",
    "docs/where_is.md": "a table of files",
}


def test_pages_are_short() -> None:
    pages = [*ROOT.glob("docs/*.md"), *ROOT.glob("docs/experiments/*.md"), ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
    assert len(pages) > 80
    long = {page.relative_to(ROOT).as_posix() for page in pages if words_of(page) > MOST_WORDS}
    assert long <= set(LONGER)


def words_of(page: Path) -> int:
    """Return the number of words of a page, without code, targets of links and tables that a command makes."""
    text = page.read_text(encoding="utf-8")
    text = re.sub(r"^<!-- (?:numbers|made|counts).*?^<!-- [^>]*end[^>]*-->", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^```.*?^```$|^ {4}.*?$", "", text, flags=re.DOTALL | re.MULTILINE)
    return len(re.sub(r"\]\([^)]*\)", "]", text).split())


NO_EXAMPLE = {  # public names that are given, caught or come out, and functions on files of one's own: why
    "comes out": "JointResponse Kinematics Comparison ContinuumSolution MeshReport Note NoteKind BlockCut JointAccount "
    "Parameter",
    "is part of a name": "GroupKind GroupName Case",
    "is shown by the page of its feature": "Beside Drain Flow FlowChange Grout Well",
    "is a warning": "MeshWarning ResultsWarning",
    "is asked for by its family's example": "EdgeTractions Constant Normal Exponential PowerLaw Heads",
    "needs files, and runs in the pages": "load study back_analysis read_blocks read_mesh convert_meshio compare "
    "read_fractures read_scan_line read_traces joint_sets_of_scan_line read_orientations draw_stereonet "
    "draw_kinematics read_section find_curves fragment_by_joints "
    "write_blocks write_mesh mesh_blocks quarter_blocks close_short_sides name_groups parse_settings case_parameters "
    "OutlineMesher GeometryError stope vaulted_box",
}


def test_whatever_is_public_has_an_example_that_runs() -> None:
    """Doctests run them; here they are there."""
    without = set()
    for package in (bsm, converters, geometries):
        things = {name: getattr(package, name) for name in package.__all__}
        without |= {name for name, thing in things.items() if ">>>" not in text_of(thing)}
    assert without - {name for names in NO_EXAMPLE.values() for name in names.split()} == set()


def text_of(thing: object) -> str:
    """Return the docstring of a thing, of a module those of its content."""
    held = vars(thing).values() if inspect.ismodule(thing) else (thing,)
    return " ".join(str(part.__doc__) for part in held)
