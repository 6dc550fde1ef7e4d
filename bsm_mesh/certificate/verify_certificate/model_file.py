"""Input of a certificate, compared with the model file and the mesh in the folder: outlines, weights, strength."""

from __future__ import annotations

import base64
import re
import tomllib
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from .geometry import Arrays, size_of
from .space import is_in_space
from .water import table_faults

MODEL, MESH = "model.toml", "mesh.vtu"
FALLEN = 0.04  # of its size: an unstable block moved by more
SAME = 1e-9  # relative: numbers of two files of the same model
TYPES = {"Float64": np.float64, "Int64": np.int64, "Int32": np.int32, "UInt8": np.uint8}


class GivenFiles:
    """The model file and the mesh of a results folder, as far as numbers of a certificate can be compared with them.

    Parameters
    ----------
    folder : Path
        The results.
    """

    def __init__(self, folder: Path) -> None:
        model, mesh = folder / MODEL, folder / MESH
        self.model: dict[str, Any] = tomllib.loads(model.read_text("utf-8")) if model.exists() else {}
        self.arrays = mesh_arrays(mesh.read_bytes()) if mesh.exists() else {}

    @property
    def text(self) -> str:
        """What there is to compare with, in words."""
        there = [name for name, has in ((MODEL, self.model), (MESH, self.arrays)) if has]
        return f"as {' and '.join(there)} give them" if there else "there is no model file to compare with"

    def faults(self, stage: dict[str, Any], a: Arrays) -> list[str]:
        """Return what of a stage is otherwise than in the files."""
        found = [*self._outlines(a), *self._weights(a), *self._gravity(stage, a), *self._supports(a)]
        found += [*self._movement(stage, a), *self._loads(a), *self._water(a), *self._bolts(a)]
        found += self._tension(stage, a)
        laws = [*stage["laws"], *stage.get("proof", {}).get("laws", [])]
        return found + [fault for law in laws for fault in self._strength(law)]

    def _outlines(self, a: Arrays) -> list[str]:
        if not self.arrays:
            return []
        if is_in_space(a):
            off = np.abs(volumes(self.arrays) - a["volume"]) > SAME * np.median(a["volume"])
            return [f"block {int(off.argmax())} has another volume than in {MESH}"] if off.any() else []
        points, blocks = polygons(self.arrays)
        same = len(points) == len(a["vertices"]) and np.array_equal(blocks, a["offsets"])
        if same:
            same = bool(np.abs(points - a["vertices"]).max() <= SAME * size_of(a))
        return [] if same else [f"the outlines of the blocks are not those of {MESH}"]

    def _weights(self, a: Arrays) -> list[str]:
        rocks = {name: _in_si(rock.get("unit_weight"), "N/m^3") for name, rock in self.model.get("rock", {}).items()}
        numbers = [weight for weight in rocks.values() if isinstance(weight, (int, float))]
        if "unit_weight" not in a or not numbers or len(numbers) < len(rocks):
            return []
        known = np.array(numbers)
        if self.arrays and "rock" in self.arrays:
            names = {int(v[0]): k.removeprefix("rock:") for k, v in self.arrays.items() if k.startswith("rock:")}
            cells = self.arrays["rock"][leading_cells(self.arrays, len(a["present"]))]
            wanted = np.array([rocks.get(names.get(int(number), ""), np.nan) for number in cells])
            off = np.abs(a["unit_weight"] - wanted)
            off = np.where(np.isnan(wanted), np.abs(a["unit_weight"][:, None] - known).min(axis=1), off)
        else:
            off = np.abs(a["unit_weight"][:, None] - known).min(axis=1)
        bad = np.flatnonzero((off > SAME * np.abs(known).max()) & a["present"])
        return [f"block {int(bad[0])} has another unit weight than its rock in {MODEL}"] if len(bad) else []

    def _gravity(self, stage: dict[str, Any], a: Arrays) -> list[str]:
        given = self.model.get("gravity", {})
        if "gravity" not in a or not self.model or any("gravity" in one for one in self.model.get("stage", [])):
            return []
        angle = np.radians(given.get("direction", -90.0))
        wanted = np.array([np.cos(angle) + given.get("horizontal", 0), np.sin(angle) + given.get("vertical", 0)])
        if is_in_space(a):
            trend = np.radians(given.get("trend", 90.0))
            wanted = np.append(given.get("horizontal", 0) * np.array([np.sin(trend), np.cos(trend)]), wanted[1])
        off = np.abs(a["gravity"] - wanted).max()
        return [] if off <= SAME else [f"gravity of stage '{stage['name']}' is not that of {MODEL}"]

    def _supports(self, a: Arrays) -> list[str]:
        supports = self.model.get("support", [])
        if not supports or not all(isinstance(one.get("blocks"), list) for one in supports):
            return []
        allowed = {block for one in supports for block in one["blocks"]}
        invented = sorted(set(a["bar_block"].tolist()) - allowed)
        lost = sorted(allowed & set(np.flatnonzero(a["present"]).tolist()) - set(a["bar_block"].tolist()))
        faults = [f"block {invented[0]} is held by no support of {MODEL}"] if invented else []
        return faults + ([f"the support of block {lost[0]} in {MODEL} is left out"] if lost else [])

    def _loads(self, a: Arrays) -> list[str]:
        if "load_block" not in a:
            return []
        for load in self.model.get("load", []):
            block, force = load.get("block"), load.get("force")
            if not isinstance(block, int) or not force or not a["present"][block]:
                continue
            rows = a["load_force"][a["load_block"] == block]
            if not (np.abs(rows - force) <= SAME * np.abs(force).max()).all(axis=1).any():
                return [f"the load of block {block} in {MODEL} is left out"]
        return []

    def _water(self, a: Arrays) -> list[str]:
        if "water_pieces" not in a or not self.model or any("water" in one for one in self.model.get("stage", [])):
            return []
        return table_faults(a, self.model.get("water", {}), MODEL)

    def _bolts(self, a: Arrays) -> list[str]:
        if not self.model or self.model.get("bolt") or not np.any(a["bolt_force"]):
            return []
        return [f"block {int(a['bolt_block'][0])} is held by a bolt, and there is none in {MODEL}"]

    def _tension(self, stage: dict[str, Any], a: Arrays) -> list[str]:
        laws = stage.get("proof", {}).get("laws", [])
        if "proof_tension" not in a or any(law["kind"] == "reduced" for law in laws):
            return []
        tables = [*self.model.get("joint", {}).values(), *self.model.get("rock", {}).values()]
        least = min((tension_of(table) for table in tables if "law" in table or "friction" in table), default=0.0)
        short = a["proof_tension"] < (1 - 1e-6) * least * a["proof_length"]
        return ["the mechanism has less tensile strength than the joints"] if short.any() else []

    def _movement(self, stage: dict[str, Any], a: Arrays) -> list[str]:
        solver = self.model.get("solver", {})
        if stage["verdict"] != "unstable" or not solver or solver.get("scheme") == "linear":
            return []
        if any("zones" in rock for rock in self.model.get("rock", {}).values()):  # which do not follow blocks
            return []
        blocks = stage["unstable_blocks"]
        shift, turn = np.split(a["displacement"][blocks], [a["at"].shape[1]], axis=1)
        size = np.cbrt(a["volume"][blocks]) if is_in_space(a) else np.sqrt(a["area"][blocks])
        lengths = [np.linalg.norm(part, axis=1) for part in (shift, turn)]
        far = float((np.maximum(lengths[0], size / 2 * lengths[1]) / size).max(initial=0.0))
        if far >= FALLEN or "displacement_limit" in solver:
            return []
        return [f"the unstable blocks moved by {far:.1e} of their size only"]

    def _strength(self, law: dict[str, Any]) -> list[str]:
        if law["kind"] in ("elastic", "own") or any(one.get("strength") for one in self.model.get("stage", [])):
            return []
        if law["kind"] in ("weaker", "reduced"):
            inner = law["laws"] if law["kind"] == "weaker" else [law["law"]]
            return [fault for one in inner for fault in self._strength(one)]
        tables = [*self.model.get("joint", {}).values(), *self.model.get("rock", {}).values()]
        of_kind = [table for table in tables if table.get("friction") is not None or table.get("law") == law["kind"]]
        if not of_kind or any(agrees(law, table) for table in of_kind):
            return []
        shown = ", ".join(f"{key} {law[key]:g}" for key in law if isinstance(law[key], float))
        return [f"no joint or rock of {MODEL} has the strength {law['kind']} ({shown})"]


