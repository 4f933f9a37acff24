"""Kernel sources: files joined with what they need, and the parameters that their kernels name."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from struct import Struct

import numpy as np

KERNELS = Path(__file__).parents[1]
PRELUDE = "common/prelude.cl"


@dataclass(frozen=True)
class Text:
    """A text that a user wrote, to be joined among the kernel files.

    Attributes:
        argument: that it came by; errors name it.
        text: OpenCL C.
        call: what calls it, joined behind it: an error in its first line, up to the brace, is of what was left open,
            one past that of what the text declares.
        declares: what it should declare, in an error's words.
    """

    argument: str
    text: str
    call: str = ""
    declares: str = ""

    @property
    def parts(self) -> dict[str, str]:
        """Name -> text; a backslash at the end of the user's must not join what follows to it."""
        return {self.argument: f"{self.text}\n", f"{self.argument}'s call": self.call}

    def blamed(self, log: str) -> str:
        """The error of a failed build in the words of an argument's; "" where the log tells of nothing in the text.

        What stands behind the text builds without it: an error there comes of something left open.
        """
        found = next((match.groupdict() for form in _ERRORS if (match := form.search(log))), None)
        if found is None:
            missing = _UNDEFINED.search(log)
            if missing is None or missing[1] not in self.text:
                return ""
            return f"{self.argument}: expected a definition of {missing[1]}, got none"
        file, message = found["file"], found["message"]
        if file == f"{self.argument}'s call" and int(found["line"]) > 1:
            return f"{self.argument}: expected {self.declares}, got another: {message}"
        expected = f"{self.argument}: expected OpenCL C that builds"
        if file == self.argument:
            return f"{expected}, line {found['line']}: {message}"
        if file in self.parts or (KERNELS / file).is_file():
            return f"{expected}, got an error behind it, as where a bracket is left open: {message}"
        return f"{expected}, {file} line {found['line']}: {message}"


_PLACE = r"(?P<file>[^:\n]+):(?P<line>\d+):\d+:"
_ERRORS = (  # of PoCL, and of other compilers
    re.compile(rf"^error: {_PLACE} (?P<message>.+)$", re.M),
    re.compile(rf"^{_PLACE} (?:fatal )?error: (?P<message>.+)$", re.M),
)
_UNDEFINED = re.compile(r"(?:Cannot find symbol|Symbols not found: \[) (\w+)")


def texts_of(files: Iterable[str | Path | Text], prelude: bool = False) -> dict[str, str]:
    """File name -> text of these kernel files, relative to `kernels/`, in the order in which they are joined.

    Files named on a `// Needs` line come before the one that needs them, and the prelude before all.
    """
    texts: dict[str, str] = {}
    for file in [PRELUDE, *files] if prelude else files:
        if isinstance(file, Text):
            texts |= file.parts
        else:
            _join(str(file), texts)
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
    space: str  # "global", "constant", "local", "image" or "" for a value
    scalar: np.dtype
    lanes: int

    @cached_property
    def likes(self) -> frozenset[str]:
        """The codes of numpy's dtypes that are as wide, and floats or not, as a lane."""
        return frozenset(
            char
            for char in "?" + np.typecodes["AllInteger"] + np.typecodes["Float"]
            if np.dtype(char).itemsize == self.scalar.itemsize
            and (np.dtype(char).kind == "f") == (self.scalar.kind == "f")
        )

    @cached_property
    def types(self) -> frozenset[str]:
        """`likes` of a pointer to a buffer; none of another parameter."""
        return self.likes if self.space in ("global", "constant") else frozenset()

    @cached_property
    def layout(self) -> Struct:
        """A value's bytes: vectors of three have room for four."""
        return Struct(
            f"{self.lanes}{self.scalar.char}{self.scalar.itemsize if self.lanes == 3 else 0}x"
        )


_SCALARS = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "long": "i8", "ulong": "u8", "float": "f4", "double": "f8", "half": "f2", "image2d_t": "f4",
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
            space = "image" if "image2d_t" in words else space
            lanes = int(kind[2] or 1)
            parameters.append(Parameter(words[-1], space, np.dtype(_SCALARS[kind[1]]), lanes))
        found[name] = tuple(parameters)
    return found
