"""The page of ``bsm-mesh view``: a Bokeh document with the results in it, and a script that shows them.

Bokeh draws polygons with a colour each in one object and selects each by a click; in Plotly a colour is a trace, and
pydeck has no widgets. The script in the page is 2 MB. WebGL is of no use: in Bokeh it draws no polygons.
"""

from __future__ import annotations

from importlib import resources
from typing import Any

import numpy as np

from bsm_mesh.errors import ModelError
from bsm_mesh.pages.view_data import MOTION, Layer, State, ViewData
from bsm_mesh.pictures.canvas import BOLTS, FALLS, OPENS, SLIPS, WATER
from bsm_mesh.text.exaggeration import exaggeration, factors_up_to, round_factor, size_of

SCRIPT, PLANE_SCRIPT = "view.js", "view_plane.js"  # of both pages; of the plane
KINDS = ("blocks", "joints", "bolts", "water")
COLOURED = KINDS[:3]
VALUED = ("frame", "stage", "factor", "opacity")  # widgets whose value is shown at once
SCRIPTED = ("frame", "stage", "factor", "shown", "told")  # widgets that the script looks at or writes to
PLAIN = "none"  # what is chosen where blocks have no colour
FARTHEST = 0.5  # of the model's size: the greatest movement with the largest factor that can be chosen
MANY = 2000  # blocks; among more of them thick lines hide what is between, and joints alone are their outlines
LINES = {"blocks": (0.6, 0.0), "joints": (2.5, 1.2), "bolts": (4.0, 3.0)}  # pixels, among few and among many blocks
COLOURS = ("#0072B2", "#E69F00", "#CC79A7", "#009E73", "#56B4E9", "#D55E00", "#F0E442", "#999999")  # Okabe and Ito's
HOLDS, SLACK, ABSENT = "#6e6e6e", "#b0b0b0", "#ffffff"
STATES = {"joints": (HOLDS, SLIPS, OPENS), "bolts": (SLACK, BOLTS, SLIPS, FALLS, ABSENT)}  # by status
PAPER = "#efeae0"
SIDE, WIDTH = 340, 300  # pixels: the column beside the plot, and what is in it
FALL_TITLES = {  # of the list of every unstable block: titles, and widths in pixels
    "block": ("block", 40),
    "stage": ("stage", 64),
    "area": ("m2", 56),
    "weight": ("kN/m", 52),
    "x": ("x, m", 44),
    "y": ("y, m", 44),
}
FALL_TITLES_IN_SPACE = {**FALL_TITLES, "area": ("m3", 56), "weight": ("kN", 52), "z": ("z, m", 44)}
HOW_TO = (
    "Drag to move, turn the wheel to zoom; a click on a block, joint or bolt shows its numbers. "
    "Forces are per metre of thickness, those of bolts for one bolt; stresses are positive in tension."
)


def page_of(data: ViewData, heading: str) -> str:
    """Return the page as HTML that needs no other file.

    Parameters
    ----------
    data : ViewData
        Content of the page.
    heading : str
        Title of the model and verdict.

    Raises
    ------
    ModelError
        If Bokeh is not there.
    """
    try:
        from bokeh.embed import file_html
        from bokeh.resources import INLINE
    except ImportError:
        raise ModelError("view needs Bokeh: pip install bokeh") from None
    return str(file_html(_document(data, heading), INLINE, title=heading))


def _document(data: ViewData, heading: str) -> Any:
    from bokeh.document import Document
    from bokeh.layouts import row
    from bokeh.models import CustomJS

    kinds = [kind for kind in KINDS if any(kind in state.layers for state in data.states)]
    plot, parts, marks = _plot(kinds, data)
    side = side_of(kinds, data, heading, HOW_TO)
    for kind in parts:
        if kind in COLOURED:
            parts[kind]["by"] = side[f"{kind}_by"]
    script = script_of(PLANE_SCRIPT)
    given = {**marks, **{name: side[name] for name in SCRIPTED}, "plot": plot, "parts": parts, "memory": {}}
    update = CustomJS(args={**given, "falls_source": side["falls"].source, "data": _content(data)}, code=script)
    call_on_change(side, update)
    for name in ("inner_width", "inner_height"):
        plot.js_on_change(name, update)
    plot.js_on_event("tap", update)
    document = Document(title=heading)
    document.add_root(row(plot, column_of(side), sizing_mode="stretch_both", styles={"height": "97vh"}))
    document.js_on_event("document_ready", update)
    return document