def _in_si(value: Any, unit: str) -> Any:
    """Return a number that a model file gives with its unit in SI; anything else as it is."""
    number = value.removesuffix(f" {unit}") if isinstance(value, str) else ""
    return float(number) if re.fullmatch(r"[-+.eE\d]+", number) else value


def tension_of(table: dict[str, Any]) -> float:
    """Return the tensile strength of a joint or rock [Pa], no more than to the end of a line with cohesion."""
    tension, cohesion, friction = (table.get(key) or 0.0 for key in ("tensile_strength", "cohesion", "friction"))
    return float(min(tension, cohesion / np.tan(np.radians(friction))) if friction else tension)


def agrees(law: dict[str, Any], table: dict[str, Any]) -> bool:
    """Return whether a law's numbers are those of a table of the model file, where both give a number."""
    if table.get("law", law["kind"]) != law["kind"]:
        return False
    both = [key for key in law if all(isinstance(one.get(key), (int, float)) for one in (law, table))]
    return all(abs(law[key] - table[key]) <= SAME * max(abs(table[key]), 1.0) for key in both)


def polygons(arrays: Arrays) -> tuple[Any, Any]:
    """Return corners and offsets of the polygons among the cells of a mesh."""
    ends = arrays["offsets"]
    begins = np.concatenate([[0], ends[:-1]])
    cells = np.flatnonzero((arrays["types"] == 7) | (arrays["types"] == 5) | (arrays["types"] == 9))
    corners = [arrays["connectivity"][begins[cell] : ends[cell]] for cell in cells]
    points = arrays["Points"].reshape(-1, 3)[:, :2]
    return points[np.concatenate(corners)], np.cumsum([0, *(len(corner) for corner in corners)])


