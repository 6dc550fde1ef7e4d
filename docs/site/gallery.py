"""The gallery of the examples, made of their folders: pictures, model files, and the table of `examples/README.md`."""

from __future__ import annotations

import re
from pathlib import Path

ROW = re.compile(r"^\| \[(?P<name>\w+)\]\(\w+/README\.md\) \| (?P<shows>.+) \|$", re.MULTILINE)
PICTURE = re.compile(r"!\[[^]]*\]\((?P<path>[^)]+\.(?:png|gif))\)")
HEAD = """# Gallery

Every example is a folder with its model files, a page with the problem, its source and its numbers,
and a test that runs it. Each page shows its model files at its end.

::::{grid} 1 2 3 3
:gutter: 3

"""
END = """::::

```{{toctree}}
:hidden:

{pages}
docs/dupont_station
docs/cassiar_slope
```
"""
CARD = """:::{{grid-item-card}} {title}
:img-top: {picture}
:link: examples/{name}/README
:link-type: doc

{shows}
:::

"""
FILE = """:::{{dropdown}} {name}
{{download}}`download <{name}>`

```{{literalinclude}} {name}
:language: {language}
```
:::

"""


def gallery(examples: Path) -> str:
    """Return the page of the gallery.

    Raises
    ------
    ValueError
        If an example is not in the table, or has no picture.
    """
    rows = {row["name"]: row["shows"] for row in ROW.finditer((examples / "README.md").read_text(encoding="utf-8"))}
    folders = {page.parent.name for page in examples.glob("*/README.md")}
    if folders != set(rows):
        raise ValueError(f"examples/README.md: its table and the folders differ: {sorted(folders ^ set(rows))}")
    pages = "\n".join(f"examples/{name}/README" for name in rows)
    return f"{HEAD}{''.join(card(examples, name, shows) for name, shows in rows.items())}{END.format(pages=pages)}"


def card(examples: Path, name: str, shows: str) -> str:
    """Return the card of an example."""
    text = (examples / name / "README.md").read_text(encoding="utf-8")
    picture = PICTURE.search(text)
    if picture is None:
        raise ValueError(f"examples/{name}/README.md shows no picture")
    title = text.splitlines()[0].lstrip("# ")
    return CARD.format(title=title, name=name, shows=shows, picture=f"examples/{name}/{picture['path']}")


def with_files(page: Path) -> str:
    """Return the page of an example with its model files and scripts at the end."""
    files = [*sorted(page.parent.glob("*.toml")), *sorted(page.parent.glob("*.py"))]
    languages = {".toml": "toml", ".py": "python"}
    shown = "".join(FILE.format(name=path.name, language=languages[path.suffix]) for path in files)
    return f"{page.read_text(encoding='utf-8').rstrip()}\n\n## Files\n\n{shown}"
