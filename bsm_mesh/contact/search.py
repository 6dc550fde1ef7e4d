"""temporary"""

from __future__ import annotations

from dataclasses import dataclass

import numba as nb
import numpy as np
import shapely

from bsm_mesh.arrays import *
from bsm_mesh.model.blocks import Blocks


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Outlines:
    corners: FloatArray
    offsets: IntArray
    held: BoolArray
    size: float

    @classmethod
    def of(cls, blocks: Blocks, held: BoolArray) -> Outlines:
        m = blocks.moments
        free = ~held if (~held).any() else held
        return cls(
            corners=blocks.vertices - m.centroid[blocks.owner],
            offsets=blocks.offsets,
            held=held,
            size=float(np.median(np.sqrt(m.area[free]))),
        )


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class ActiveContacts:
    pair: IntArray
    key: IntArray
    pressure: FloatArray
    point: FloatArray
    normal: FloatArray

    @classmethod
    def none(cls) -> ActiveContacts:
        e = np.zeros(0, np.int64)
        return cls(pair=e, key=e, pressure=np.zeros(0), point=np.zeros((0, 2)), normal=np.zeros((0, 2)))


@dataclass(frozen=True, eq=False, slots=True, kw_only=True)
class Candidates:
    block_a: IntArray
    block_b: IntArray
    corner: IntArray
    edge: IntArray
    pair: IntArray
    key: IntArray
    gap: FloatArray
    along: FloatArray
    edge_length: FloatArray
    length: FloatArray
    parallel_edge: IntArray
    in_range: BoolArray
    history: IntArray
    inherits: IntArray


def corner_positions(o: Outlines, q: FloatArray) -> FloatArray:
    own = np.repeat(np.arange(len(o.offsets) - 1), np.diff(o.offsets))
    c, s = np.cos(q[own, 2]), np.sin(q[own, 2])
    x, y = o.corners.T
    return np.stack([q[own, 0] + c * x - s * y, q[own, 1] + s * x + c * y], axis=1)


