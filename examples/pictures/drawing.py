"""How a picture of a page is drawn: run, drawn, joined with others, put in its place."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path

from PIL import Image

from examples.numbers.pages import markdown
from examples.numbers.tutorial import write_files

ROOT = Path(__file__).parents[2]
WIDEST, COLOURS = 2000, 255  # pixels; both keep the files small
Window = tuple[float, float, float, float]


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """A picture of the pages.

    Attributes
    ----------
    target : str
        The file, relative to the checkout.
    models : tuple of str
        A panel each: a model file relative to the checkout, ``demo/NAME`` of the starter cavern, ``starter/CASE/NAME``
        of another starter, ``tutorial/NAME`` of the files of docs/tutorial.md, ``cassiar/NAME`` of the slope under
        other water, or ``module:function`` that returns results.
    name : str
        The picture, as `bsm-mesh plot --only` knows it; ``movement.gif``, or ``step N``.
    stages : tuple of str
        Stages of every model, by number or name; a panel each.
    columns : int
        In how many columns several panels stand.
    window : (x0, y0, x1, y1), optional [m]
        The visible part.
    beside : tuple of (name, model)
        The values compared with the histories, models as above.
    script : str
        What draws it instead, relative to the checkout.
    elsewhere : str
        The command that draws it; it is only listed here.
    shows, mended : str
        The visible part, and what was corrected when it was judged.
    """

    target: str
    models: tuple[str, ...] = ()
    name: str = ""
    stages: tuple[str, ...] = ("-1",)
    columns: int = 1
    window: Window | None = None
    beside: tuple[tuple[str, str], ...] = ()
    script: str = ""
    elsewhere: str = ""
    shows: str
    mended: str = ""


def draw(picture: Drawn, folder: Path) -> None:
    """Draw a picture and put it in its place; runs lie in `folder`."""
    if picture.elsewhere:
        return
    if picture.script:
        subprocess.run([sys.executable, picture.script], cwd=ROOT, check=True)
        return
    panels = [
        _panel(picture, _results(model, folder), stage, folder) for model in picture.models for stage in picture.stages
    ]
    target = ROOT / picture.target
    if target.suffix == ".gif":
        target.write_bytes(panels[0].read_bytes())
        return
    _joined(panels, picture.columns).save(target, optimize=True)


@cache
def _results(model: str, folder: Path) -> Path:
    """Return the results folder of a model."""
    out = folder / model.replace("/", "_").replace(":", "_").removesuffix(".toml")
    if ":" in model:
        module, _, function = model.partition(":")
        getattr(import_module(module), function)().save(out)
        return out
    path = ROOT / model
    if model.startswith("demo/"):
        path = _demo(folder) / model.removeprefix("demo/")
    if model.startswith("starter/"):
        path = _starter(model.split("/")[1], folder) / model.split("/", 2)[2]
    if model.startswith("tutorial/"):
        path = _tutorial(folder) / model.removeprefix("tutorial/")
    if model.startswith("cassiar/"):
        path = _cassiar(folder) / model.removeprefix("cassiar/")
    _command("run", str(path), "-q", "-o", str(out))
    return out


@cache
def _demo(folder: Path) -> Path:
    """Return the folder with both models of the demo."""
    from bsm_mesh.commands.demo import MODEL, UNBOLTED, without_bolts

    case = _starter("cavern", folder)
    (case / UNBOLTED).write_text(without_bolts((case / MODEL).read_text(encoding="utf-8")), encoding="utf-8")
    return case


@cache
def _starter(name: str, folder: Path) -> Path:
    """Return the folder of a starter that `bsm-mesh new` writes."""
    from bsm_mesh.commands.starters import write_starter

    case = folder / f"starter_{name}"
    write_starter(name, case)
    return case


@cache
def _tutorial(folder: Path) -> Path:
    """Return the folder with the files of the tutorial."""
    case = folder / "tutorial"
    case.mkdir()
    write_files(case)
    return case


@cache
def _cassiar(folder: Path) -> Path:
    """Return the folder with the Cassiar slope from zero stress under each water table, and under rising water."""
    from examples.cassiar_slope.slope import write_from_zero_stress

    case = folder / "cassiar"
    case.mkdir()
    write_from_zero_stress(case)
    return case


def _panel(picture: Drawn, results: Path, stage: str, folder: Path) -> Path:
    """Draw one panel and return its file."""
    if picture.name == "movement.gif":
        asked = ["--animate"]
    elif picture.name.startswith("step "):
        asked = ["--step", picture.name.removeprefix("step ")]
    else:
        asked = ["--stage", stage, "--only", picture.name]
        asked += [] if picture.window is None else ["--window", *(f"{each:g}" for each in picture.window)]
        for name, model in picture.beside:
            asked += ["--with", f"{name}={_results(model, folder)}"]
    drawn = _command("plot", str(results), *asked)
    return Path(drawn.strip().splitlines()[-1])


def _command(*arguments: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "bsm_mesh", *arguments], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if done.returncode not in (0, 3):
        raise RuntimeError(done.stderr)
    return done.stdout


def _joined(panels: Sequence[Path], columns: int) -> Image.Image:
    """Return pictures side by side, no wider than pages show, in as few colours as the eye tells apart."""
    images = [Image.open(panel).convert("RGB") for panel in panels]
    rows = -(-len(images) // columns)
    width, height = max(image.width for image in images), max(image.height for image in images)
    whole = Image.new("RGB", (columns * width, rows * height), "white")
    for number, image in enumerate(images):
        whole.paste(image, (number % columns * width, number // columns * height))
    if whole.width > WIDEST:
        whole = whole.resize((WIDEST, round(whole.height * WIDEST / whole.width)), Image.Resampling.LANCZOS)
    return whole.quantize(
        COLOURS, method=Image.Quantize.MAXCOVERAGE, kmeans=4, dither=Image.Dither.NONE
    )  # thin lines too


def table(pictures: Sequence[Drawn]) -> str:
    """Return the table of the page: every picture, what it shows, what was corrected."""
    rows = []
    for picture in pictures:
        with Image.open(ROOT / picture.target) as image:
            size = f"{image.width} x {image.height}"
        how = picture.script or picture.elsewhere
        how = f"`{how}`" if how else f"`{picture.name}` of {_models(picture)}"
        rows.append((f"[{picture.target}](../{picture.target})", how, size, picture.shows, picture.mended or "nothing"))
    return markdown(("picture", "drawn by", "pixels", "shows", "corrected"), rows)


def _models(picture: Drawn) -> str:
    models = ", ".join(model.removeprefix("examples/") for model in picture.models)
    return models if picture.stages == ("-1",) else f"{models}, stages {', '.join(picture.stages)}"
