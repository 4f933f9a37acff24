"""A run's folder may come from anywhere: what is in it is checked here, once, where it is read.

Names become parts of paths, so they have letters that mean nothing to a file system; no link leads out of the folder;
and every field that tables, figures and the report look at has the type that a record gives it.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

NAME = re.compile(r"[a-z0-9_]+")
STATUSES = ("ok", "skipped", "failed")
LARGEST = 1e18  # of a number: what is made of some stays finite
DEEPEST = 20  # objects and lists within one another

_Number = (int, float, type(None))
_Count = (int, type(None))
_Text = (str, type(None))
_CELL = (str, int, float, bool, list, type(None))
_GROUP = {"group": str, "attempt": int}
_NUMBERS = {"*": _Number}
_SAMPLE = {
    **_GROUP, "subject": str, "turn": int, "warmup": bool, "wall_s": (int, float), "cpu_s": (int, float),
    "stage_s": {"*": (int, float)},
}  # fmt: skip
_RATE = {"subject": str, "unit": str, "best": _Number, "median": (int, float), "samples": list}
_COLUMN = {"key": NAME, "label": str, "unit": str}

# a field's name, with "?" where it may be absent, and what it holds: types, a pattern, an object's fields ("*" for all
# of any name), or a list's one kind of items
ROWS: dict[str, dict[str, Any]] = {
    "begin": {
        **_GROUP, "table": NAME, "name": str, "dataset": str, "device": str, "facts": dict,
        "config": {"subjects?": [{"label": str, "system": str}]},
    },
    "setup": {
        **_GROUP, "subject": str, "system?": str, "params?": dict, "phases?": _NUMBERS,
        "from_cache?": {"*": bool}, "memory_growth_bytes?": _Count,
    },
    "sample": _SAMPLE,
    "frame": {**_SAMPLE, "step?": int, "triangles?": _Number, "moved?": float},
    "subject": {
        **_GROUP, "subject": str, "status": STATUSES, "reason": str, "counters?": _NUMBERS,
        "footprint?": _NUMBERS, "traffic?": {"*": {"bytes": int, "flops": int}},
        "quality?": (dict, type(None)), "check?": (dict, type(None)), "read_back_s?": _Number,
        "peak_growth_bytes?": _Count, "frame_reason?": str, "driver?": str,
        "exact?": {"*": {"value": _Number, "limit": _Number, "looked_at": str}},
    },
    "end": {**_GROUP, "others": _Number, "seconds?": _Number, "cut?": bool},
    "superseded": _GROUP,
    "limits": {
        "device": str, "size_bytes": int, "fill": _RATE, "copy": _RATE, "multiply_add": _RATE,
        "launch_wall?": _RATE, "launch_event?": _RATE,
    },
}  # fmt: skip
RUN_FIELDS: dict[str, Any] = {
    "schema": int, "started": str, "commit": NAME, "seed": int, "slug?": str, "resumed?": [str],
    "options": {"samples?": _Count, "precision?": _Number, "time_budget?": _Number, "sweep?": (dict, type(None))},
    "device": {"name": str, "platform": str, "kind": str, "compute_units?": _Count},
    "machine": {"cpu?": _Text}, "packages?": {"*": _Text}, "variables?": {"*": str},
}  # fmt: skip
TABLE_FIELDS: dict[str, Any] = {
    "id": NAME, "title": str, "source": str, "device": str, "columns": [_COLUMN], "notes?": [str],
    "rows": [{"system": str, "status": (*STATUSES, "noisy", "published"), "reason?": _Text, "*": _CELL}],
}  # fmt: skip
PICTURE_FIELDS: list[Any] = [
    {"file": str, "caption": str, "series?": str, "table?": str, "level?": int, "name?": str}
]


def check(value: Any, kind: Any, where: str) -> None:
    """Refuse a value that is not of the kind that this module's tables give.

    Raises:
        ValueError: with `where`, the field, what was expected and what came.
    """
    if isinstance(kind, re.Pattern):
        if not isinstance(value, str) or not kind.fullmatch(value):
            raise ValueError(f"{where}: expected a name of {kind.pattern}, got {_short(value)}")
    elif isinstance(kind, Mapping):
        if not isinstance(value, dict):
            raise ValueError(f"{where}: expected an object, got {_short(value)}")
        _check_fields(value, kind, where)
    elif isinstance(kind, list):
        if not isinstance(value, list):
            raise ValueError(f"{where}: expected a list, got {_short(value)}")
        for number, item in enumerate(value):
            check(item, kind[0], f"{where}[{number}]")
    elif isinstance(kind, tuple) and isinstance(kind[0], str):
        if value not in kind:
            raise ValueError(f"{where}: expected one of {', '.join(kind)}, got {_short(value)}")
    else:
        kinds = kind if isinstance(kind, tuple) else (kind,)
        if not isinstance(value, kinds) or (isinstance(value, bool) and bool not in kinds):
            names = " or ".join("null" if k is type(None) else k.__name__ for k in kinds)
            raise ValueError(f"{where}: expected {names}, got {_short(value)}")
        check_plain(value, where)


def check_plain(value: Any, where: str, room: int = DEEPEST) -> None:
    """Refuse numbers and nesting, at any depth, that sums and the report would choke on.

    Raises:
        ValueError: with `where` and what came.
    """
    if isinstance(value, dict | list):
        if not room:
            raise ValueError(f"{where}: expected at most {DEEPEST} levels, got more")
        for item in value.values() if isinstance(value, dict) else value:
            check_plain(item, where, room - 1)
    elif isinstance(value, int | float) and not -LARGEST <= value <= LARGEST:
        raise ValueError(f"{where}: expected a number within {LARGEST:g}, got {_short(value)}")


def _check_fields(value: Mapping[str, Any], kind: Mapping[str, Any], where: str) -> None:
    for field, inside in kind.items():
        name = field.removesuffix("?")
        if field == "*":
            for key in value.keys() - {other.removesuffix("?") for other in kind}:
                check(value[key], inside, f"{where}: {key}")
        elif name in value:
            check(value[name], inside, f"{where}: {name}")
        elif name == field:
            raise ValueError(f"{where}: expected the field {name}, got none")


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}..."


def check_row(row: Any, where: str) -> None:
    """Refuse a row of `samples.jsonl` that a record would not hold.

    Raises:
        ValueError: see `check`; or an unknown kind.
    """
    check(row, {"kind": tuple(ROWS)}, where)
    check(row, ROWS[row["kind"]], where)


def check_table(made: Any, where: str) -> None:
    """Refuse a table's document that no run writes.

    Raises:
        ValueError: see `check`; or a row without the field of a column.
    """
    check(made, TABLE_FIELDS, where)
    for number, row in enumerate(made["rows"]):
        for column in made["columns"]:
            if column["key"] not in row:
                text = f"{where}: rows[{number}]: expected the field {column['key']}, got none"
                raise ValueError(text)


def parse_json(text: bytes, where: str) -> Any:
    """What the text holds.

    Raises:
        ValueError: it is not JSON, or holds NaN or infinity.
    """
    try:
        return json.loads(text, parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        text = b" ".join(text[:40].split())
        raise ValueError(f"{where}: expected JSON, got {text!r}: {error}") from None


def _refuse(word: str) -> None:
    raise ValueError(f"{word} is no number")


def read_json(path: Path, kind: Any) -> Any:
    """The checked content of a JSON file in a run's folder.

    Raises:
        ValueError: not JSON, or not of the kind; one line that names the file and the field.
        OSError: it cannot be read.
    """
    found = parse_json(path.read_bytes(), str(path))
    check(found, kind, str(path))
    check_plain(found, str(path))
    return found


def refuse_links(folder: Path) -> None:
    """Refuse a folder with a link that leads out of it, or a pipe: nothing outside is read or written through it.

    Raises:
        ValueError: there is one.
    """
    home = folder.resolve()
    for path in sorted(folder.rglob("*")):
        if path.is_symlink() and not path.resolve().is_relative_to(home):
            raise ValueError(f"{path}: expected files of the run's own, got a link out of {folder}")
        if path.exists() and not path.is_file() and not path.is_dir():
            raise ValueError(f"{path}: expected files and folders, got a pipe or a device")


@contextmanager
def blamed_on(path: Path, what: str) -> Iterator[None]:
    """What goes wrong within is the file's fault: the error names it, and what it should have held."""
    try:
        yield
    except ValueError as error:
        text = " ".join(str(error).split())
        raise ValueError(text if str(path) in text else f"{path}: {text}") from error
    except (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError) as error:
        text = f"{type(error).__name__}: {' '.join(str(error).split())}"
        raise ValueError(f"{path}: expected {what}, got {text}") from error
