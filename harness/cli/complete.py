"""What the tab key offers: names read off folders and files, without importing what bears them."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import fields
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from lodbench.datasets_gen import names

COLOURS = ("smooth", "flat", "wireframe", "triangle", "vertex")
PATHS = ("turntable", "orbit", "fly_through")
DISPLACEMENTS = ("sine", "perlin", "turbulence")
RAISING = (".cl", ".png", ".npy")
MODES = ("coarse_to_fine", "cmcf", "ray")
MESHES = (*names.FOLDERS["meshes"], *names.FOLDERS["bezier"], *names.FOLDERS["nurbs"])


def _folder(package: str) -> Path:
    spec = find_spec(package)  # imports the packages above it, and those are empty
    assert spec is not None and spec.submodule_search_locations
    return Path(next(iter(spec.submodule_search_locations)))


def _that_say(pattern: str, files: Iterator[Path]) -> list[Path]:
    """The files that have a line which begins like this."""
    return sorted(path for path in files if re.search(f"(?m)^{pattern}", path.read_text("utf-8")))


def systems() -> list[str]:
    """Systems and baselines."""
    baselines = _folder("lodbench.harness") / "baselines"
    found = _that_say("SYSTEM\\b", _folder("lodbench.kernels").glob("*/*/__init__.py"))
    found += _that_say("SYSTEM\\b", baselines.rglob("__init__.py"))
    return [path.parent.name for path in found]


def tables() -> list[str]:
    """Tables that `reproduce` makes."""
    found = (_folder("lodbench.harness") / "tables").glob("*.py")
    return [path.stem for path in _that_say("TABLE\\b", found)]


def _methods(verb: str) -> list[str]:
    found = _folder("lodbench.kernels").glob("*/*/__init__.py")
    return [path.parent.name for path in _that_say(f'    verbs=.*"{verb}"', found)]


def simplify_methods() -> list[str]:
    """What `simplify --method` takes."""
    return _methods("simplify")


def refine_methods() -> list[str]:
    """What `refine --method` takes."""
    return _methods("refine")


def tessellate_methods() -> list[str]:
    """What `tessellate --method` takes."""
    return _methods("tessellate")


def drawing_methods() -> list[str]:
    """What `render --refine` takes."""
    return [*_methods("refine"), *_methods("tessellate")]


def displacements() -> tuple[str, ...]:
    """Kinds that `refine --displace` takes, each with its sign, and files of the folder one is in."""
    here = (path.name for path in Path().iterdir() if path.suffix.lower() in RAISING)
    return (
        *(f"{kind}:" for kind in DISPLACEMENTS),
        *sorted(name if name.endswith(".cl") else f"{name}:" for name in here),
    )


def datasets() -> list[str]:
    """Datasets, and mesh files of the folder one is in; where none fits, the shell offers its own."""
    here = (path.name for path in Path().iterdir() if path.suffix.lower() in MESHES)
    return [*names.standard_names(), *sorted(here)]


def dataset_names() -> list[str]:
    """Datasets alone."""
    return names.standard_names()


def scans() -> list[str]:
    """What `datasets fetch` downloads."""
    from lodbench.datasets_gen.fetch import SCANS

    return list(SCANS)


def formats() -> list[str]:
    """Mesh formats that are written."""
    return [suffix[1:] for suffix in names.FOLDERS["meshes"]]


def colours() -> tuple[str, ...]:
    """What `render --colour` takes."""
    return COLOURS


def paths() -> tuple[str, ...]:
    """What `render --path` takes."""
    return PATHS


def modes() -> tuple[str, ...]:
    """What `geometry-image --mode` takes."""
    return MODES


def _system_cases() -> Mapping[str, Any]:
    """Cases of the first system on the line that is being typed: the parser stops short of it."""
    from lodbench.harness.plan import registry

    line = f"{os.environ.get('COMP_WORDS', '')} {os.environ.get('_TYPER_COMPLETE_ARGS', '')}"
    known = registry.systems()
    return next((known[word].cases for word in line.split() if word in known), {})


def cases() -> list[str]:
    """Cases of the system on the line."""
    return list(_system_cases())


def settings() -> list[str]:
    """Parameters of the system on the line, each with its sign."""
    params = next(iter(_system_cases().values()), None)
    return [f"{field.name}=" for field in fields(params)] if params else []


def devices() -> list[tuple[str, str]]:
    """OpenCL devices by the first word of their name, with all of it."""
    from lodbench.kernels.opencl import driver

    return [
        (device.split()[0], f"{device} ({index})") for index, _, device, _ in driver.list_devices()
    ]