def script_of(name: str) -> str:
    """Return the script of a page: the common part, and that of its drawing."""
    texts = [resources.files("bsm_mesh.pages").joinpath(part).read_text(encoding="utf-8") for part in (SCRIPT, name)]
    return "\n".join(texts)


def call_on_change(side: dict[str, Any], update: Any) -> None:
    """Let every change of a widget call the script."""
    for name, widget in side.items():
        if name in VALUED or name.endswith("_by"):
            widget.js_on_change("value", update)
    side["shown"].js_on_change("active", update)
    side["falls"].source.selected.js_on_change("indices", update)


def column_of(side: dict[str, Any]) -> Any:
    """Return the column of the widgets."""
    from bokeh.layouts import column

    styles = {"overflow": "hidden auto", "padding-left": "8px"}
    return column(*side.values(), width=SIDE, sizing_mode="stretch_height", styles=styles)


def _plot(kinds: list[str], data: ViewData) -> tuple[Any, dict[str, dict[str, Any]], dict[str, Any]]:
    """Return the plot, the glyphs of each kind, and the marks."""
    from bokeh.models import BoxZoomTool, PanTool, Range1d, ResetTool, SaveTool, TapTool, WheelZoomTool
    from bokeh.plotting import figure

    tap, wheel = TapTool(mode="replace"), WheelZoomTool()
    plot = figure(
        sizing_mode="stretch_both",
        tools=[PanTool(), wheel, BoxZoomTool(match_aspect=True), tap, ResetTool(), SaveTool()],
        active_scroll=wheel,
        x_range=Range1d(0, 1),
        y_range=Range1d(0, 1),
        x_axis_label="x, m",
        y_axis_label="y, m",
        lod_threshold=None,  # blocks that vanish while one looks at them would be taken for fallen
        name="plot",
    )
    plot.grid.visible = False
    parts = {kind: _layer(plot, kind, data) if kind in COLOURED else _water(plot) for kind in kinds}
    tap.renderers = [parts[kind]["glyphs"] for kind in kinds if kind in COLOURED]
    return plot, parts, _marks(plot)


def _layer(plot: Any, kind: str, data: ViewData) -> dict[str, Any]:
    """Add the blocks, joints or bolts with their scale of colours."""
    from bokeh.models import ColorBar, ColumnDataSource, FixedTicker, LinearColorMapper

    mapper = LinearColorMapper(palette=["#000000"], low=0, high=1, nan_color="#00000000")
    colour: Any = {"field": "shown", "transform": mapper}
    under: list[Any] = []
    width = LINES[kind][data.blocks.count > MANY]
    if kind == "blocks":
        source = ColumnDataSource(data={"xs": [], "ys": [], "shown": []})
        line = "#4a4a4a" if width else None
        glyphs = plot.patches("xs", "ys", source=source, fill_color=colour, line_color=line, line_width=width)
    elif kind == "joints":
        source = ColumnDataSource(data={"xs": [], "ys": [], "shown": []})
        glyphs = plot.multi_line("xs", "ys", source=source, line_color=colour, line_width=width)
    else:
        source = ColumnDataSource(data={"x0": [], "y0": [], "x1": [], "y1": [], "shown": []})
        under.append(_edges(plot, source, width + 2.0))
        glyphs = plot.segment("x0", "y0", "x1", "y1", source=source, line_color=colour, line_width=width)
    glyphs.nonselection_glyph = glyphs.selection_glyph = None  # what is chosen is marked
    glyphs.name = kind
    bar = ColorBar(
        color_mapper=mapper,
        ticker=FixedTicker(ticks=[]),
        width=12,
        padding=4,
        label_standoff=4,
        title_text_font_style="normal",
    )
    plot.add_layout(bar, "right")
    return {"source": source, "glyphs": glyphs, "under": under, "mapper": mapper, "bar": bar}


