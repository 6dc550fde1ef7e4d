"""The page of ``bsm-mesh view`` for polyhedra: the widgets of the plane's page, and a scene that Plotly draws.

Plotly (wheel 9.7 MB, 4.8 MB a page) draws in WebGL with exact depth, colour scales and clicks, without a network. In
2026 trame-vtk (wheel 0.9 MB) showed one state without clicks, and its export needed a VTK render window, which crashes
without X, EGL and OSMesa. Polygons of Bokeh would be sorted by depth, which is wrong where faces differ in size.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bsm_mesh.arrays import FloatArray
from bsm_mesh.errors import ModelError
from bsm_mesh.folder.storage import load_results
from bsm_mesh.pages.view_data import ViewData
from bsm_mesh.pages.view_page import COLOURED, SCRIPTED, call_on_change, column_of, content_of, script_of, side_of
from bsm_mesh.pictures.canvas import FALLS
from bsm_mesh.pictures.space_scene import SpaceScene
from bsm_mesh.pictures.surfaces import Sides

SPACE_SCRIPT = "view_space.js"
OPACITY = 0.3  # of blocks that stay, where something within is to be seen
OUTSIDE = "outer faces"
FAR = 1.25  # distance of the eye, in sizes of the scene
HOW_TO = (
    "Drag to turn, drag with the right button to move, turn the wheel to zoom; a click on a block, joint or bolt shows "
    "its numbers. Forces are those of whole blocks and single bolts; stresses are positive in tension."
)
PAGE = """{% block postamble %}
<style>
  body { margin: 0; } .page { display: flex; height: 97vh; } #scene { flex: 1 1 0; min-width: 0; height: 100%; }
</style>
<script>{{ plotly | safe }}</script>
{% endblock %}
{% block contents %}
<div class="page"><div id="scene"></div>{{ super() }}</div>
{% endblock %}
"""


@dataclass(frozen=True, eq=False, slots=True)
class SpaceView:
    """From where the results of polyhedra are seen.

    Attributes
    ----------
    axes : (3, 3) float64
        Unit vectors to the right, up and ahead.
    cut : bool
        Whether outer faces hide what excavations have bared.
    within : bool
        Whether an excavation or bolts lie within.
    """

    axes: FloatArray
    cut: bool
    within: bool


def view_of_space(out: Path) -> SpaceView:
    """Return the view of polyhedra that the pictures have."""
    scene = SpaceScene(results=load_results(out), number=-1, title="")
    within = scene.cut or any(stage.bolts.count for stage in scene.results.stages)
    return SpaceView(scene.eye.axes, scene.cut, within)


def space_page_of(data: ViewData, heading: str, view: SpaceView) -> str:
    """Return the page as HTML that needs no other file.

    Parameters
    ----------
    data : ViewData
        Content of the page.
    heading : str
        Title of the model and verdict.
    view : SpaceView
        How the scene is seen at first.

    Raises
    ------
    ModelError
        If Bokeh or Plotly is not there.
    """
    try:
        from bokeh.embed import file_html
        from bokeh.resources import INLINE
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise ModelError("view of polyhedra needs Bokeh and Plotly: pip install bokeh plotly") from None
    document, given = _document(data, heading, view), {"plotly": get_plotlyjs()}
    return str(file_html(document, INLINE, title=heading, template=PAGE, template_variables=given))


def _document(data: ViewData, heading: str, view: SpaceView) -> Any:
    from bokeh.document import Document
    from bokeh.models import CustomJS

    kinds = [kind for kind in COLOURED if any(kind in state.layers for state in data.states)]
    side = _side(kinds, data, heading, view)
    parts = {kind: {"by": side[f"{kind}_by"]} for kind in kinds}
    given = {name: side[name] for name in (*SCRIPTED, "opacity")}
    content = {**content_of(data), **_geometry(data, view)}
    args = {**given, "parts": parts, "memory": {}, "falls_source": side["falls"].source, "data": content}
    update = CustomJS(args=args, code=script_of(SPACE_SCRIPT))
    call_on_change(side, update)
    document = Document(title=heading)
    document.add_root(column_of(side))
    document.js_on_event("document_ready", update)
    return document


def _side(kinds: list[str], data: ViewData, heading: str, view: SpaceView) -> dict[str, Any]:
    """Return the widgets of the plane, the choice of outer faces, and the opacity."""
    from bokeh.models import Slider

    side = side_of(kinds, data, heading, HOW_TO)
    hidden = {"joints", *([OUTSIDE] if view.cut else [])}  # joints lie within
    side["shown"].labels = [*kinds, OUTSIDE]
    side["shown"].active = [k for k, name in enumerate((*kinds, OUTSIDE)) if name not in hidden]
    title = "opacity of blocks that stay"
    side["opacity"] = Slider(
        title=title, start=0.0, end=1.0, step=0.02, value=OPACITY if view.within else 1.0, name="opacity"
    )
    last = ("falls", "told", "note")
    return {name: side[name] for name in (*(name for name in side if name not in last), *last)}


def _geometry(data: ViewData, view: SpaceView) -> dict[str, Any]:
    """Return the sides of all blocks as given, and where the eye is."""
    blocks: Any = data.blocks
    sides = Sides(blocks)
    corners, offsets = sides.polygons(np.arange(len(sides.block)))
    return {
        "sides": {
            "corners": (corners - data.middle).astype(np.float32).reshape(-1),
            "offsets": offsets.astype(np.int32),
            "block": sides.block.astype(np.int32),
            "other": sides.other.astype(np.int32),
        },
        "span": blocks.span,
        "eye": dict(zip("xyz", (-FAR * view.axes[2]).tolist(), strict=True)),
        "falls": FALLS,
    }
