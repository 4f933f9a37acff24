"""The B-spline surfaces of a STEP file.

Source: ISO 10303-21 (clear text) and ISO 10303-42, b_spline_surface with its subtypes: with knots, rational, and the
three whose knots follow from their counts.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from lodbench.datasets_gen.iges import BYTE_ORDER_MARK
from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsModel, NurbsSurface

KNOTS, RATIONAL, PLAIN = (
    "B_SPLINE_SURFACE_WITH_KNOTS",
    "RATIONAL_B_SPLINE_SURFACE",
    "B_SPLINE_SURFACE",
)
IMPLIED = "BEZIER_SURFACE", "QUASI_UNIFORM_SURFACE", "UNIFORM_SURFACE"
FACES = "ADVANCED_FACE", "FACE_SURFACE"
OTHER = re.compile(
    r"(?:PLANE|CYLINDRICAL_SURFACE|CONICAL_SURFACE|SPHERICAL_SURFACE|TOROIDAL_SURFACE|SURFACE_OF_REVOLUTION"
    r"|SURFACE_OF_LINEAR_EXTRUSION)\s*\("
)
_KINDS = re.compile(rf"\b(?:{KNOTS}|{'|'.join(IMPLIED)})\s*\(", re.I)
_DATA = re.compile(r"\bDATA\s*(?:\([^;]*\)\s*)?;")
_MARK = re.compile(r"'|/\*|;")
_ENTITY = re.compile(r"\s*#(\d+)\s*=\s*(.*);\s*\Z", re.S)
_TOKEN = re.compile(
    r"\s*(?:(?P<text>'(?:[^']|'')*')|(?P<entity>#\d+)|(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
    r"|(?P<enum>\.\w+\.)|(?P<name>[A-Za-z_]\w*)|(?P<sign>[(),$*]))"
)


def parse_step(text: str) -> NurbsModel:
    """All B-spline surfaces of the file, rational or not.

    Raises:
        ValueError: not a STEP file, cut short, a surface whose points are not there or that is not valid.
    """
    text = text.removeprefix(BYTE_ORDER_MARK)
    if not text.lstrip().startswith("ISO-10303-21"):
        raise ValueError(f"expected ISO-10303-21 at the beginning, got {text.lstrip()[:20]!r}")
    if "END-ISO-10303-21" not in text:
        raise ValueError("truncated: expected END-ISO-10303-21 at the end, got none")
    entities: dict[int, str] = {}
    for statement in _statements(text):
        if match := _ENTITY.match(statement):
            entities[int(match[1])] = match[2].strip()
    surfaces, names = [], []
    for number, entity in entities.items():
        if not _KINDS.search(entity) or not _KINDS.search(_without_texts(entity)):
            continue
        try:
            surfaces.append(_surface(_parts(entity), entities))
        except (ValueError, TypeError, IndexError, KeyError, OverflowError) as error:
            raise ValueError(f"entity #{number}: {error}") from None
        names.append(f"#{number}")
    if not surfaces:
        raise ValueError("expected B-spline surfaces, got none")
    notes = []
    if faces := sum(entity.startswith(FACES) for entity in entities.values()):
        notes.append(f"trims of {faces} faces are left out")
    if others := sum(bool(OTHER.match(entity)) for entity in entities.values()):
        notes.append(f"{others} surfaces of other kinds are left out")
    return NurbsModel(tuple(surfaces), tuple(names), tuple(notes))


def _statements(text: str) -> Iterator[str]:
    """The statements of the data, without comments; a text may hold what would else be a comment or an end.

    The header is left out: it has no surfaces, and names in it often hold a quotation mark.
    """
    found = _DATA.search(text)
    start = place = found.end() if found else 0
    pieces: list[str] = []
    while mark := _MARK.search(text, place):
        place = mark.end()
        if mark[0] != ";":
            close = "*/" if mark[0] == "/*" else "'"
            end = text.find(close, place)
            if end < 0:
                raise ValueError(f"truncated: expected {close} after {mark[0]}, got none")
            place = end + len(close)
            if mark[0] == "'":  # '' within a text is the end of one and the beginning of another
                continue
        pieces.append(text[start : mark.start()])
        start = place
        if mark[0] == ";":
            yield " ".join(pieces) + ";"
            pieces.clear()


def _without_texts(entity: str) -> str:
    """A part's name may be that of a type."""
    return re.sub(r"'[^']*'", "", entity)


