"""NURBS models as people have them: the surfaces of .json, IGES and STEP files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from lodbench.datasets_gen.iges import parse_iges
from lodbench.datasets_gen.names import FOLDERS
from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface
from lodbench.datasets_gen.read import FileError
from lodbench.datasets_gen.step import parse_step

SUFFIXES = FOLDERS["nurbs"]


def read_nurbs(path: str | Path) -> NurbsModel:
    """The model in a file, without its trims, which the model's notes mention.

    - .json: `surfaces`, each with `degree_u degree_v knots_u knots_v control_points weights`, control points as
      [i along u][j along v][x, y, z], Cartesian, not multiplied by the weights
    - .igs, .iges: entities 128 (rational B-spline surface)
    - .stp, .step: B_SPLINE_SURFACE_WITH_KNOTS, BEZIER_, QUASI_UNIFORM_ and UNIFORM_SURFACE, also rational

    Raises:
        FileError: no such file, an unknown suffix, truncated, no such surfaces, or a surface that is not valid.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise FileError(f"{path}: expected a suffix of {' '.join(SUFFIXES)}, got {path.suffix!r}")
    try:
        data = path.read_bytes()
        if not data:
            raise ValueError("the file is empty (0 bytes)")
        if suffix == ".json":
            return _json_model(json.loads(data))
        text = data.decode("latin-1")
        return parse_step(text) if suffix in (".stp", ".step") else parse_iges(text)
    except FileNotFoundError:
        raise FileError(f"{path}: no such file") from None
    except (KeyError, IndexError) as error:
        raise FileError(f"{path}: expected a NURBS model, got no {error}") from error
    except (ValueError, TypeError, OSError, RecursionError, OverflowError, MemoryError) as error:
        raise FileError(f"{path}: {' '.join(str(error).split())[:300]}") from error


def _json_model(document: Any) -> NurbsModel:
    surfaces, names = [], []
    if not isinstance(document, dict):
        raise ValueError(f"expected an object with `surfaces`, got {type(document).__name__}")
    for k, given in enumerate(document["surfaces"]):
        if not isinstance(given, dict):
            raise ValueError(f"surface {k}: expected an object, got {type(given).__name__}")
        name = str(given.get("name") or f"surface_{k}")
        try:
            surfaces.append(
                NurbsSurface(
                    given["degree_u"],
                    given["degree_v"],
                    given["knots_u"],
                    given["knots_v"],
                    given["control_points"],
                    given.get("weights"),
                )
            )
        except (ValueError, TypeError) as error:
            raise type(error)(f"surface {name}: {error}") from None
        names.append(name)
    return NurbsModel(tuple(surfaces), tuple(names))
