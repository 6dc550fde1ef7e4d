"""Dead links of a site: to pages, files and headings that are not there. None is followed into the net."""

from __future__ import annotations

import re
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

OF_SPHINX = {"genindex.html", "search.html", "py-modindex.html"}


class Page(HTMLParser):
    """What a page holds: its anchors, and where its links and pictures lead."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: set[str] = set()
        self.targets: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take what a tag says."""
        given = dict(attrs)
        self.anchors |= {value for name in ("id", "name") if (value := given.get(name))}
        if tag in ("a", "img", "link", "script"):
            self.targets += [value for name in ("href", "src") if (value := given.get(name)) and value != "#"]


@cache
def page_of(path: Path) -> Page:
    """Return what a page holds."""
    return Page(path.read_text(encoding="utf-8"))


def dead_links(site: Path) -> list[str]:
    """Return a line for every link of a site that leads nowhere."""
    page_of.cache_clear()
    return [
        f"{page.relative_to(site)}: {target}"
        for page in sorted(site.rglob("*.html"))
        if "_static" not in page.parts
        for target in dict.fromkeys(page_of(page).targets)
        if not re.match(r"[a-z]+:|//", target) and not leads(page, target)
    ]


def leads(page: Path, target: str) -> bool:
    """Return whether a link of a page leads somewhere."""
    path, _, anchor = target.partition("#")
    place = (page.parent / unquote(path.partition("?")[0])).resolve() if path else page
    if not place.exists():
        return False
    return not anchor or place.suffix != ".html" or place.name in OF_SPHINX or unquote(anchor) in page_of(place).anchors
