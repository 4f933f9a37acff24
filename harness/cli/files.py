"""What IN and OUT mean to a command: a file, a dataset's name, or `-` for standard input and output."""

from __future__ import annotations

import json
import sys
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli import complete
from lodbench.harness.cli.output import hint, say

InArgument = Annotated[
    Path,
    typer.Argument(
        metavar="IN",
        autocompletion=complete.datasets,
        help="A mesh: PLY, OBJ, STL, OFF ...; a geometry image: NPZ; a dataset's name; or - for standard input.",
    ),
]
OutArgument = Annotated[
    Path, typer.Argument(metavar="OUT", help="Where the result goes; - for standard output.")
]
FormatOption = Annotated[
    str | None,
    typer.Option(
        "--format",
        autocompletion=complete.formats,
        help="Of OUT: ply, obj, stl, off, gltf or glb; default its suffix, and ply for -.",
    ),
]
STANDARD = "-"
ATTRIBUTES = ("normals", "uvs", "colours", "tags")


@dataclass(frozen=True)
class Source:
    """What IN holds: a TriangleMesh or GeometryImage, and what its file has that they may lack, by name."""

    surface: Any
    extras: tuple[str, ...] = ()

    def attributes(self) -> list[str]:
        """All that there is beside points and triangles."""
        own = [name for name in ATTRIBUTES if getattr(self.surface, name, None) is not None]
        return list(dict.fromkeys([*self.extras, *own]))

    def triangles(self) -> Source:
        """The same as triangles: a geometry image gives all of its own."""
        from lodbench.datasets_gen.surfaces import GeometryImage

        if not isinstance(self.surface, GeometryImage):
            return self
        from lodbench.kernels.geometry_image.parameterisation import full_mesh  # half a second

        return Source(full_mesh(self.surface), self.extras)


def read_source(path: Path) -> Source:
    """The mesh or geometry image in a file or on standard input; or, where there is no such file, the dataset's.

    Raises:
        ValueError: an unknown name or kind; FileError where the file cannot be read.
    """
    from lodbench.datasets_gen import catalogue, contents, images, read
    from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh

    if str(path) == STANDARD:
        if sys.stdin.isatty():
            raise ValueError("IN: expected a mesh on standard input, got a terminal")
        data = sys.stdin.buffer.read()
        found = contents.format_of(data)
        if found is None:
            got = f"{data[:12]!r}..." if data else "nothing"
            raise ValueError(f"IN: expected a mesh or NPZ on standard input, got {got}")
        path = Path(f"<stdin>{found}")
    elif path.exists() or path.suffix or len(path.parts) > 1:
        if path.suffix.lower() == ".npz":
            return Source(images.read_geometry_image(path))
        read.check_suffix(path)
        data = read.file_bytes(path)
    else:
        dataset = catalogue.load(str(path))
        if probably := catalogue.hint(str(path)):
            hint(probably)
        surface, file = dataset.surface, Path(dataset.source)
        if not isinstance(surface, TriangleMesh | GeometryImage):
            raise ValueError(f"IN: expected triangles, got {type(surface).__name__} of {path}")
        if file.suffix.lower() not in read.SUFFIXES:
            return Source(surface)
        return Source(surface, tuple(contents.extras(read.file_bytes(file), file)))
    if path.suffix == ".npz":
        return Source(images.read_geometry_image(path, data))
    mesh = read.parse_mesh(data, path)
    return Source(mesh, tuple(contents.extras(data, path)))


def read_curved(path: Path) -> Any:
    """The surfaces of a file, patches on standard input, or a dataset where there is no file of that name.

    Raises:
        ValueError: an unknown name or kind; FileError where the file cannot be read.
    """
    from lodbench.datasets_gen import catalogue, nurbs_files, patches
    from lodbench.datasets_gen.read import FileError
    from lodbench.datasets_gen.surfaces import BezierPatches, NurbsModel

    if str(path) == STANDARD:
        if sys.stdin.isatty():
            raise ValueError("IN: expected patches on standard input, got a terminal")
        return patches.parse_patches(sys.stdin.buffer.read(), "<stdin>")
    if path.exists() or path.suffix or len(path.parts) > 1:
        suffix = path.suffix.lower()
        if suffix in nurbs_files.SUFFIXES:
            return nurbs_files.read_nurbs(path)
        if suffix in patches.SUFFIXES:
            return patches.read_patches(path)
        known = " ".join((*patches.SUFFIXES, *nurbs_files.SUFFIXES))
        raise FileError(f"{path}: expected a suffix of {known}, got {path.suffix!r}")
    surface = catalogue.load(str(path)).surface
    if not isinstance(surface, BezierPatches | NurbsModel):
        got = f"{type(surface).__name__} of {path}"
        raise ValueError(f"IN: expected Bezier patches or NURBS surfaces, got {got}")
    return surface


def is_curved(path: Path) -> bool:
    """Are these patches or NURBS surfaces, by the name: a file's suffix, what is in an NPZ, or a dataset's kind?"""
    from lodbench.datasets_gen import catalogue, nurbs_files, patches
    from lodbench.datasets_gen.surfaces import BezierPatches, NurbsModel

    if str(path) == STANDARD:
        return False
    if path.exists() or path.suffix or len(path.parts) > 1:
        suffix = path.suffix.lower()
        if suffix == ".npz" and zipfile.is_zipfile(path):
            return "patches.npy" in zipfile.ZipFile(path).namelist()
        return suffix in (*patches.SUFFIXES, *nurbs_files.SUFFIXES) and suffix != ".npz"
    return isinstance(catalogue.load(str(path)).surface, BezierPatches | NurbsModel)


