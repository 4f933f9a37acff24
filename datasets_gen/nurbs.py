"""NURBS models: read from .json, or made."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.names import FOLDERS
from lodbench.datasets_gen.read import FileError
from lodbench.datasets_gen.surfaces import NurbsModel, NurbsSurface

SUFFIXES = FOLDERS["nurbs"]


def read_nurbs(path: str | Path) -> NurbsModel:
    """A model from .json: `surfaces`, each with `degree_u degree_v knots_u knots_v control_points weights`.

    Control points are [i along u][j along v][x, y, z], Cartesian, not multiplied by the weights.

    Raises:
        FileError: no such file, an unknown suffix, no such keys, or a surface that is not valid.
    """
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise FileError(f"{path}: expected a suffix of {' '.join(SUFFIXES)}, got {path.suffix!r}")
    try:
        surfaces = json.loads(path.read_text("utf-8"))["surfaces"]
        return NurbsModel(
            tuple(
                NurbsSurface(
                    int(s["degree_u"]),
                    int(s["degree_v"]),
                    s["knots_u"],
                    s["knots_v"],
                    s["control_points"],
                    s["weights"],
                )
                for s in surfaces
            )
        )
    except FileNotFoundError:
        raise FileError(f"{path}: no such file") from None
    except (KeyError, IndexError) as error:
        raise FileError(f"{path}: expected a NURBS model, got no {error}") from error
    except (ValueError, TypeError, OSError) as error:
        raise FileError(f"{path}: {' '.join(str(error).split())}") from error


_CIRCLE = np.array([(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)])
_CIRCLE_WEIGHTS = np.array([1, 0.5**0.5] * 4 + [1])
_CIRCLE_KNOTS = np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], np.float64)


def cylinder(radius: float = 1.0, height: float = 2.0) -> NurbsModel:
    """An exact cylinder about z, one rational surface of degree 2 x 1, open at both ends."""
    ring = np.column_stack([radius * _CIRCLE, np.zeros(9)])
    points = np.stack([ring, ring + np.array([0, 0, height])], axis=1)
    weights = np.repeat(_CIRCLE_WEIGHTS[:, None], 2, axis=1)
    return NurbsModel((NurbsSurface(2, 1, _CIRCLE_KNOTS, [0, 0, 1, 1], points, weights),))


def ball() -> NurbsModel:
    """An exact unit sphere, one rational surface of degree 2 x 2 with collapsed edges at both poles."""
    half = np.array([(0, -1), (1, -1), (1, 0), (1, 1), (0, 1)])
    weights = np.array([1, 0.5**0.5, 1, 0.5**0.5, 1])
    flat = _CIRCLE[:, None] * half[None, :, :1]
    points = np.concatenate([flat, np.broadcast_to(half[None, :, 1:], (9, 5, 1))], axis=2)
    knots = [0, 0, 0, 1, 1, 2, 2, 2]
    total = _CIRCLE_WEIGHTS[:, None] * weights[None]
    return NurbsModel((NurbsSurface(2, 2, _CIRCLE_KNOTS, knots, points, total),))


def quilt(rows: int, columns: int, spans: int, seed: int = 0) -> NurbsModel:
    """An open wavy sheet of rows * columns bicubic surfaces of spans x spans knot spans, without cracks.

    Neighbours have the same control points on the edge that they share. All weights are 1.
    """
    knots = np.concatenate([np.zeros(3), np.arange(spans + 1), np.full(3, spans)]) / spans
    places = np.lib.stride_tricks.sliding_window_view(knots[1:-1], 3).mean(axis=1)
    places[[0, -1]] = 0.0, 1.0  # exactly, so that neighbours agree to the bit
    random = np.random.default_rng(seed)
    waves = random.normal(0, 2, (6, 2))
    shifts = random.uniform(0, 2 * np.pi, 6)

    def points(row: int, column: int) -> NDArray[np.float64]:
        x, y = np.meshgrid(column + places, row + places, indexing="ij")
        z = sum(0.08 * np.sin(a * x + b * y + c) for (a, b), c in zip(waves, shifts, strict=True))
        return np.stack([x, y, np.asarray(z)], axis=2)

    ones = np.ones((spans + 3, spans + 3))
    return NurbsModel(
        tuple(
            NurbsSurface(3, 3, knots, knots, points(row, column), ones)
            for row in range(rows)
            for column in range(columns)
        )
    )
