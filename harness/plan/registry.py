"""Every system and baseline there is, found by walking the packages; importing one never touches a device."""

from __future__ import annotations

import dataclasses
import importlib
import pkgutil
import traceback
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any

from lodbench.kernels import verbs
from lodbench.kernels.parameters import closest
from lodbench.kernels.system import System
from lodbench.kernels.targets import TARGETS, Target

BASELINES = "lodbench.harness.baselines"


@dataclass(frozen=True)
class Registry:
    """`systems` by name; `missing` says why a folder that should hold one could not be imported."""

    systems: dict[str, System[Any]] = field(default_factory=dict)
    missing: dict[str, str] = field(default_factory=dict)


def _packages(name: str) -> Iterator[str]:
    """Full names of the packages and modules directly inside package `name`."""
    try:
        package = importlib.import_module(name)
    except ModuleNotFoundError:
        return
    for found in pkgutil.iter_modules(package.__path__):
        if not found.name.startswith("_"):
            yield f"{name}.{found.name}"


def _candidates() -> Iterator[str]:
    yield from verbs.packages().values()
    yield from _packages(BASELINES)
    yield from _packages(f"{BASELINES}.gl")


@cache
def registry() -> Registry:
    """All that was found, in the order of the folders' names; the walk is done once.

    Raises:
        ValueError: two folders declare the same name, or one cannot be imported: folder, file and line are named.
    """
    found = Registry()
    for module_name in _candidates():
        name = module_name.rsplit(".", 1)[1]
        try:
            module = importlib.import_module(module_name)
        except ImportError as error:  # an optional package; anything else is a fault and is shown
            found.missing[name] = str(error)
            continue
        except Exception as error:
            last = traceback.extract_tb(error.__traceback__)[-1]
            at = error if isinstance(error, SyntaxError) else last
            raise ValueError(
                f"{module_name}: expected a folder that can be imported, got {type(error).__name__} in "
                f"{at.filename}, line {at.lineno}: {error}"
            ) from error
        system = getattr(module, "SYSTEM", None)
        if not isinstance(system, System):
            continue
        if system.name in found.systems:
            raise ValueError(f"{module_name}: expected a new name, got {system.name!r} again")
        found.systems[system.name] = system
    return found


def systems() -> dict[str, System[Any]]:
    """Every system and baseline that can be imported here, by name."""
    return registry().systems


def system(name: str) -> System[Any]:
    """The system of this name.

    Raises:
        ValueError: no such system; names close to it are in the text.
    """
    found = registry()
    if name in found.systems:
        return found.systems[name]
    if name in found.missing:
        raise ValueError(f"system: {name} cannot be used here: {found.missing[name]}")
    raise ValueError(closest("system", name, [*found.systems, *found.missing]))


def parameters(owner: System[Any], case: str | None, overrides: Mapping[str, Any]) -> Any:
    """A case of `owner` (None: its first) with some fields replaced; lists become tuples.

    At most one target counts: one that is given clears those of the case.

    Raises:
        ValueError: no such case or field, or a value that the system's Params refuse.
    """
    if case is not None and case not in owner.cases:
        raise ValueError(closest(f"case of {owner.name}", case, owner.cases))
    params = next(iter(owner.cases.values())) if case is None else owner.cases[case]
    names = [field.name for field in dataclasses.fields(params)]
    for name in overrides:
        if name not in names:
            raise ValueError(closest(f"parameter of {owner.name}", name, names))
    values = {k: tuple(v) if isinstance(v, list) else v for k, v in overrides.items()}
    if isinstance(params, Target) and any(values.get(name) is not None for name in TARGETS):
        values = {name: None for name in TARGETS if name in names} | values
    return dataclasses.replace(params, **values)
