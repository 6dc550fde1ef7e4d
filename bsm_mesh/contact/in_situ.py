"""Contact forces and reactions set from the in-situ stress field, exactly (Wang 4.5.1 without turning gravity on)."""

from __future__ import annotations

import numpy as np

from bsm_mesh.arrays import BoolArray, FloatArray, IntArray
from bsm_mesh.contact.table import GAUSS, ContactTable
from bsm_mesh.errors import place
from bsm_mesh.model.model import Model
from bsm_mesh.model.stress_field import StressField
from bsm_mesh.model.supports import Bars


def in_situ_contacts(model: Model, contacts: ContactTable) -> tuple[FloatArray, FloatArray]:
    """Return normal and shear force of the contacts of the start, (m,) each [N/m].

    The two contacts of a face follow each other; their forces have the resultant and the moment of the effective
    traction on the face.
    """
    field = StressField(model)
    blocks = (contacts.block_a[::2], contacts.block_b[::2])
    first, second = contacts.point[::2], contacts.point[1::2]
    if model.contact_points == "gauss":  # from the Gauss points back to the ends
        beyond = (second - first) * GAUSS / (1 - 2 * GAUSS)
        first, second = first - beyond, second + beyond
    ends = field.end_forces(first, second, contacts.normal[::2], blocks, contacts.joint[::2])
    if model.contact_points == "gauss":
        ends = _to_gauss_points(ends)
    force = ends.reshape(-1, 2)
    # Of a T-junction's face the second contact may have the roles swapped: its normal then points the other way.
    swapped = np.repeat((contacts.normal[::2] * contacts.normal[1::2]).sum(axis=1) < 0, 2)
    swapped[::2] = False
    force[swapped] *= -1
    n = contacts.normal
    return (force * n).sum(axis=1), force[:, 1] * n[:, 0] - force[:, 0] * n[:, 1]


def _to_gauss_points(ends: FloatArray) -> FloatArray:
    """Return forces (k, 2, 2) at the Gauss points with the resultant and moment of those at the ends."""
    near, far = (1 - GAUSS) / (1 - 2 * GAUSS), -GAUSS / (1 - 2 * GAUSS)
    moved: FloatArray = near * ends + far * ends[:, ::-1]
    return moved


def in_situ_bars(model: Model, bars: Bars) -> FloatArray:
    """Return the forces in the bars of supported boundaries, (b,) [N/m]: their parts of the effective traction."""
    found = np.zeros(len(bars.block))
    on_edge = np.flatnonzero(bars.edge >= 0)
    if not on_edge.size:
        return found
    edges, place = np.unique(bars.edge[on_edge], return_inverse=True)
    ends = StressField(model).edge_forces(edges)[place.reshape(-1)]
    at_second = _at_second_end(model, bars, on_edge)
    force = ends[np.arange(len(on_edge)), at_second.astype(np.int64)]
    found[on_edge] = (force * bars.direction[on_edge]).sum(axis=1)
    return found


def _at_second_end(model: Model, bars: Bars, on_edge: IntArray) -> BoolArray:
    start = model.blocks.vertices[bars.edge[on_edge]]
    second: BoolArray = (bars.point[on_edge] != start).any(axis=1)
    return second


def beyond_strength(
    point: FloatArray,
    pressure: FloatArray,
    shear: FloatArray,
    peak: FloatArray,
    tension: FloatArray,
    *,
    what: str = "the in-situ field is",
    meaning: str = "the joints cannot carry this k0 or stress",
) -> tuple[str, ...]:
    """Return a sentence if forces exceed the strength of contacts; nothing if none does.

    Parameters
    ----------
    point : (m, 2) float64 [m]
        Where the contacts are.
    pressure, shear : (m,) float64 [N/m]
        Their forces, compression positive.
    peak, tension : (m,) float64 [N/m]
        Their strength in shear at that pressure, and in tension.
    what, meaning : str
        How the sentence begins and ends; of the in-situ field unless said otherwise.
    """
    size = float(np.hypot(pressure, shear).max(initial=0.0))
    slips, parts = np.abs(shear) > peak + 1e-9 * size, -pressure > tension + 1e-9 * size
    beyond = np.flatnonzero(slips | parts)
    if not beyond.size:
        return ()
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(slips, np.abs(shear) / peak, 0.0)[beyond]
    worst = beyond[int(np.argmax(np.nan_to_num(ratio, posinf=1e300)))]
    return (
        f"{what} beyond the strength of {beyond.size} of {len(pressure)} contacts ({int(slips.sum())} in "
        f"shear, {int(parts.sum())} in tension; the worst at {place(point[worst])}): "
        f"{meaning}",
    )
