"""The pictures of laboratory tests: shear, closure, a bolt."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bsm_mesh.arrays import FloatArray
from bsm_mesh.joint_test import BoltCurve, JointCurve
from bsm_mesh.pictures.beside_marks import COLOURS
from bsm_mesh.pictures.canvas import WIDTH
from bsm_mesh.pictures.figures import paper, save
from bsm_mesh.text.tables import engineering

HEIGHT = 5.5  # inches


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Laboratory:
    """A curve that was measured: displacement (k,) [m], shear stress (k,) [Pa]."""

    name: str
    displacement: FloatArray
    shear_stress: FloatArray


def draw_shear(curves: Mapping[float, JointCurve], measured: Sequence[Laboratory], title: str, path: Path) -> None:
    """Draw shear stress over shear displacement, a line a normal stress, and curves of the laboratory as points."""
    with _chart(f"{title}: direct shear", path) as axes:
        for colour, (stress, curve) in zip(_colours(len(curves)), curves.items(), strict=True):
            label = f"normal stress {engineering(stress, 'Pa')}"
            axes.plot(1e3 * curve.shear_displacement, 1e-6 * curve.shear_stress, color=colour, label=label)
        for marker, one in zip("osD^v" * len(measured), measured, strict=False):
            axes.plot(1e3 * one.displacement, 1e-6 * one.shear_stress, marker, color="black", markersize=4,
                      fillstyle="none", label=f"laboratory: {one.name}".replace("$", r"\$"))  # fmt: skip
        axes.set_xlabel("shear displacement, mm")
        axes.set_ylabel("shear stress, MPa")


def draw_opening(curves: Mapping[float, JointCurve], title: str, path: Path) -> None:
    """Draw by how much a joint that dilates has opened since the shear began, a line a normal stress."""
    with _chart(f"{title}: dilation", path) as axes:
        for colour, (stress, curve) in zip(_colours(len(curves)), curves.items(), strict=True):
            label = f"normal stress {engineering(stress, 'Pa')}"
            opening = curve.closure[0] - curve.closure
            axes.plot(1e3 * curve.shear_displacement, 1e3 * opening, color=colour, label=label)
        axes.set_xlabel("shear displacement, mm")
        axes.set_ylabel("opening, mm")


def draw_closure(curve: JointCurve, title: str, path: Path) -> None:
    """Draw the normal stress over the closure, loading and unloading."""
    with _chart(f"{title}: closure", path) as axes:
        half = len(curve.closure) // 2 + 1
        axes.plot(1e3 * curve.closure[:half], 1e-6 * curve.normal_stress[:half], color=COLOURS[0], label="loading")
        axes.plot(1e3 * curve.closure[half - 1 :], 1e-6 * curve.normal_stress[half - 1 :], "--", color=COLOURS[1],
                  label="unloading")  # fmt: skip
        axes.set_xlabel("closure, mm")
        axes.set_ylabel("normal stress, MPa")


def draw_bolt(curves: Mapping[str, BoltCurve], title: str, path: Path) -> None:
    """Draw the force of a bolt over the displacement of the joint, pulled out and sheared."""
    with _chart(title, path) as axes:
        for colour, (name, curve) in zip(_colours(len(curves)), curves.items(), strict=True):
            axes.plot(1e3 * curve.displacement, 1e-3 * curve.force, color=colour, label=name)
            axes.plot(1e3 * curve.displacement, 1e-3 * curve.tension, ":", color=colour, label=f"{name}: tension in it")
        axes.set_xlabel("displacement of the joint, mm")
        axes.set_ylabel("force of one bolt, kN")


def _colours(count: int) -> list[str]:
    return [COLOURS[k % len(COLOURS)] for k in range(count)]


@contextmanager
def _chart(title: str, path: Path) -> Iterator[Any]:
    """Draw one chart on the axes, and write it."""
    figure = paper((0.7 * WIDTH / 100, HEIGHT))
    axes = figure.add_subplot()
    yield axes
    axes.grid(visible=True, color="#dddddd", linewidth=0.6)
    figure.legend(loc="outside lower center", ncols=3, frameon=False)
    axes.set_title(title, loc="left")
    save(figure, path)
