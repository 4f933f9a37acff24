"""The datasets by name: how each is made or where it is read, how large it is, of which kind.

Generated ones need no files and are named shape_size: any size works (`torus_250k`, `terrain_3m`), the
nearest count that the shape allows is made, and `_sorted` after it gives the triangles in spatial order;
`bunny_69k_to_1k` is a coarse version with at most so many triangles, made by fast-simplification; `teapot_x5` is a
scene of five copies of patches. Mesh files of one's own get a name by `adopt`. Real scans are read from the data folder
(LODBENCH_DATA, or the cache of downloads): `meshes/`, `bezier/`, `nurbs/`, `nasty/`. Where a scan is not there,
`<name>_standin` is a generated surface of like size and topology; it keeps its own name in every record.
"""

from __future__ import annotations

import difflib
import hashlib
import os
import re
from collections import OrderedDict
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from lodbench.datasets_gen import fetch as _fetch
from lodbench.datasets_gen import nurbs_files, patches, read, standard, triangles
from lodbench.datasets_gen.coarse import coarse_version
from lodbench.datasets_gen.names import FOLDERS, SIZED, data_folders
from lodbench.datasets_gen.order import spatially_sorted
from lodbench.datasets_gen.ply import ply_counts
from lodbench.datasets_gen.surfaces import (
    BezierPatches,
    GeometryImage,
    Surface,
    TriangleMesh,
)

KINDS = ("triangles", "patches", "nurbs")
_KEPT_BYTES = 1 << 29
"""Surfaces that stay in memory between loads; the newest stays whatever its size."""


@dataclass(frozen=True)
class Dataset:
    """One entry: facts that cost nothing, and the surface, made or read when it is first asked for."""

    name: str
    kind: str  # one of KINDS
    triangles: int | None  # None where it takes a reading to know
    note: str
    make: Callable[[], Surface] = field(repr=False, compare=False)
    standin: bool = False
    source: str = "generated"  # or the file
    content: str = ""  # of a file of one's own: the first 16 digits of its SHA-256

    @property
    def surface(self) -> Surface:
        """The surface; the same object while it stays in memory."""
        key = (self.name, self.source, self.content)
        if key in _kept:
            _kept.move_to_end(key)
            return _kept[key]
        surface = self.make()
        _kept[key] = surface
        while len(_kept) > 1 and sum(map(_size_bytes, _kept.values())) > _KEPT_BYTES:
            _kept.popitem(last=False)
        return surface


_kept: OrderedDict[tuple[str, str, str], Surface] = OrderedDict()
_own: dict[str, Dataset] = {}
"""Files of one's own that `adopt` gave a name."""


def _size_bytes(surface: Surface) -> int:
    if isinstance(surface, TriangleMesh):
        arrays = [surface.positions, surface.triangles, surface.normals, surface.uvs]
    elif isinstance(surface, BezierPatches):
        arrays = [surface.points]
    elif isinstance(surface, GeometryImage):
        arrays = [surface.positions, surface.normals]
    else:
        arrays = [s.points for s in surface.surfaces]
    return sum(a.nbytes for a in arrays if a is not None)


_MOST_TRIANGLES = 100_000_000
_FOLDERS = (
    ("meshes", "triangles", read.read_mesh),
    ("nasty", "triangles", read.read_mesh),
    ("bezier", "patches", patches.read_patches),
    ("nurbs", "nurbs", nurbs_files.read_nurbs),
)


def _files() -> dict[str, Dataset]:
    """Real models in the data folders, the first of a name."""
    found: dict[str, Dataset] = {}
    for root in data_folders():
        for folder, kind, reader in _FOLDERS:
            inside = root / folder
            paths = sorted(inside.iterdir()) if inside.is_dir() else []
            for suffix in FOLDERS[folder]:
                for path in paths:
                    if path.suffix.lower() == suffix and path.stem not in found:
                        found[path.stem] = Dataset(
                            path.stem,
                            kind,
                            _declared(path),
                            "odd on purpose: not a clean surface" if folder == "nasty" else "",
                            partial(reader, path),
                            source=str(path),
                        )
    return found


