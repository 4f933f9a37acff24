"""One validation of arguments and of every system's Params: against their annotations, in one form of words."""

from __future__ import annotations

import dataclasses
import difflib
import inspect
import re
import types
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from numbers import Integral, Real
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np

P = TypeVar("P", bound="Parameters")
LARGEST = float(np.finfo(np.float64).max)
PLAIN = frozenset((bool, int, float, str, type(None)))
LONGEST = 60  # characters of a value that an error repeats


@dataclass(frozen=True)
class Range:
    """Which numbers an `Annotated[int, Range(1, 4)]` takes: both ends belong to it, unless said to be `open`."""

    low: float
    high: float | None = None
    open: str = ""  # "low", "high"

    def __contains__(self, value: float) -> bool:
        above = value > self.low if self.open == "low" else value >= self.low
        if self.high is None:
            return above
        return above and (value < self.high if self.open == "high" else value <= self.high)

    def __str__(self) -> str:
        if self.high is None:
            return f"more than {self.low:g}" if self.open == "low" else f"at least {self.low:g}"
        low = f"above {self.low:g}" if self.open == "low" else f"{self.low:g}"
        return f"{low} to {'below ' if self.open == 'high' else ''}{self.high:.10g}"


def _words(kind: Any) -> str:
    """The annotation as people say it."""
    simple = {
        int: "a whole number", float: "a number", bool: "True or False", str: "text", type(None): "None",
        tuple: "rows of numbers",
    }  # fmt: skip
    if kind in simple:
        return simple[kind]
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return f"{_words(arguments[0])}, {arguments[1]}"
    if origin is Literal:
        return f"one of {', '.join(map(str, arguments))}"
    if origin in (Union, types.UnionType):
        return " or ".join(_words(argument) for argument in arguments)
    if origin is tuple:
        return f"({', '.join(_words(argument) for argument in arguments)})"
    return getattr(kind, "__name__", str(kind))


def plain(value: Any) -> Any:
    """The scalars and one-dimensional arrays of numpy as Python's; others as they are."""
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim < 2):
        return value.tolist()
    return value


def shown(value: Any) -> str:
    """The value on one line, cut where it is long."""
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # a whole number with more digits than Python writes
        text = type(value).__name__
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


@cache
def _parts(kind: Any) -> tuple[Any, tuple[Any, ...]]:
    return get_origin(kind), get_args(kind)


def check(name: str, value: Any, kind: Any) -> Any:
    """`value` as the annotation `kind` has it: numpy's numbers become Python's, a list a tuple.

    Args:
        name: of the argument, for the error.
        value: what came.
        kind: int, float (finite; takes whole numbers too), bool, str, None, Literal of texts, Annotated with a `Range`,
            a tuple of such, a union of such, or a class.

    Raises:
        TypeError: another type; a float is no whole number even where its value is, and True no number.
        ValueError: a text or number out of range, NaN or infinity.
    """
    if kind is Any or (type(value) is kind and kind is not float):
        return value
    origin, arguments = _parts(kind)
    value = plain(value)
    if origin is Annotated:
        found = check(name, value, arguments[0])
        if found not in arguments[1]:
            raise ValueError(f"{name}: expected {arguments[1]}, got {shown(value)}")
        return found
    if origin is Literal:
        if type(value) not in map(type, arguments):
            raise TypeError(f"{name}: expected {_words(kind)}, got {shown(value)}")
        if value not in arguments:
            raise ValueError(f"{name}: expected {_words(kind)}, got {shown(value)}")
        return value
    if origin in (Union, types.UnionType):
        return _of_union(name, value, kind)
    if origin is tuple and isinstance(value, tuple | list):
        if len(value) == len(arguments):
            return tuple(check(name, v, k) for v, k in zip(value, arguments, strict=True))
    elif kind is int and isinstance(value, Integral) and not isinstance(value, bool):
        return int(value)
    elif kind is float and isinstance(value, Real) and not isinstance(value, bool):
        if not abs(value) <= LARGEST:  # pyright: ignore[reportOperatorIssue]
            raise ValueError(f"{name}: expected a finite number, got {shown(value)}")
        return int(value) if isinstance(value, Integral) else float(value)
    elif kind is bool and isinstance(value, bool):
        return value
    elif origin is None and kind not in (int, float, bool) and isinstance(value, kind):
        return value
    raise TypeError(f"{name}: expected {_words(kind)}, got {shown(value)}")