class Target:
    """OUT: checked before the work, written after it; with `-` all that is said goes to standard error."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.piped = str(path) == STANDARD

    def check(self, *suffixes: str) -> None:
        """Raise where nothing could be written; `suffixes` are those that the file may have, all where there are none.

        Raises:
            ValueError: another suffix, or standard output is a terminal; FileError where the place is no good.
        """
        from lodbench.datasets_gen import read

        if self.piped:
            if sys.stdout.isatty():
                raise ValueError("OUT: expected standard output to a file or pipe, got a terminal")
            return
        if suffixes and self.path.suffix.lower() not in suffixes:
            raise ValueError(
                f"OUT: expected a name that ends in {' '.join(suffixes)}, got {self.path}"
            )
        read.check_replaceable(self.path)

    def write(self, data: bytes) -> None:
        """All of it, or nothing to a file."""
        from lodbench.datasets_gen import read

        if not self.piped:
            with read.replacing(self.path) as stream:
                stream.write(data)
            return
        sys.stdout.buffer.write(data)
        sys.stdout.flush()

    def lost(self, source: Source, kept: set[str], json_output: bool = False) -> list[str]:
        """What IN has and is not in OUT; where there is any, one line on standard error says so.

        Not where a JSON document goes there too: it has a field for it.
        """
        lost = [name for name in source.attributes() if name not in kept]
        if lost and not (self.piped and json_output):
            say(f"note: {self.path} lacks what the input has: {', '.join(lost)}", err=True)
        return lost

    def say(self, text: str) -> None:
        """A line about what was written."""
        say(text, err=self.piped)

    def hint(self, text: str) -> None:
        """A line on standard error about what was written."""
        say(f"note: {self.path}: {text}", err=True)

    def say_json(self, facts: Mapping[str, Any]) -> None:
        """A JSON document about what was written."""
        from lodbench.harness.record.record import plain

        say(json.dumps(plain(facts), indent=1), err=self.piped)


class MeshTarget(Target):
    """OUT as a mesh file; the format is that of `--format`, or of the suffix."""

    def __init__(self, path: Path, form: str | None = None) -> None:
        super().__init__(path)
        if form is None and self.piped:
            form = "ply"
        self.suffix = path.suffix.lower() if form is None else f".{form.lower().lstrip('.')}"
        self._given = form

    def check(self, *suffixes: str) -> None:
        from lodbench.datasets_gen import read

        if self._given is None:
            read.check_suffix(self.path)
        elif self.suffix not in read.SUFFIXES:
            known = ", ".join(suffix[1:] for suffix in read.SUFFIXES)
            raise ValueError(f"format: expected one of {known}, got {self._given!r}")
        super().check()

    def carried(self, mesh: Any) -> list[str]:
        """What the file holds of the mesh beside points and triangles, by name."""
        from lodbench.datasets_gen import formats

        names = formats.CARRIED.get(self.suffix, ())
        return [name for name in names if getattr(mesh, name) is not None]

    def write_mesh(self, mesh: Any, source: Source, json_output: bool = False) -> list[str]:
        """Write it; returns what `lost` says."""
        from lodbench.datasets_gen import read

        self.write(read.mesh_bytes(mesh, self.suffix))
        return self.lost(source, set(self.carried(mesh)), json_output)

    def write_parts(
        self, parts: Mapping[str, Any], mesh: Any, source: Source, json_output: bool = False
    ) -> list[str]:
        """Write the parts by name where there are several and the format has such, else the mesh; returns what
        `lost` says.
        """
        from lodbench.datasets_gen import read

        whole = read.parts_bytes(parts, self.suffix) if len(parts) > 1 else None
        if whole is None:
            return self.write_mesh(mesh, source, json_output)
        self.write(whole)
        return self.lost(source, set(self.carried(mesh)), json_output)

    def write_chain(
        self, levels: Sequence[Any], source: Source, json_output: bool = False
    ) -> tuple[list[Path], list[str]]:
        """Write levels of detail, finest first: one file of glTF or GLB, else OUT_0.ply, OUT_1.ply and so on.

        Returns:
            The files, and what `lost` says.

        Raises:
            ValueError: several files cannot go to standard output; FileError where one cannot be written.
        """
        from lodbench.datasets_gen import read

        whole = read.chain_bytes(levels, self.suffix)
        if whole is not None:
            self.write(whole)
            return [self.path], self.lost(source, set(self.carried(levels[0])), json_output)
        if self.piped:
            raise ValueError(
                f"OUT: expected a file's name, or --format glb, for {len(levels)} levels, got -"
            )
        name = self.path
        paths = [name.with_name(f"{name.stem}_{k}{name.suffix}") for k in range(len(levels))]
        for path in paths:
            read.check_replaceable(path)
        contents = (read.mesh_bytes(level, self.suffix) for level in levels)
        read.write_all(dict(zip(paths, contents, strict=True)))
        return paths, self.lost(source, set(self.carried(levels[0])), json_output)
