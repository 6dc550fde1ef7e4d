"""Columns of contacts in cycles of explicit motion: constants of a window, and what changes in it.

Contacts lie in chunks, within a chunk column by column: the compiler takes several contacts at once, and a cycle reads
in the order of memory. Properties that few models need have columns of their own, none elsewhere.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bsm_mesh.arrays import FloatArray, IntArray
from bsm_mesh.compiled import njit
from bsm_mesh.model.joint_laws.shear_stiffness import ShearCurve

SingleArray = NDArray[np.float32]
ChunkArray = NDArray[np.void]  # (c,) of CONTACT, STRENGTH, ...: WIDTH contacts each, the last filled up with zeros

WIDTH = 16  # contacts of a chunk, which changes no digit: of every column it is a line of the cache


def _chunk(*names: str, kind: str = "f4") -> np.dtype[np.void]:
    return np.dtype([(name, kind, (WIDTH,)) for name in names])


FRAME = ("bx", "by", "ax", "ay", "tx", "ty")  # as `frames` returns them
CONTACT = _chunk(
    *FRAME,
    "normal_stiffness",
    "shear_stiffness",
    "trial_pressure",  # at the reference: below 0 what it would take to close the contact
    "pressure",  # that the reference forces contain
    "shear",
    "low",  # least and greatest movement along the edge within which the corner meets it
    "high",
    "first",  # intercept of a line of the shear strength over the pressure
    "first_slope",
    "dashpot",  # of the normal force, over a cycle
    "carried",  # shear force, movement along the edge and gap after the last cycle
    "along",
    "gap",
    "contacted",  # 1: closed at any time in the window
)
"""What every contact has [N/m2, N/m, m]; all from `carried` on changes."""
STRENGTH = _chunk(
    "second",  # another line: the lower one governs
    "second_slope",
    "residual",  # the line once it has failed
    "residual_slope",
    "first_lasts",  # 1: slip on the first, the second line is for good
    "second_lasts",
    "tension",  # tensile strength
    "failed",  # 1: has slipped for good, has broken in tension
    "broken",
)
"""Strength of more than one line, or with something to lose; the last three change."""
CLOSURE = _chunk("stiffening", "rock_share")
"""Of joints that close by a hyperbola, as in `Hyperbolic.stiffening`; 0: this one does not."""
SLIP = _chunk("slid", "dilation", "room")
"""How far a contact has slid in the window [m], the slope by which that opens it, and on which slip it does so."""
GROWTH = _chunk(*ShearCurve._fields, "length", "compliance", "stiffest", "stiffness", "last_pressure")
"""Shear stiffness by the pressure, as `Growing` has it; not above `stiffest`, which masses allow for; both of last."""
WORK = _chunk(
    "dissipated",  # by slip and broken bonds
    "damped",  # by dashpots
    "pressure",  # of the spring, the dashpot's and the opening by dilation after the last cycle
    "drag",
    "opening",
    "begun",  # 1 after the first cycle
    "lag",  # dashpots over their springs, in cycles
    "last",  # movement along the edge in the cycle before the window
    "shear_drag",  # of the dashpot along the edge after the last cycle
    "shear",  # shear force of the spring, its stiffness, movement along the edge and gap before this cycle
    "stiffness",
    "along",
    "gap",
    kind="f8",
)
"""Work that contacts take in a window [N], in double precision, where it is asked for; all of them change."""
LEAST_SHARE = np.float32(1 / 16)  # of the rock in the compliance: in a window a joint becomes at most so much stiffer


def chunked(kind: np.dtype[np.void], columns: Mapping[str, Any], count: int) -> ChunkArray:
    """Return contacts in chunks, (c,) of `kind`, from some of their columns (count,); others are zero."""
    names, size = kind.names or (), -(-count // WIDTH)
    flat = np.zeros((len(names), size * WIDTH), kind[0].base)
    for row, name in enumerate(names):
        if name in columns:
            flat[row, :count] = columns[name]
    by_chunk = np.ascontiguousarray(flat.reshape(len(names), size, WIDTH).swapaxes(0, 1))
    chunks: ChunkArray = by_chunk.reshape(size, len(names) * WIDTH).view(kind).reshape(size)
    return chunks


def column_of(chunks: ChunkArray, name: str, count: int) -> SingleArray:
    """Return a column of the contacts in chunks, (count,)."""
    column: SingleArray = chunks[name].reshape(-1)[:count]
    return column


def chosen(chunks: ChunkArray, rows: IntArray) -> ChunkArray:
    """Return some of the contacts, `rows` (k,), in chunks of their own; empty columns stay so."""
    if not len(chunks):
        return chunks
    part = np.zeros(-(-len(rows) // WIDTH), chunks.dtype)
    _copy_out(_numbers(chunks), rows, _numbers(part))
    return part


def put(chunks: ChunkArray, rows: IntArray, part: ChunkArray) -> None:
    """Put back the contacts `rows` (k,) that `chosen` has taken out."""
    if len(chunks):
        _copy_back(_numbers(chunks), rows, _numbers(part))


def _numbers(chunks: ChunkArray) -> SingleArray | FloatArray:
    """Return chunks as numbers: (c, columns, WIDTH)."""
    names = chunks.dtype.names or ()
    return chunks.view(chunks.dtype[names[0]].base).reshape(len(chunks), len(names), WIDTH)


@njit(nogil=True)
def _copy_out(
    chunks: SingleArray | FloatArray, rows: IntArray, part: SingleArray | FloatArray
) -> None:  # pragma: no cover - compiled
    for k in range(rows.size):
        for column in range(chunks.shape[1]):
            part[k // WIDTH, column, k % WIDTH] = chunks[rows[k] // WIDTH, column, rows[k] % WIDTH]


@njit(nogil=True)
def _copy_back(
    chunks: SingleArray | FloatArray, rows: IntArray, part: SingleArray | FloatArray
) -> None:  # pragma: no cover - compiled
    for k in range(rows.size):
        for column in range(chunks.shape[1]):
            chunks[rows[k] // WIDTH, column, rows[k] % WIDTH] = part[k // WIDTH, column, k % WIDTH]


@njit(allocates=True)
def frames(
    position: FloatArray, block_a: IntArray, block_b: IntArray, geometry: FloatArray, rows: IntArray
) -> SingleArray:  # pragma: no cover - compiled
    """Return the reference frames of contacts by their columns, (6, k) [m; -].

    Vectors from b's and from a's centroid to the corner, and the edge's direction. `block_a`, `block_b` (k,) are
    those of the `rows` (k,) of `geometry` (m, 8), which `relative_positions` describes.
    """
    frame = np.empty((6, rows.size), np.float32)
    cosine, sine = np.cos(position[:, 2]), np.sin(position[:, 2])
    for k in range(rows.size):
        a, b, given = block_a[k], block_b[k], geometry[rows[k]]
        ax, ay = cosine[a] * given[2] - sine[a] * given[3], sine[a] * given[2] + cosine[a] * given[3]
        frame[0, k] = given[0] + (position[a, 0] - position[b, 0]) + ax
        frame[1, k] = given[1] + (position[a, 1] - position[b, 1]) + ay
        frame[2, k], frame[3, k] = ax, ay
        frame[4, k] = cosine[b] * given[6] - sine[b] * given[7]
        frame[5, k] = sine[b] * given[6] + cosine[b] * given[7]
    return frame


@njit(allocates=True)
def stiffness_sums(
    block_a: IntArray,
    block_b: IntArray,
    bx: SingleArray,
    by: SingleArray,
    ax: SingleArray,
    ay: SingleArray,
    normal_stiffness: SingleArray,
    rock_share: SingleArray,
    shear_stiffness: SingleArray,
    n: int,
) -> FloatArray:  # pragma: no cover - compiled
    """Return what bounds the highest frequency of n blocks, (n, 3) [N/m2, N/m2, N]: Gershgorin sums over contacts.

    A cycle of unit time is stable if no mass is below them: the stiffer spring of a contact counts twice, for both
    its blocks' movement and for translation and turn, the latter times the square of the arm.
    """
    sums = np.zeros((n, 3))
    for k in range(block_a.size):
        normal = normal_stiffness[k] / max(rock_share[k], LEAST_SHARE)  # as stiff as it may become
        stiffness = np.float64(max(normal, shear_stiffness[k]))
        sums[block_a[k], 0] += stiffness
        sums[block_b[k], 0] += stiffness
        sums[block_a[k], 2] += stiffness * (ax[k] * ax[k] + ay[k] * ay[k])
        sums[block_b[k], 2] += stiffness * (bx[k] * bx[k] + by[k] * by[k])
    sums[:, 1] = sums[:, 0]
    return sums