def _of_union(name: str, value: Any, kind: Any) -> Any:
    arguments = _parts(kind)[1]
    if value is None and type(None) in arguments:
        return None
    if type(value) in arguments:
        return check(name, value, type(value))
    for argument in arguments:
        if argument is type(None):
            continue
        try:
            return check(name, value, argument)
        except TypeError:
            continue
    raise TypeError(f"{name}: expected {_words(kind)}, got {shown(value)}")


def closest(argument: str, got: str, names: Iterable[str]) -> str:
    """The text of an error about an unknown name: the nearest names, or all when none is near."""
    names = sorted(names)
    near = difflib.get_close_matches(got, names, n=3, cutoff=0.5)
    near += [name for name in names if got and got in name and name not in near]
    kind = "one like" if near else "one of"
    return f"{argument}: expected {kind} {', '.join(near or names)}, got {got!r}"


@cache
def _defaults(owner: type) -> Mapping[str, Any]:
    return {field.name: field.default for field in dataclasses.fields(owner)}


@cache
def _kinds(owner: type) -> Mapping[str, Any]:
    hints = get_type_hints(owner, include_extras=True)
    return {field.name: hints[field.name] for field in dataclasses.fields(owner)}


def described(owner: type) -> list[dict[str, str]]:
    """Each field of a Params: its name, what it takes, its default, and what its docstring says of it."""
    texts: dict[str, str] = {}
    for base in reversed(owner.__mro__):
        text, _, attributes = (inspect.getdoc(base) or "").partition("Attributes:\n")
        texts |= re.findall(r"(?s)`(\w+)`: (.*?)(?=; `\w+`: |\.\s|\.?\Z)", text)
        for names, text in re.findall(r"(?ms)^ {4}(\w[\w, ]*): (.*?)(?=^ {4}\w|\Z)", attributes):
            texts |= {name.strip(): " ".join(text.split()) for name in names.split(",")}
    return [
        {
            "parameter": field.name,
            "takes": _words(_kinds(owner)[field.name]),
            "default": str(field.default),
            "meaning": texts.get(field.name, ""),
        }
        for field in dataclasses.fields(owner)
    ]


@dataclass(frozen=True)
class Parameters:
    """The base of every system's Params: each field is checked against its annotation when one is made.

    Defaults are taken as they are: to look at every field of a clustering takes longer than to upload its mesh.

    Raises:
        TypeError, ValueError: see `check`.
    """

    def __post_init__(self) -> None:
        defaults = _defaults(type(self))
        for name, kind in _kinds(type(self)).items():
            if (value := getattr(self, name)) is not defaults[name]:
                object.__setattr__(self, name, check(name, value, kind))

    @classmethod
    def named(cls: type[P], **values: Any) -> P:
        """As the class itself, for names that a user wrote; plain values that came before are not checked anew.

        Raises:
            TypeError: an unknown name, with those close to it.
        """
        if all(type(value) in PLAIN for value in values.values()):
            return _named(cls, tuple((name, type(v), v) for name, v in values.items()))
        return cls._of_names(values)

    @classmethod
    def _of_names(cls: type[P], values: Mapping[str, Any]) -> P:
        for name in values:
            if name not in _kinds(cls):
                raise TypeError(closest("option", name, _kinds(cls)))
        return cls(**values)


@lru_cache(128)
def _named(owner: type[P], values: tuple[tuple[str, type, Any], ...]) -> P:
    """`Parameters.named`: the types tell 1 from True and 1.0, which are equal."""
    return owner._of_names({name: value for name, _, value in values})