def _edges(plot: Any, source: Any, width: float) -> Any:
    """Add dark lines under those of a source, so that they are seen on blocks of their colour."""
    edges = plot.segment("x0", "y0", "x1", "y1", source=source, line_color="#222222", line_width=width)
    edges.nonselection_glyph = edges.selection_glyph = None
    return edges


def _water(plot: Any) -> dict[str, Any]:
    from bokeh.models import ColumnDataSource

    source = ColumnDataSource(data={"x0": [], "y0": [], "x1": [], "y1": []})
    glyphs = plot.segment("x0", "y0", "x1", "y1", source=source, line_color=WATER, line_width=3)
    return {"source": source, "glyphs": glyphs, "under": []}


def _marks(plot: Any) -> dict[str, Any]:
    """Add the outlines of unstable blocks with their numbers, and that of the chosen one."""
    from bokeh.models import ColumnDataSource

    down = ColumnDataSource(data={"xs": [], "ys": [], "x": [], "y": [], "text": []})
    plot.patches("xs", "ys", source=down, fill_alpha=0, line_color=FALLS, line_width=2.5)
    plot.text("x", "y", "text", source=down, text_color=FALLS, text_align="center", text_baseline="middle")
    chosen = ColumnDataSource(data={"xs": [], "ys": []})
    plot.multi_line("xs", "ys", source=chosen, line_color="#ff00c8", line_width=4)
    return {"down": down, "chosen": chosen}


def side_of(kinds: list[str], data: ViewData, heading: str, how_to: str) -> dict[str, Any]:
    """Return the widgets next to the drawing by name, in their order."""
    from bokeh.models import CategoricalSlider, CheckboxButtonGroup, Div, Select, Slider

    states = data.states
    ends = [(str(k), state.frame.label) for k, state in enumerate(states) if state.frame.is_end]
    last = len(states) - 1
    factors = _factors(data)
    out = f"; {data.left_out} steps are left out" if data.left_out else ""
    side: dict[str, Any] = {
        "heading": Div(text=heading, render_as_text=True, styles={"font-weight": "bold"}, width=WIDTH),
        "stage": Select(title="go to the end of", options=ends, value=ends[-1][0] if ends else "0", name="stage"),
        "frame": Slider(
            title="state",
            start=0,
            end=max(last, 1),
            value=last,
            step=1,
            show_value=False,
            visible=last > 0,
            name="frame",
        ),
        "factor": CategoricalSlider(
            title="movements times", categories=[f"{f:g}" for f in factors], value=f"{_usual(data):g}", name="factor"
        ),
        "shown": CheckboxButtonGroup(labels=kinds, active=list(range(len(kinds))), name="shown"),
    }
    for kind in (kind for kind in kinds if kind in COLOURED):
        names = sorted({name for state in states if kind in state.layers for name in state.layers[kind].arrays})
        usual = {"blocks": "displacement", "joints": "status", "bolts": "axial force"}[kind]
        value = usual if usual in names else PLAIN
        side[f"{kind}_by"] = Select(title=f"colour {kind} by", options=[PLAIN, *names], value=value, name=f"{kind}_by")
    side["falls"] = list_of_falls(data)
    side["told"] = Div(text="", name="told", width=WIDTH)
    side["note"] = Div(text=how_to + out, width=WIDTH, styles={"color": "#555", "font-size": "12px"})
    return side