@nb.njit(cache=True)
def narrow(P, W, off, band, h, hpk, hkey, hx, hn):
    pen = 0.25 * h
    newtol = 1e-3 * h
    angtol = 0.05
    angpar = 0.1
    leave = 1e-3
    dc = 5e-3
    tolc = 1e-3 * h
    cap = 8 * P.shape[0] + 64
    IR = np.empty((cap, 8), np.int64)
    FR = np.empty((cap, 8))
    m = 0
    M = 400
    ci = np.empty((M, 9), np.int64)
    cf = np.empty((M, 8))
    order = np.empty(M, np.int64)
    keep = np.empty(M, np.int64)
    for p in range(P.shape[0]):
        a0 = P[p, 0]
        b0 = P[p, 1]
        nc = 0
        pk = (np.int64(a0) << 32) | np.int64(b0)
        h0 = np.searchsorted(hpk, pk)
        h1 = h0
        while h1 < hpk.size and hpk[h1] == pk:
            h1 += 1
        for role in range(2):
            A = a0 if role == 0 else b0
            B = b0 if role == 0 else a0
            oa = off[A]
            na = off[A + 1] - oa
            ob = off[B]
            nb_ = off[B + 1] - ob
            for i in range(na):
                vx = W[oa + i, 0]
                vy = W[oa + i, 1]
                k1 = oa + (i + 1) % na
                k2 = oa + (i - 1 + na) % na
                e1x = W[k1, 0] - vx
                e1y = W[k1, 1] - vy
                e2x = W[k2, 0] - vx
                e2y = W[k2, 1] - vy
                if e1x * e2y - e1y * e2x <= 0:
                    continue
                l1 = np.sqrt(e1x * e1x + e1y * e1y)
                l2 = np.sqrt(e2x * e2x + e2y * e2y)
                for j in range(nb_):
                    px = W[ob + j, 0]
                    py = W[ob + j, 1]
                    k = ob + (j + 1) % nb_
                    tx = W[k, 0] - px
                    ty = W[k, 1] - py
                    L = np.sqrt(tx * tx + ty * ty)
                    tx /= L
                    ty /= L
                    nx = ty
                    ny = -tx
                    g = (vx - px) * nx + (vy - py) * ny
                    if g > band or g < -pen:
                        continue
                    s = (vx - px) * tx + (vy - py) * ty
                    if s < -band or s > L + band:
                        continue
                    c1 = (e1x * nx + e1y * ny) / l1
                    c2 = (e2x * nx + e2y * ny) / l2
                    if c1 < -angtol or c2 < -angtol:
                        continue
                    tl = -1.0
                    pe = -1
                    if abs(c1) < angpar:
                        so = s + e1x * tx + e1y * ty
                        lo = max(0.0, min(s, so))
                        hi = max(lo, min(L, max(s, so)))
                        if hi - lo > tl:
                            tl = hi - lo
                            pe = oa + i
                    if abs(c2) < angpar:
                        so = s + e2x * tx + e2y * ty
                        lo = max(0.0, min(s, so))
                        hi = max(lo, min(L, max(s, so)))
                        if hi - lo > tl:
                            tl = hi - lo
                            pe = k2
                    if 0 <= tl < dc * h and (s < dc * h or s > L - dc * h):
                        continue
                    key = (np.int64(oa + i) << 32) | np.int64(ob + j)
                    hi_ = -1
                    for q in range(h0, h1):
                        if hkey[q] == key:
                            hi_ = q
                            break
                    act = hi_ >= 0
                    le = leave * h if act else 1e-9 * L
                    inr = s >= -le and s <= L + le
                    if act and not inr:
                        continue
                    inh = -1
                    if not act:
                        bd = 1e300
                        for q in range(h0, h1):
                            if hkey[q] == key:
                                continue
                            d = np.hypot(hx[q, 0] - vx, hx[q, 1] - vy)
                            al = hn[q, 0] * nx + hn[q, 1] * ny
                            if (hkey[q] >> 32) < oa or (hkey[q] >> 32) >= oa + na:
                                al = -al
                            if d < 0.1 * h and al > 0.9 and d < bd:
                                bd = d
                                inh = q
                        if g < -newtol and (inh < 0 or not inr):
                            continue
                    if nc >= M:
                        continue
                    ci[nc, 0] = A
                    ci[nc, 1] = B
                    ci[nc, 2] = oa + i
                    ci[nc, 3] = ob + j
                    ci[nc, 4] = hi_
                    ci[nc, 5] = inh
                    ci[nc, 6] = 1 if act else 0
                    ci[nc, 7] = 1 if inr else 0
                    ci[nc, 8] = pe
                    cf[nc, 0] = g
                    cf[nc, 1] = s
                    cf[nc, 2] = L
                    cf[nc, 3] = tl
                    cf[nc, 4] = vx
                    cf[nc, 5] = vy
                    cf[nc, 6] = nx
                    cf[nc, 7] = ny
                    nc += 1
        if nc == 0:
            continue
        for a in range(nc):
            keep[a] = 1
            if ci[a, 7] and cf[a, 0] < 0:
                for c in range(nc):
                    if (
                        c != a
                        and ci[c, 2] == ci[a, 2]
                        and ci[c, 7]
                        and (ci[c, 6] > ci[a, 6] or (ci[c, 6] == ci[a, 6] and cf[c, 0] > cf[a, 0]))
                    ):
                        keep[a] = 0
                        break
        no = 0
        for r in range(2):
            for a in range(nc):
                if keep[a] and ci[a, 6] == 1 - r:
                    order[no] = a
                    no += 1
        for u in range(no):
            a = order[u]
            dup = False
            if ci[a, 7]:
                for w in range(u):
                    c = order[w]
                    if keep[c] == 2 and ci[c, 7] and cf[c, 0] <= newtol:
                        if (
                            np.hypot(cf[c, 4] - cf[a, 4], cf[c, 5] - cf[a, 5]) < 2 * tolc + 2 * max(0.0, -cf[a, 0])
                            and abs(cf[c, 6] * cf[a, 6] + cf[c, 7] * cf[a, 7]) > 0.9
                        ):
                            dup = True
                            break
            if not dup and not ci[a, 6]:
                A = ci[a, 0]
                B = ci[a, 1]
                oa = off[A]
                na = off[A + 1] - oa
                ob = off[B]
                nb_ = off[B + 1] - ob
                for w in range(u):
                    c = order[w]
                    if keep[c] == 2 and ci[c, 0] == B and ci[c, 7] and cf[c, 0] <= newtol:
                        j = ci[a, 3] - ob
                        i = ci[a, 2] - oa
                        i2 = ci[c, 2] - ob
                        j2 = ci[c, 3] - oa
                        if (
                            (i2 == j or i2 == (j + 1) % nb_)
                            and (i == j2 or i == (j2 + 1) % na)
                            and np.hypot(cf[c, 4] - cf[a, 4], cf[c, 5] - cf[a, 5]) < 2 * band
                        ):
                            dup = True
                            break
            if dup:
                continue
            keep[a] = 2
            if m == cap:
                cap *= 2
                I2 = np.empty((cap, 8), np.int64)
                I2[:m] = IR[:m]
                IR = I2
                F2 = np.empty((cap, 8))
                F2[:m] = FR[:m]
                FR = F2
            IR[m, 0] = ci[a, 0]
            IR[m, 1] = ci[a, 1]
            IR[m, 2] = ci[a, 2]
            IR[m, 3] = ci[a, 3]
            IR[m, 4] = ci[a, 4]
            IR[m, 5] = ci[a, 5]
            IR[m, 6] = ci[a, 7]
            IR[m, 7] = ci[a, 8]
            for z in range(8):
                FR[m, z] = cf[a, z]
            m += 1
    return IR[:m], FR[:m]


def detect_contacts(o: Outlines, q: FloatArray, act: ActiveContacts, band: float) -> Candidates:
    W = corner_positions(o, q)
    lo = np.minimum.reduceat(W, o.offsets[:-1], axis=0) - band / 2
    hi = np.maximum.reduceat(W, o.offsets[:-1], axis=0) + band / 2
    bx = shapely.box(*lo.T, *hi.T)
    P = shapely.STRtree(bx).query(bx)
    P = P[:, P[0] < P[1]]
    P = P[:, ~(o.held[P[0]] & o.held[P[1]])].T
    P = P[np.lexsort((P[:, 1], P[:, 0]))].astype(np.int64)
    IR, FR = narrow(P, W, o.offsets.astype(np.int64), band, o.size, act.pair, act.key, act.point, act.normal)
    h = o.size
    i32 = lambda k: IR[:, k].astype(np.int32)
    pk = (np.minimum(IR[:, 0], IR[:, 1]) << 32) | np.maximum(IR[:, 0], IR[:, 1])
    return Candidates(
        block_a=i32(0),
        block_b=i32(1),
        corner=i32(2),
        edge=i32(3),
        pair=pk,
        key=(IR[:, 2] << 32) | IR[:, 3],
        gap=FR[:, 0].copy(),
        along=FR[:, 1].copy(),
        edge_length=FR[:, 2].copy(),
        length=np.maximum(FR[:, 3] / 2, 0.05 * h),
        parallel_edge=i32(7),
        in_range=IR[:, 6] == 1,
        history=i32(4),
        inherits=np.where(IR[:, 4] >= 0, -1, IR[:, 5]).astype(np.int32),
    )
