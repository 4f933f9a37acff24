"""Systems x datasets x parameters: one table whose axes come from a TOML file or from the command line.

```toml
name = "cluster_grids"
systems = ["quadric_clustering", "numpy_quadric_clustering"]   # the first is the one that ratios refer to
datasets = ["icosphere_5", "scans/torso.ply"]   # files are found from the folder of this one
devices = ["pocl"]              # one run folder each; optional
quality = true                  # error and topology of every result mesh; optional
seeds = [0, 1, 2]               # an axis for every system: of what is random in it, and of its errors; optional
[params]                        # a list is an axis; for every system that has the parameter
cells = [32, 64, [90, 60, 30]]
[params.quadric_clustering]     # for one system
strategy = ["fused", "separate"]
```
"""

from __future__ import annotations

import dataclasses
import itertools
import re
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import BezierPatches, NurbsModel, TriangleMesh
from lodbench.harness.plan import registry
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.plan.table import (
    QUALITY_COLUMNS,
    STATUS_COLUMNS,
    WALL_COLUMNS,
    Column,
    Table,
    brief,
    ratio_columns,
)
from lodbench.harness.record.foreign import NAME, blamed_on, check

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib  # pyright: ignore[reportMissingImports]  the same module, before 3.11

KINDS = {
    "name": NAME, "systems": [str], "datasets": [str], "devices?": [str], "quality?": bool, "case?": str,
    "seeds?": [int], "params?": dict,
}  # fmt: skip
KEYS = tuple(key.removesuffix("?") for key in KINDS)


def read(path: Path) -> dict[str, Any]:
    """A sweep's specification from a TOML file.

    Raises:
        ValueError: not TOML, an unknown key, or one of the wrong kind.
        OSError: the file cannot be read.
    """
    try:
        spec = tomllib.loads(path.read_text("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise ValueError(f"{path}: expected TOML, got {error}") from None
    spec.setdefault("name", re.sub(r"[^a-z0-9]+", "_", path.stem.lower()).strip("_") or "sweep")
    with blamed_on(path, "a sweep"):
        return with_files(validate(spec), path.parent)


def with_files(spec: dict[str, Any], folder: Path) -> dict[str, Any]:
    """`spec` with mesh files among its datasets, relative to `folder`, under the names that the records have for them.

    Raises:
        FileError: no such file.
    """
    names = [
        catalogue.adopt(folder / Path(name).expanduser()).name if catalogue.is_file(name) else name
        for name in spec["datasets"]
    ]
    return {**spec, "datasets": list(dict.fromkeys(names))}


def literal(text: str) -> Any:
    """A value as TOML writes it (`64`, `[32, 64]`, `true`, `"fused"`), or the text itself."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def validate(spec: dict[str, Any]) -> dict[str, Any]:
    """`spec` with everything in place, or an error that names the key."""
    for key in spec:
        if key not in KEYS:
            raise ValueError(registry.closest("key", key, KEYS))
    for key in ("systems", "datasets"):
        names = spec.get(key)
        if not isinstance(names, list) or not names or not all(isinstance(n, str) for n in names):
            raise ValueError(f"{key}: expected a list of names, got {names!r}")
    check(spec, KINDS, "sweep")
    shared, own = _split(spec)
    if any(seed < 0 for seed in spec.get("seeds", [])):
        raise ValueError(f"seeds: expected whole numbers from 0, got {spec['seeds']}")
    if spec.get("seeds") and "seed" in shared:
        raise ValueError("params: expected seeds or params.seed, got both")
    for system in own:
        if system not in spec["systems"]:
            raise ValueError(registry.closest("params", system, spec["systems"]))
    for name in shared:
        if not any(name in _fields(system) for system in spec["systems"]):
            known = {field for system in spec["systems"] for field in _fields(system)}
            raise ValueError(registry.closest("params", name, known))
    return spec


def _fields(system: str) -> list[str]:
    first = next(iter(registry.system(system).cases.values()))
    return [field.name for field in dataclasses.fields(first)]


def _split(spec: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    params = spec.get("params", {})
    own = {key: dict(value) for key, value in params.items() if isinstance(value, Mapping)}
    return {key: value for key, value in params.items() if key not in own}, own


def _axes(spec: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    """`_split` with the seeds among what is shared."""
    shared, own = _split(spec)
    return {**shared, **({"seed": spec["seeds"]} if spec.get("seeds") else {})}, own


def _combinations(axes: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    values = [value if isinstance(value, list) else [value] for value in axes.values()]
    for chosen in itertools.product(*values):
        yield dict(zip(axes, chosen, strict=True))


def groups(spec: Mapping[str, Any]) -> list[Group]:
    """One group per dataset, combination of the shared axes, and seed."""
    shared, own = _axes(spec)
    made = []
    for dataset, common in itertools.product(spec["datasets"], _combinations(shared)):
        subjects = []
        for system in spec["systems"]:
            mine = {k: v for k, v in common.items() if k in _fields(system)}
            for extra in _combinations(own.get(system, {})):
                words = [system, *(f"{key}={value}" for key, value in extra.items())]
                subjects.append(
                    Subject(system, {**mine, **extra}, " ".join(words), spec.get("case"))
                )
        made.append(
            Group(
                dataset,
                tuple(subjects),
                common,
                quality=bool(spec.get("quality", False)),
                seed=common["seed"] if spec.get("seeds") else None,
            )
        )
    return made


def table(spec: Mapping[str, Any]) -> Table:
    """The sweep as a table: one row per subject and group, ratios to the first subject."""
    shared, _ = _axes(spec)
    baseline = groups(spec)[0].subjects[0].name
    columns = (
        Column("dataset", "dataset"),
        Column("triangles_in", "triangles in"),
        *(Column(name, name) for name in shared),
        Column("system", "system"),
        Column("triangles_out", "triangles out"),
        *WALL_COLUMNS,
        Column("stage_s", "device time", "s"),
        Column("stored_bytes", "stored", "B"),
        *(QUALITY_COLUMNS if spec.get("quality") else ()),
        *ratio_columns([baseline]),
        *STATUS_COLUMNS,
    )
    return Table(
        id=spec["name"],
        title=f"Sweep {spec['name']}",
        source="a sweep of one's own",
        groups=lambda quick: groups(spec),
        columns=brief(columns),
    )


def default_dataset(system: str) -> str:
    """A dataset that `system` takes: the first of the catalogue that needs no files."""
    kinds = {TriangleMesh: "triangles", BezierPatches: "patches", NurbsModel: "nurbs"}
    for taken in registry.system(system).takes:
        if taken in kinds:
            return catalogue.names(kinds[taken])[0]
    raise ValueError(f"dataset: expected the name of one that {system} takes, got none")
