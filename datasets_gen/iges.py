"""The B-spline surfaces of an IGES file.

Source: IGES 5.3 (ANS US PRO/IPO-100-1996), section 2.2 (fixed format) and section 4.32 (entity 128).
"""

from __future__ import annotations

import re
from collections import Counter

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface

SURFACE, MATRIX = 128, 124
TRIMMED = {143: "bounded surfaces", 144: "trimmed surfaces", 510: "faces"}
BYTE_ORDER_MARK = "\xef\xbb\xbf"  # as latin-1 reads it
NOTHING = " \t\0\x1a"  # of a line: blanks, and what ends a file of DOS
OTHER = {108, 114, 118, 120, 122, 140, 190, 192, 194, 196, 198}  # surfaces of other kinds


def parse_iges(text: str) -> NurbsModel:
    """All entities 128 of the file, moved by their transformation matrices and cut to their ranges of parameters.

    Raises:
        ValueError: not IGES in its fixed form, cut short, an entity with fewer numbers than it declares.
    """
    sections: dict[str, list[str]] = {letter: [] for letter in "SGDPT"}
    for number, line in enumerate(re.split(r"\r\n?|\n", text.removeprefix(BYTE_ORDER_MARK)), 1):
        if not line.strip(NOTHING):
            continue
        letter = line[72:73].upper()
        if letter and letter in "CB":
            raise ValueError("expected the fixed form, got the compressed or binary one")
        if letter not in sections:
            raise ValueError(
                f"line {number}: expected S, G, D, P or T in column 73, got {letter!r}"
            )
        sections[letter].append(line)
    if not sections["T"]:
        raise ValueError("truncated: expected a line T at the end, got none")
    for letter, count in re.findall(r"([SGDP])\s*(\d+)", sections["T"][0][:72]):
        if len(sections[letter]) != int(count):
            raise ValueError(
                f"truncated: expected {int(count)} lines {letter}, got {len(sections[letter])}"
            )
    if len(sections["D"]) % 2:
        raise ValueError("expected two lines D for each entity, got an odd number")
    entities = [_fields(*sections["D"][k : k + 2]) for k in range(0, len(sections["D"]), 2)]
    separators = _separators("".join(line[:72] for line in sections["G"]))
    kinds = Counter(entity["type"] for entity in entities)

    def numbers(entity: dict[str, int]) -> NDArray[np.float64]:
        """The entity's parameters, its type first."""
        start = entity["first"] - 1
        rows = sections["P"][start : start + max(entity["lines"], 1)]
        return _numbers("".join(row[:64] for row in rows), separators, entity["type"])

    surfaces, names = [], []
    for k, entity in enumerate(entities):
        if entity["type"] != SURFACE:
            continue
        name = f"D{2 * k + 1}"
        try:
            surface = _surface(numbers(entity))
            seen: set[int] = set()
            while (place := entity["matrix"]) != 0:  # a transformation may itself be moved
                index = (place - 1) // 2
                if not 0 <= index < len(entities) or entities[index]["type"] != MATRIX:
                    raise ValueError(f"expected a transformation at D{place}, got none")
                if index in seen:
                    raise ValueError(f"expected transformations that end, got D{place} again")
                seen.add(index)
                entity = entities[index]
                surface = _moved(surface, numbers(entity))
        except (ValueError, OverflowError) as error:
            raise ValueError(f"entity {name}: {error}") from None
        surfaces.append(surface)
        names.append(name)
    if not surfaces:
        raise ValueError("expected B-spline surfaces (entity 128), got none")
    notes = [
        f"trims of {kinds[kind]} {what} are left out"
        for kind, what in TRIMMED.items()
        if kinds[kind]
    ]
    if others := sum(kinds[kind] for kind in OTHER):
        notes.append(f"{others} surfaces of other kinds are left out")
    return NurbsModel(tuple(surfaces), tuple(names), tuple(notes))


