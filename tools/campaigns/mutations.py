"""Good files made faulty: trees of keys and values, lines of text, bytes."""

from __future__ import annotations

import copy
import re
import struct
from random import Random
from typing import Any

from .values import NUMBERS, TEXTS, spoil, text

NUMBER = re.compile(rb"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?")
SHORT_NUMBERS = [str(value).encode() for value in NUMBERS] + [
    b"1" + b"0" * 5000,
    b"1,5",
    b"--1",
    b"1e",
    b"0x1f",
    b"1_0",
]
ENCODINGS = ("latin-1", "utf-16", "utf-8-sig", "utf-32", "cp500")


def places(tree: Any) -> list[tuple[Any, Any]]:
    """Return (container, key) of every value in a tree of dicts and lists."""
    found: list[tuple[Any, Any]] = []
    keys = tree.keys() if isinstance(tree, dict) else range(len(tree)) if isinstance(tree, list) else ()
    for key in keys:
        found.append((tree, key))
        found.extend(places(tree[key]))
    return found


def mutate_tree(random: Random, tree: dict[str, Any]) -> dict[str, Any]:
    """Return a copy of a tree with one to three changes of a key or a value."""
    changed = copy.deepcopy(tree)
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        there = places(changed)
        if not there:
            break
        holder, key = random.choice(there)
        kind = random.random()
        if kind < 0.12:
            del holder[key]
        elif kind < 0.2 and isinstance(holder, dict):
            holder[str(text(random, str(key)))] = holder.pop(key)
        elif kind < 0.28:  # two values change places
            other, place = random.choice(there)
            try:
                holder[key], other[place] = copy.deepcopy(other[place]), copy.deepcopy(holder[key])
            except (KeyError, IndexError):
                continue
        elif kind < 0.34:  # a value of another place comes here too
            other, place = random.choice(there)
            name = place if isinstance(holder, dict) and isinstance(place, str) else key
            holder[name] = copy.deepcopy(other[place])
        elif kind < 0.4 and isinstance(holder, list):
            holder.append(copy.deepcopy(holder[key]))
        elif kind < 0.44 and isinstance(holder, dict):
            holder[random.choice(TEXTS)] = copy.deepcopy(holder[key])
        else:
            holder[key] = spoil(random, holder[key], types=False)
    return changed


def mutate_text(random: Random, data: bytes) -> bytes:
    """Return a text with a number, a line or a section changed, or in another encoding."""
    kind = random.random()
    if kind < 0.45:
        numbers = list(NUMBER.finditer(data))
        if not numbers:
            return mutate_bytes(random, data)
        found = random.choice(numbers)
        return data[: found.start()] + random.choice(SHORT_NUMBERS) + data[found.end() :]
    lines = data.split(b"\n")
    at, other = random.randrange(len(lines)), random.randrange(len(lines))
    if kind < 0.55:
        del lines[at]
    elif kind < 0.63:
        lines.insert(other, lines[at])
    elif kind < 0.7:
        lines[at], lines[other] = lines[other], lines[at]
    elif kind < 0.76:
        lines = lines[:at]
    elif kind < 0.82:
        return _sections(random, data)
    elif kind < 0.88:
        words = lines[at].split()
        random.shuffle(words)
        lines[at] = b" ".join(words[: random.randrange(len(words) + 1)])
    elif kind < 0.92:
        lines[at] = lines[at] + random.choice(TEXTS).encode()
    elif kind < 0.95:
        return data.decode("utf-8", "replace").replace("a", "ä", 1).encode(random.choice(ENCODINGS), "replace")
    else:
        return mutate_bytes(random, data)
    return b"\n".join(lines)


def _sections(random: Random, data: bytes) -> bytes:
    """Return a text with its sections (of TOML, of Gmsh, tags, rows) in another order, or without one."""
    parts = re.split(rb"(?m)^(?=\[|\$[^E]|<|\*|#)", data)
    if random.random() < 0.5 and len(parts) > 1:
        del parts[random.randrange(len(parts))]
    else:
        random.shuffle(parts)
    return b"".join(parts)


def mutate_bytes(random: Random, data: bytes) -> bytes:
    """Return bytes cut off, flipped, doubled, taken out, or with an extreme number written over them."""
    if not data:
        return random.randbytes(random.randrange(64))
    kind, at = random.random(), random.randrange(len(data))
    if kind < 0.15:
        return data[:at]
    if kind < 0.4:
        changed = bytearray(data)
        for _ in range(random.choice((1, 1, 2, 8, 64))):
            changed[random.randrange(len(data))] ^= 1 << random.randrange(8)
        return bytes(changed)
    if kind < 0.65:
        return _overwritten(random, data, at)
    end = min(len(data), at + random.choice((1, 2, 4, 8, 32, 256)))
    if kind < 0.75:
        return data[:at] + data[end:]
    if kind < 0.85:
        return data[:end] + data[at:end] * random.choice((1, 2, 100)) + data[end:]
    if kind < 0.92:
        return data[:at] + random.randbytes(end - at) + data[end:]
    if kind < 0.96:
        other = random.randrange(len(data))
        return data[:at] + data[other : other + end - at] + data[end:]
    return random.choice(
        (b"", b"\n", b"\x00" * len(data), random.randbytes(len(data)), data + data, b"\xff\xfe" + data)
    )


def _overwritten(random: Random, data: bytes, at: int) -> bytes:
    """Return bytes with a number of a format that is common in files at a place."""
    kind = random.choice(("<i", "<q", "<d", "<f", ">i", ">q", ">d", "B"))
    value = random.choice(
        (0, 1, -1, 2, 127, 2**31 - 1, -(2**31), 2**40, 2**63 - 1, -(2**63), float("nan"), float("inf"), 1e308)
    )
    if kind[-1] in "iqB":
        width = {"i": 32, "q": 64, "B": 8}[kind[-1]]
        whole = int(value) if value == value and abs(value) < 1e300 else -1
        packed = (whole % 2**width).to_bytes(width // 8, "little" if kind[0] != ">" else "big")
    else:
        try:
            packed = struct.pack(kind, value)
        except OverflowError:
            packed = struct.pack(kind, float("inf"))
    at -= at % random.choice((1, 4, 8))
    return data[:at] + packed + data[at + len(packed) :]


def mutate(random: Random, data: bytes, *, binary: bool | None = None) -> bytes:
    """Return a file with one change, or a few."""
    by_bytes = binary if binary is not None else b"\x00" in data[:4000]
    for _ in range(random.choice((1, 1, 1, 2, 4))):
        data = (mutate_bytes if by_bytes and random.random() < 0.8 else mutate_text)(random, data)
    return data