def leading_cells(arrays: Arrays, count: int) -> Any:
    """Return the first cell of every block: a polygon each, or the polyhedra that the array ``block`` numbers."""
    return np.unique(arrays["block"], return_index=True)[1] if "block" in arrays else np.arange(count)


def volumes(arrays: Arrays) -> Any:
    """Return the volume of every block, from the faces of its polyhedra: tetrahedra from one point of the mesh."""
    points, faces, at = arrays["Points"].reshape(-1, 3), arrays["faces"], 0
    points = points - points[0]
    total = np.zeros(int(arrays["block"].max()) + 1)
    for block in arrays["block"].tolist():
        count, at = int(faces[at]), at + 1
        for _ in range(count):
            size, at = int(faces[at]), at + 1
            corners = points[faces[at : at + size]]
            total[block] += np.dot(corners[0], np.cross(corners[1:-1], corners[2:]).sum(axis=0)) / 6
            at += size
    return total


def mesh_arrays(content: bytes) -> Arrays:
    """Return the arrays of a VTU file in base64 and compressed by zlib, inline or appended; none of another."""
    head, _, tail = content.partition(b'<AppendedData encoding="base64">')
    if b"vtkZLibDataCompressor" not in head or b'header_type="UInt32"' not in head:
        return {}
    appended = tail[tail.index(b"_") + 1 :] if tail else b""
    found = {}
    for tag, inline in re.findall(rb"(<DataArray[^>]*>)\s*([A-Za-z0-9+/=]*)", head):
        told = dict(re.findall(r'(\w+)="([^"]*)"', tag.decode()))
        if told.get("format") not in ("binary", "appended") or told["type"] not in TYPES:
            continue
        data, offset = (inline, 0) if told["format"] == "binary" else (appended, int(told["offset"]))
        if data:
            found[told["Name"]] = np.frombuffer(blocks_at(data, offset), TYPES[told["type"]])
    return found


def blocks_at(data: bytes, offset: int) -> bytes:
    """Return one array's bytes: a header of block sizes, in base64 on its own, and the compressed blocks."""
    count = int(np.frombuffer(base64.b64decode(data[offset : offset + 8])[:4], "<u4")[0])
    bytes_of_header = 4 * (3 + count)
    coded = 4 * -(-bytes_of_header // 3)
    header = np.frombuffer(base64.b64decode(data[offset : offset + coded])[:bytes_of_header], "<u4")
    sizes = header[3:].astype(int)
    begin = offset + coded
    packed = base64.b64decode(data[begin : begin + 4 * -(-int(sizes.sum()) // 3)])
    ends = np.cumsum(sizes)
    return b"".join(zlib.decompress(packed[end - size : end]) for size, end in zip(sizes, ends, strict=True))
