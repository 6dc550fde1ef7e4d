"""Dead links of a site: to pages, files and headings that are not there. None is followed into the net."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from urllib.parse import unquote

OF_SPHINX = {"genindex.html", "search.html", "py-modindex.html"}


@cache
def soup_of(page: Path) -> tuple[frozenset[str], tuple[str, ...]]:
    """Return the anchors of a page, and where its links and pictures lead."""
    from bs4 import BeautifulSoup

    soup = BeautifulSoup(page.read_text(encoding="utf-8"), "html.parser")
    anchors = frozenset(str(tag[name]) for name in ("id", "name") for tag in soup.find_all(attrs={name: True}))
    targets = [str(tag.get("href") or tag.get("src")) for tag in soup.find_all(["a", "img", "link", "script"])]
    return anchors, tuple(target for target in targets if target not in ("None", "", "#"))


def dead_links(site: Path) -> list[str]:
    """Return a line for every link of a site that leads nowhere."""
    soup_of.cache_clear()
    return [
        f"{page.relative_to(site)}: {target}"
        for page in sorted(site.rglob("*.html"))
        if "_static" not in page.parts
        for target in dict.fromkeys(soup_of(page)[1])
        if not re.match(r"[a-z]+:|//", target) and not leads(page, target)
    ]


def leads(page: Path, target: str) -> bool:
    """Return whether a link of a page leads somewhere."""
    path, _, anchor = target.partition("#")
    place = (page.parent / unquote(path.partition("?")[0])).resolve() if path else page
    if not place.exists():
        return False
    return not anchor or place.suffix != ".html" or place.name in OF_SPHINX or unquote(anchor) in soup_of(place)[0]