def _fields(first: str, second: str) -> dict[str, int]:
    """What is needed of a directory entry: fields of eight columns."""

    def field(line: str, index: int) -> int:
        text = line[8 * index : 8 * index + 8].strip()
        if not re.fullmatch(r"[+-]?\d*", text):
            raise ValueError(f"expected a number in a line D, got {text!r}")
        return int(text or 0)

    return {
        "type": field(first, 0),
        "first": field(first, 1),
        "matrix": field(first, 6),
        "lines": field(second, 3),
    }


def _separators(start: str) -> tuple[str, str]:
    """What separates parameters and ends a record: the first two of section G, commonly left out."""
    between, end = ",", ";"
    if match := re.match(r"\s*1H(.)", start):
        between, start = match[1], start[match.end() + 1 :]
    else:
        start = start.lstrip()[1:]
    if match := re.match(r"\s*1H(.)", start):
        end = match[1]
    return between, end


def _numbers(text: str, separators: tuple[str, str], kind: int) -> NDArray[np.float64]:
    between, end = separators
    record, found, _ = text.partition(end)
    if not found:
        raise ValueError(f"truncated: expected {end!r} at the end of its parameters, got none")
    words = [word.replace(" ", "").upper().replace("D", "E") for word in record.split(between)]
    try:
        numbers = np.array([_number(word) for word in words])
    except ValueError:
        raise ValueError("expected numbers, got others") from None
    if int(numbers[0]) != kind:
        raise ValueError(f"expected parameters of type {kind}, got {words[0]}")
    return numbers[1:]


def _number(word: str) -> float:
    """Of Fortran: D for E is replaced already, and the letter may be missing; left out is 0."""
    bare = re.fullmatch(r"([+-]?[\d.]+)([+-]\d+)", word)
    return float(f"{bare[1]}E{bare[2]}" if bare else word or 0.0)


def _surface(numbers: NDArray[np.float64]) -> NurbsSurface:
    if len(numbers) < 9:
        raise ValueError(f"expected 9 numbers and more, got {len(numbers)}")
    last_u, last_v, degree_u, degree_v = (int(n) for n in numbers[:4])
    if min(last_u, last_v, degree_u, degree_v) < 0:
        raise ValueError("expected counts and degrees that are not negative, got one that is")
    count_u, count_v = last_u + 1, last_v + 1
    sizes = [
        count_u + degree_u + 1,
        count_v + degree_v + 1,
        count_u * count_v,
        3 * count_u * count_v,
        4,
    ]
    if len(numbers) < 9 + sum(sizes):
        raise ValueError(f"expected {9 + sum(sizes)} numbers, got {len(numbers)}")
    parts = np.split(numbers[9:], np.cumsum(sizes))[:5]
    weights = parts[2].reshape(count_v, count_u).T
    points = parts[3].reshape(count_v, count_u, 3).transpose(1, 0, 2)
    surface = NurbsSurface(degree_u, degree_v, parts[0], parts[1], points, weights)
    low_u, high_u, low_v, high_v = parts[4]
    own = surface.knots_u, surface.knots_v
    inside = any(
        low > knots[0] or high < knots[-1]
        for knots, low, high in zip(own, (low_u, low_v), (high_u, high_v), strict=True)
    )
    given = low_u < high_u and low_v < high_v
    return surface.within(low_u, high_u, low_v, high_v) if inside and given else surface


def _moved(surface: NurbsSurface, matrix: NDArray[np.float64]) -> NurbsSurface:
    """Under an entity 124: three rows of a rotation and a translation."""
    if len(matrix) < 12:
        raise ValueError(f"expected 12 numbers of a transformation, got {len(matrix)}")
    rows = matrix[:12].reshape(3, 4)
    points = surface.points @ rows[:, :3].T + rows[:, 3]
    return NurbsSurface(
        surface.degree_u,
        surface.degree_v,
        surface.knots_u,
        surface.knots_v,
        points,
        surface.weights,
    )
