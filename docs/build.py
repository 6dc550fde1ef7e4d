"""Make the documentation a site: ``python -m docs.build [-o FOLDER]``; every warning and every dead link is an error.

The pages are read where they are, as Markdown in the repository. A copy with the same folders gets the pages that are
made here: the gallery of examples, with their pictures and model files, and the reference of the Python interface.

Sphinx with myst-parser: MkDocs is no longer maintained. `docs/` holds no directive, so that the pages are read in the
repository as they are.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from docs.site.gallery import gallery, with_files
from docs.site.links import dead_links
from docs.site.reference import reference_pages

ROOT = Path(__file__).parents[1]
SITE = ROOT / "docs" / "site"
MADE = ROOT / "build" / "docs"
COPIED = ("*.md", "*.cff", "LICENSE", "pyproject.toml", "bootstrap.sh", "constraints*.txt", ".ci/run")
FOLDERS = ("docs", "examples", "bsm_mesh", "geometries", "converters", "tests", "benchmarks", "tools", "verification")
KINDS = {".md", ".png", ".gif", ".toml", ".py", ".csv", ".json", ".html", ".j2", ".ipynb"}
LEFT_OUT = {"__pycache__", "site", "out"}


def stage(source: Path) -> None:
    """Copy what pages are made of and lead to, and add what is made here."""
    shutil.rmtree(source, ignore_errors=True)
    for pattern in COPIED:
        for path in ROOT.glob(pattern):
            copy(path, source)
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*")):
            parts = path.relative_to(ROOT).parts
            if path.suffix in KINDS and not LEFT_OUT & set(parts) and not linked(path):
                copy(path, source)
    for page in sorted((source / "examples").glob("*/README.md")):
        page.write_text(with_files(page), encoding="utf-8")
    write(source / "gallery.md", gallery(source / "examples"))
    reference = reference_pages()
    for name, text in reference.items():
        write(source / "reference" / f"{name}.md", text)
    lists = [list_of_folder(page) for page in sorted((source / "docs").glob("*/README.md"))]
    pages = {page.name: page.read_text(encoding="utf-8") for page in SITE.glob("*.md")}
    listed = "\n".join(f"reference/{name}" for name in reference)
    others = "\n".join(
        not_named(source, [*pages.values(), *lists, listed, (source / "gallery.md").read_text(encoding="utf-8")])
    )
    for name, text in pages.items():
        write(source / name, text.replace("REFERENCE", listed).replace("MORE", others))


def list_of_folder(page: Path) -> str:
    """Let the README of a folder of pages lead to the others in it, in their order; return their names."""
    names = [other.stem for other in sorted(page.parent.glob("*.md")) if other != page]
    hidden = "\n".join(["```{toctree}", ":hidden:", "", *names, "```", ""])
    write(page, f"{page.read_text(encoding='utf-8').rstrip()}\n\n{hidden}")
    return "\n".join(f"docs/{page.parent.name}/{name}" for name in names)


def linked(path: Path) -> bool:
    """Return whether a link on the way leads to a folder that is copied by itself (`bsm_mesh/geometries`)."""
    return any(place.is_symlink() for place in path.relative_to(ROOT).parents if place != Path())


def copy(path: Path, source: Path) -> None:
    """Copy a file of the checkout to where it is there."""
    target = source / path.relative_to(ROOT)
    target.parent.mkdir(parents=True, exist_ok=True)
    shutil.copy(path, target)


def write(path: Path, text: str) -> None:
    """Write a page that is made here."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def not_named(source: Path, lists: list[str]) -> list[str]:
    """Return the pages that no list names, so that a new one is found all the same."""
    named = {word.strip("<>") for text in lists for word in text.split()}
    pages = [page.relative_to(source).with_suffix("").as_posix() for page in sorted(source.rglob("*.md"))]
    return [name for name in pages if name not in named and name != "gallery"]


def main() -> int:
    """Build the site and check its links."""
    parser = argparse.ArgumentParser(prog="python -m docs.build", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, default=MADE / "html", help="folder of the site")
    output = parser.parse_args().output
    try:
        from sphinx.cmd.build import main as sphinx
    except ImportError:
        print("Sphinx is not installed: sh bootstrap.sh docs, or pip install '.[docs]'", file=sys.stderr)
        return 2
    source = MADE / "source"
    stage(source)
    shutil.rmtree(output, ignore_errors=True)
    trees = ("-d", str(MADE / "doctrees"))
    code = sphinx(["-b", "html", "-W", "--keep-going", "-q", "-E", "-c", str(SITE), *trees, str(source), str(output)])
    dead = dead_links(output)
    for line in dead:
        print(line, file=sys.stderr)
    pages = len(list(output.rglob("*.html")))
    print(f"{output / 'index.html'}: {pages} pages, {len(dead)} dead links, warnings: {'some' if code else 'none'}")
    return 1 if code or dead else 0


if __name__ == "__main__":
    sys.exit(main())
