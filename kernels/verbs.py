"""What users ask for by a verb, and which system answers; systems declare their verbs, and none is named elsewhere."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

from lodbench.kernels.result import Left, Result
from lodbench.kernels.system import System

VERBS = ("simplify", "refine", "tessellate")
PREFERRED = {
    "simplify": ("auto", "quadric_clustering", "quadtree_lod"),
    "refine": ("pattern",),
    "tessellate": ("vst", "uniform_nurbs"),
}
"""Where no method is named, the first of these that takes the surface."""


@cache
def packages() -> dict[str, str]:
    """The package of every folder that may hold a system, by the folder's name; none is imported."""
    folders = sorted(path.parent for path in Path(__file__).parent.glob("*/*/__init__.py"))
    return {path.name: f"lodbench.kernels.{path.parent.name}.{path.name}" for path in folders}


@cache
def declared(name: str) -> System[Any] | None:
    """The system that the folder of this name declares; None where there is no such folder, or no system in it."""
    if name not in packages():
        return None
    found = getattr(importlib.import_module(packages()[name]), "SYSTEM", None)
    return found if isinstance(found, System) else None


def _answering(verb: str) -> Iterator[System[Any]]:
    """All systems that declare the verb; imports every one, to say which there are."""
    for name in packages():
        system = declared(name)
        if system is not None and verb in system.verbs:
            yield system


def answering(verb: str, name: str | None, surface: Any) -> System[Any]:
    """The system that does `verb` to `surface`: that of this name, or the preferred one.

    Raises:
        ValueError: no system of this name does that.
        TypeError: the system, or every one, takes other surfaces.
    """
    kind = type(surface).__name__
    for preferred in PREFERRED[verb] if name is None else (name,):
        system = declared(preferred)
        if system is None or verb not in system.verbs:
            able = ", ".join(system.name for system in _answering(verb))
            raise ValueError(f"method: expected one of {able}, got {preferred!r}")
        if isinstance(surface, system.takes):
            return system
    able = ", ".join(s.name for s in _answering(verb) if isinstance(surface, s.takes))
    if not able:
        raise TypeError(f"{verb}: expected a surface that some system takes, got {kind}")
    raise TypeError(f"method: expected {able} for a {kind}, got {name or 'none'}")


def method(verb: str, name: str | None, surface: Any) -> Callable[..., Result]:
    """The function with which `answering` does that; its errors are the same."""
    return answering(verb, name, surface).verbs[verb]


def streaming(name: str | None) -> Callable[..., Left]:
    """What simplifies a file in batches: that of the system `name`, or of the preferred one.

    Raises:
        ValueError: no system of this name does that.
    """
    system = declared(streaming_method() if name is None else name)
    if system is not None and system.streams is not None:
        return system.streams
    able = ", ".join(s.name for s in _answering("simplify") if s.streams is not None)
    raise ValueError(f"method: expected {able} out of core, got {name!r}")


def streaming_method() -> str:
    """The first of the preferred systems that simplifies a file in batches."""
    systems = map(declared, PREFERRED["simplify"])
    return next(s.name for s in systems if s is not None and s.streams is not None)