def _surface(parts: Mapping[str, list[Any]], entities: Mapping[int, str]) -> NurbsSurface:
    kind = next(name for name in (KNOTS, *IMPLIED) if name in parts)
    own, weights = parts[kind], None
    if PLAIN in parts:  # a complex entity has each supertype's own values
        base = parts[PLAIN]
        if RATIONAL in parts:
            weights = parts[RATIONAL][0]
    else:
        base, own = own[1:], own[8:]
    degree_u, degree_v, rows = int(base[0]), int(base[1]), base[2]
    sides = (degree_u, len(rows)), (degree_v, len(rows[0]))
    if kind == KNOTS:
        knots_u, knots_v = (
            _repeated(*values, points + degree + 1)
            for (degree, points), values in zip(
                sides, zip(own[2:4], own[:2], strict=True), strict=True
            )
        )
    else:
        knots_u, knots_v = (_implied(kind, degree, points) for degree, points in sides)
    net = [[_point(entities, reference) for reference in row] for row in rows]
    return NurbsSurface(degree_u, degree_v, knots_u, knots_v, net, weights)


def _repeated(values: list[float], times: list[float], total: int) -> Doubles:
    counts = [int(n) for n in times]
    if min(counts, default=0) < 1 or sum(counts) != total:
        raise ValueError(f"expected multiplicities that sum to {total}, got {sum(counts)}")
    return np.repeat(np.array(values, float), counts)


def _implied(kind: str, degree: int, points: int) -> Doubles:
    """Knots that a type fixes by counts alone."""
    if points <= degree or degree < 1:
        raise ValueError(f"expected more than {degree} points for that degree, got {points}")
    spans = points - degree
    if kind == "UNIFORM_SURFACE":
        return np.arange(-degree, points + 1.0)
    if kind == "QUASI_UNIFORM_SURFACE":
        return np.concatenate([np.zeros(degree), np.arange(spans + 1.0), np.full(degree, spans)])
    if (points - 1) % degree:
        raise ValueError(f"expected {degree} n + 1 points of Bezier curves, got {points}")
    last = (points - 1) // degree
    return np.concatenate([[0], np.arange(last + 1.0).repeat(degree), [last]])


def _point(entities: Mapping[int, str], reference: Any) -> list[float]:
    number = int(str(reference)[1:])
    if number not in entities:
        raise ValueError(f"expected the point #{number}, got none")
    point = _parts(entities[number]).get("CARTESIAN_POINT")
    if point is None or len(point) < 2 or len(point[1]) != 3:
        raise ValueError(f"expected a point of three coordinates at #{number}, got another")
    return point[1]


def _parts(entity: str) -> dict[str, list[Any]]:
    """The values of each type of an entity, by the type's name: lists of numbers, texts, `#12` and lists of such."""
    found: dict[str, list[Any]] = {}
    open_lists: list[list[Any]] = []
    name, place = "", 0
    complex_entity = entity.startswith("(")
    while place < len(entity):
        match = _TOKEN.match(entity, place)
        if match is None:
            raise ValueError(f"expected values, got {entity[place : place + 20]!r}")
        place = match.end()
        token, kind = match[0].strip(), match.lastgroup
        if token == "(":
            made: list[Any] = []
            if open_lists:
                open_lists[-1].append(made)
            open_lists.append(made)
            if len(open_lists) == 1 + complex_entity:
                found[name] = made
        elif token == ")":
            if not open_lists:
                raise ValueError("expected a bracket to close, got none open")
            open_lists.pop()
        elif kind == "name":
            name = token.upper()
        elif token != "," and open_lists:
            open_lists[-1].append(float(token) if kind == "number" else token)
    if open_lists:
        raise ValueError("truncated: expected brackets to close, got the end")
    return found
