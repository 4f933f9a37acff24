"""Kernel sources: files joined with what they need, and the parameters that their kernels name."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

KERNELS = Path(__file__).parents[1]
PRELUDE = "common/prelude.cl"


def texts_of(files: Iterable[str | Path], prelude: bool = False) -> dict[str, str]:
    """File name -> text of these kernel files, relative to `kernels/`, in the order in which they are joined.

    Files named on a `// Needs` line come before the one that needs them, and the prelude before all.
    """
    texts: dict[str, str] = {}
    for file in ([PRELUDE] if prelude else []) + [str(file) for file in files]:
        _join(file, texts)
    return texts


def _join(file: str, texts: dict[str, str]) -> None:
    if file in texts:
        return
    text = (KERNELS / file).read_text("utf-8")
    for line in re.findall(r"^// Needs +(.*)$", text, re.M):
        for needed in re.split(r"[,\s]+", line.strip()):
            _join(needed, texts)
    texts[file] = text


@dataclass(frozen=True)
class Parameter:
    """One parameter of a kernel, read from its source: `scalar` is the numpy dtype of one lane."""

    name: str
    space: str  # "global", "constant", "local" or "" for a value
    scalar: np.dtype
    lanes: int


_SCALARS = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "long": "i8", "ulong": "u8", "float": "f4", "double": "f8", "half": "f2",
}  # fmt: skip
_KERNEL = re.compile(
    r"__kernel\s+(?:__attribute__\s*\(\(.*?\)\)\s*)*void\s+(\w+)\s*\(([^)]*)\)", re.S
)
_COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.S)
_TYPE = re.compile(r"\b(" + "|".join(_SCALARS) + r")(2|3|4|8|16)?\b")


def kernel_parameters(source: str) -> dict[str, tuple[Parameter, ...]]:
    """Every kernel of an OpenCL C source with its parameters, in order."""
    found = {}
    for name, inside in _KERNEL.findall(_COMMENT.sub(" ", source)):
        parameters = []
        for text in filter(None, (part.strip() for part in inside.split(","))):
            kind = _TYPE.search(text)
            words = re.findall(r"\w+", text)
            if kind is None:
                raise ValueError(f"{name}: expected a built-in scalar or vector type, got {text!r}")
            space = next((s for s in ("global", "constant", "local") if f"__{s}" in words), "")
            lanes = int(kind[2] or 1)
            parameters.append(Parameter(words[-1], space, np.dtype(_SCALARS[kind[1]]), lanes))
        found[name] = tuple(parameters)
    return found