def _declared(path: Path) -> int | None:
    """Faces that a PLY file's header declares, else None."""
    if path.suffix.lower() != ".ply":
        return None
    try:
        with path.open("rb") as stream:
            return ply_counts(stream.read(1 << 16))[1]
    except (OSError, ValueError):
        return None  # loading it says what is wrong


def _generated(name: str) -> Dataset | None:
    """The entry of a name that needs no files, of any size; None where the name says no such thing."""
    if name in standard.PATCHES:
        make, note = standard.PATCHES[name]
        return Dataset(name, "patches", None, note, make, name.endswith("_standin"))
    if name in standard.NURBS:
        make, note = standard.NURBS[name]
        return Dataset(name, "nurbs", None, note, make, name.endswith("_standin"))
    if name.endswith("_standin"):
        scan = name.removesuffix("_standin")
        if scan not in standard.SCANS:
            return None
        count, make = standard.SCANS[scan]()
        return Dataset(name, "triangles", count, f"in place of {scan}", make, standin=True)
    if match := re.fullmatch(r"icosphere_(\d|10)", name):
        level = int(match[1])
        note = "closed, recursive subdivision, exact normals"
        return Dataset(name, "triangles", 20 * 4**level, note, partial(triangles.icosphere, level))
    if match := re.fullmatch(r"(\w+?)_([1-9]\d{0,8})([km]?)", name):
        shape = standard.SHAPES.get(match[1])
        wanted = int(match[2]) * {"": 1, "k": 1000, "m": 1000_000}[match[3]]
        if shape is not None and wanted <= _MOST_TRIANGLES:
            count, make = shape[0](wanted)
            return Dataset(name, "triangles", count, shape[1], make)
    return None


def _entry(name: str, files: dict[str, Dataset]) -> Dataset | None:
    if found := _own.get(name) or files.get(name) or _generated(name):
        return found
    if match := re.fullmatch(r"(\w+?)_to_([1-9]\d{0,5})(k?)(_standin)?", name):
        base = _entry(match[1] + (match[4] or ""), files)
        if base is None or base.kind != "triangles":
            return None
        count = int(match[2]) * (1000 if match[3] else 1)
        note, fine = "by fast-simplification", base
        make = lambda: coarse_version(_mesh(fine), count)  # noqa: E731
        return replace(base, name=name, triangles=None, note=note, make=make)
    if match := re.fullmatch(r"(\w+?)_x([1-9]\d{0,2})(_standin)?", name):
        one = _entry(match[1] + (match[3] or ""), files)
        if one is None or one.kind != "patches":
            return None
        note = f"{match[2]} copies of {one.name} side by side"
        return replace(one, name=name, note=note, make=partial(patches.scene, one, int(match[2])))
    base = _entry(name.removesuffix("_sorted"), files) if name.endswith("_sorted") else None
    if base is None or base.kind != "triangles":
        return None
    note = f"{base.note}; in spatial order".lstrip("; ")

    def make() -> TriangleMesh:
        return spatially_sorted(_mesh(base))

    return replace(base, name=name, note=note, make=make)


def _mesh(dataset: Dataset) -> TriangleMesh:
    surface = dataset.surface
    assert isinstance(surface, TriangleMesh)
    return surface


def is_file(name: str) -> bool:
    """Does `name` mean a mesh file of one's own, possibly `_sorted`, rather than a dataset?"""
    bare = name.removesuffix("_sorted")
    return "/" in bare or os.sep in bare or Path(bare).suffix.lower() in FOLDERS["meshes"]