def list_of_falls(data: ViewData) -> Any:
    """Return the table of the unstable blocks; it is not there where none does."""
    from bokeh.models import ColumnDataSource, DataTable, NumberFormatter, StringFormatter, TableColumn

    titles = FALL_TITLES if len(data.middle) == 2 else FALL_TITLES_IN_SPACE
    columns = {name: [row[name] for row in data.falls] for name in titles}
    columns["weight"] = [weight / 1e3 for weight in columns["weight"]]
    for name in ("area", "weight"):  # three digits of each: of a flake of a hand's breadth, too
        columns[name] = [float(f"{value:.3g}") for value in columns[name]]
    size, at, text = NumberFormatter(format="0.[000000]"), NumberFormatter(format="0.[00]"), StringFormatter()
    kinds = {"block": text, "stage": text, "area": size, "weight": size}
    shown = [
        TableColumn(field=name, title=title, formatter=kinds.get(name, at), width=width)
        for name, (title, width) in titles.items()
    ]
    return DataTable(
        source=ColumnDataSource(data=columns),
        columns=shown,
        height=min(26 * (len(data.falls) + 1), 190),
        width=WIDTH,
        index_position=None,
        reorderable=False,  # which takes a library more
        autosize_mode="force_fit",
        visible=bool(data.falls),
        name="falls",
    )


def _greatest(data: ViewData, state: State) -> float:
    """Return the greatest movement of a block that does not fall [m]."""
    arrays, d = state.layers["blocks"].arrays, data.blocks.vertices.shape[1]
    size = np.nan_to_num(np.linalg.norm([arrays[name] for name in MOTION[d][:d]], axis=0))
    size[state.unstable] = 0.0
    return float(size.max())


def _usual(data: ViewData) -> float:
    """Return the factor with which the page opens; true to scale where blocks fall."""
    if data.falls:
        return 1.0
    there = ((state, np.flatnonzero(np.isfinite(state.layers["blocks"].arrays[MOTION[2][0]]))) for state in data.states)
    return min(exaggeration(_greatest(data, state), data.blocks, here) for state, here in there)


def _factors(data: ViewData) -> list[float]:
    greatest = max(_greatest(data, state) for state in data.states)
    farthest = round_factor(FARTHEST * size_of(data.blocks) / greatest) if greatest > 0 else 1.0
    return factors_up_to(max(farthest, _usual(data), 10.0))


def _content(data: ViewData) -> dict[str, Any]:
    """Return the numbers for the script of the plane."""
    blocks = data.blocks
    corners = blocks.vertices - data.middle
    return {
        **content_of(data),
        "x": corners[:, 0].astype(np.float32),
        "y": corners[:, 1].astype(np.float32),
        "offsets": blocks.offsets.astype(np.int32),
    }


def content_of(data: ViewData) -> dict[str, Any]:
    """Return the numbers for the common script; Bokeh writes arrays as they are, in base 64."""
    from bokeh.palettes import Cividis256, Plasma256, Viridis256

    blocks = data.blocks
    centroid = blocks.moments.centroid - data.middle
    return {
        "motion": list(MOTION[len(data.middle)]),
        "centroid": [values.astype(np.float32) for values in centroid.T],
        "bulk": blocks.moments.bulk.astype(np.float32),
        "bulk_name": blocks.bulk_name,
        "bulk_unit": blocks.bulk_unit,
        "rock": blocks.rock.astype(np.int32),
        "rock_names": list(blocks.rock_names),
        "bolt_names": list(data.bolt_names),
        "middle": data.middle.tolist(),
        "units": data.units,
        "names": {kind: {name: list(texts) for name, texts in found.items()} for kind, found in data.names.items()},
        "palettes": {"blocks": list(Viridis256), "joints": list(Plasma256), "bolts": list(Cividis256)},
        "colours": list(COLOURS),
        "states": {kind: list(colours) for kind, colours in STATES.items()},
        "paper": PAPER,
        "frames": [
            {
                "label": state.frame.label,
                "stage": state.frame.stage,
                "unstable": state.unstable,
                **{kind: _numbers(layer) for kind, layer in state.layers.items()},
            }
            for state in data.states
        ],
    }


def _numbers(layer: Layer) -> dict[str, Any]:
    return {
        "arrays": layer.arrays,
        "ends": layer.ends.reshape(-1),
        "moved": layer.moved.reshape(-1),
        "offsets": layer.offsets,
        "which": layer.blocks.reshape(-1),
    }