def adopt(file: str | os.PathLike[str]) -> Dataset:
    """The entry of a mesh file, possibly with `_sorted` after it; `find` knows it by its name from here on.

    The name is the file's without its suffix, in `[a-z0-9_]`; where that is the name of something else, digits of the
    content are added.

    Raises:
        FileError: no such file, or a suffix that is no mesh's.
    """
    ending = "_sorted" if os.fspath(file).endswith("_sorted") else ""
    path = Path(os.fspath(file).removesuffix("_sorted"))
    read.check_suffix(path)
    content = hashlib.sha256(read.file_bytes(path)).hexdigest()[:16]
    name = re.sub("[^a-z0-9]+", "_", path.stem.lower()).strip("_")[:60] or "mesh"
    taken = _entry(name, _files())
    if taken is not None and taken.content != content:
        name = f"{name}_{content[:8]}"
    _own[name] = Dataset(
        name, "triangles", _declared(path), "a file of one's own", partial(read.read_mesh, path),
        source=str(path), content=content,
    )  # fmt: skip
    return find(name + ending)


def hint(name: str) -> str:
    """What was probably meant by a name that gives a few triangles where a standard one gives thousands, or ""."""
    meant = next((name + unit for unit in "km" if name + unit in SIZED), "")
    found = _generated(name) if meant and name not in SIZED else None
    return f"{name} has {found.triangles:,} triangles; was {meant} meant?" if found else ""


def find(name: str) -> Dataset:
    """The entry of a name, without making or reading its surface.

    Raises:
        ValueError: an unknown name (with the closest ones), or a scan that is not in the data folder.
    """
    found = _entry(name, _files())
    if found is not None:
        return found
    if _generated(f"{name}_standin"):
        fetchable = f", fetch it (lodbench datasets fetch {name})" if name in _fetch.SCANS else ""
        raise ValueError(
            f"dataset: {name} is not in the data folder (LODBENCH_DATA): put it there{fetchable} "
            f"or use {name}_standin"
        )
    known = names()
    close = difflib.get_close_matches(name, known, 3, 0.5)
    close += [other for other in known if name and name in other and other not in close][:3]
    hint = f"; closest: {' '.join(close)}" if close else ""
    raise ValueError(f"dataset: expected a name from `lodbench datasets list`, got {name!r}{hint}")


def load(name: str, standin_ok: bool = False) -> Dataset:
    """The entry of a name with its surface made or read, and kept in memory.

    With `standin_ok`, a scan that is not in the data folder is replaced by its stand-in, which comes under
    its own name with `standin` set.

    Raises:
        ValueError: as `find`; FileError where the file is broken.
    """
    if standin_ok and name not in _files() and (standin := _generated(f"{name}_standin")):
        found = standin
    else:
        found = find(name)
    _ = found.surface
    return found


def names(kind: str | None = None) -> list[str]:
    """All standard names: a small one of each kind first, then generated ones, files, stand-ins."""
    if kind is not None and kind not in KINDS:
        raise ValueError(f"kind: expected one of {' '.join(KINDS)}, got {kind!r}")
    return [name for name, entry in _entries().items() if kind in (None, entry.kind)]


def _entries() -> dict[str, Dataset]:
    files = _files()
    order = [
        "torus_20k",
        "pot_32",
        "rational_ball",
        *SIZED,
        *standard.PATCHES,
        *standard.NURBS,
    ]
    order += [*files, *(f"{scan}_standin" for scan in standard.SCANS)]
    standins = [name for name in order if name.endswith("_standin")]
    found: dict[str, Dataset] = {}
    for name in [name for name in order if not name.endswith("_standin")] + standins:
        entry = _entry(name, files)
        if entry is not None:
            found.setdefault(name, entry)
    return found


def describe() -> dict[str, dict[str, object]]:
    """Facts of every standard name, none of them made: kind, triangles, standin, source, note."""
    keys = ("kind", "triangles", "standin", "source", "note")
    return {name: {key: getattr(entry, key) for key in keys} for name, entry in _entries().items()}


def fetch(
    names: Iterable[str] | None = None, say: Callable[[str], None] | None = None
) -> list[Path]:
    """Download scans by name, or all that can be had; the paths of their files. See `fetch.fetch`."""
    return [_fetch.fetch(name, say) for name in (names or _fetch.SCANS)]
