"""Commands that work on one's own meshes, and on datasets: simplify, refine, render, datasets."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli import DeviceOption, JsonOption, QuietOption, app, say, say_json, say_rows

InArgument = Annotated[
    Path,
    typer.Argument(
        metavar="IN",
        help="A mesh: PLY, OBJ, STL, OFF ...; a geometry image: NPZ; or a dataset's name.",
    ),
]
OutArgument = Annotated[Path, typer.Argument(metavar="OUT", help="Where the result goes.")]


def input_surface(path: Path) -> Any:
    """The mesh or geometry image in a file; or, where there is no such file, the dataset of that name."""
    from lodbench.datasets_gen import catalogue, images, read
    from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh

    if path.suffix.lower() == ".npz":
        return images.read_geometry_image(path)
    if path.exists() or path.suffix or len(path.parts) > 1:
        return read.read_mesh(path)
    surface = catalogue.load(str(path)).surface
    if not isinstance(surface, TriangleMesh | GeometryImage):
        raise ValueError(f"IN: expected triangles, got {type(surface).__name__} of {path}")
    return surface


def input_mesh(path: Path) -> Any:
    """`input_surface` as triangles: a geometry image gives all of its own."""
    from lodbench.datasets_gen.surfaces import GeometryImage

    surface = input_surface(path)
    if not isinstance(surface, GeometryImage):
        return surface
    from lodbench.kernels.geometry_image.parameterisation import full_mesh  # half a second

    return full_mesh(surface)


def _cells(text: str | None) -> Any:
    """`90`, `90.5` or `90,60,30` as the API takes it; whether it is in range is the API's to say."""
    if text is None:
        return None
    try:
        if "," in text:
            return tuple(int(word) for word in text.split(","))
        return int(text) if text.strip("+-").isdigit() else float(text)
    except ValueError:
        raise ValueError(f"cells: expected N or NX,NY,NZ, got {text!r}") from None


def _finish(
    result: Any, source: Any, out: Path, started: float, json_output: bool, quiet: bool
) -> None:
    from lodbench.datasets_gen import read

    read.write_mesh(out, result.mesh)
    facts = {
        "out": out,
        "triangles_in": source.triangle_count,
        "triangles_out": result.mesh.triangle_count,
        "vertices_in": source.vertex_count,
        "vertices_out": result.mesh.vertex_count,
        "wall_s": time.perf_counter() - started,
        "counters": dict(result.counters),
    }
    if json_output:
        say_json(facts)
    elif not quiet:
        say(
            f"{out}: {facts['triangles_in']:,} -> {facts['triangles_out']:,} triangles, "
            f"{facts['vertices_in']:,} -> {facts['vertices_out']:,} points, {facts['wall_s']:.2f} s"
        )


@app.command()
def simplify(
    source: InArgument,
    out: OutArgument,
    target_reduction: Annotated[
        float | None, typer.Option("--target-reduction", "-r", help="Share of triangles removed.")
    ] = None,
    target_count: Annotated[
        int | None, typer.Option("--target-count", "-n", help="Triangles left, at most.")
    ] = None,
    cells: Annotated[
        str | None, typer.Option("--cells", "-c", help="Grid cells: N, or NX,NY,NZ.")
    ] = None,
    method: Annotated[
        str | None,
        typer.Option(
            "--method",
            "-m",
            help="quadric_clustering; or quadtree_lod, for closed surfaces of genus 0: the default "
            "for geometry images.",
        ),
    ] = None,
    device: DeviceOption = None,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Fewer triangles of the same shape.

    Example: lodbench simplify scan.ply small.ply --target-reduction 0.9
    """
    from lodbench.datasets_gen import read
    from lodbench.datasets_gen.surfaces import GeometryImage
    from lodbench.kernels import Device, simplify_mesh

    grid = _cells(cells)
    read.check_writable(out)
    surface = input_surface(source)
    opened = Device.open(device)
    started = time.perf_counter()
    is_image = isinstance(surface, GeometryImage)
    result = simplify_mesh(
        opened, surface, target_reduction=target_reduction, target_count=target_count, cells=grid,
        method=method or ("quadtree_lod" if is_image else "quadric_clustering"),
    )  # fmt: skip
    _finish(result, surface, out, started, json_output, quiet)


@app.command()
def refine(
    source: InArgument,
    out: OutArgument,
    segments: Annotated[
        int, typer.Option("--segments", "-n", help="Segments along each edge of each triangle.")
    ] = 4,
    method: Annotated[
        str, typer.Option("--method", "-m", help="A system of family refine.")
    ] = "pattern",
    displace: Annotated[
        float, typer.Option("--displace", help="Height of a sine, in bounding-box diagonals.")
    ] = 0.0,
    waves: Annotated[
        float, typer.Option("--waves", help="Of that sine per bounding-box diagonal.")
    ] = 8.0,
    weld: Annotated[bool, typer.Option(help="Share the points on edges between triangles.")] = True,
    device: DeviceOption = None,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """More triangles: each split into segments^2, displaced if wanted.

    Example: lodbench refine coarse.obj fine.ply --segments 16
    """
    from lodbench.datasets_gen import read
    from lodbench.kernels import Device, refine_mesh

    extra = {"amplitude": displace, "waves": waves} if displace else {}
    read.check_writable(out)
    mesh = input_mesh(source)
    opened = Device.open(device)
    started = time.perf_counter()
    result = refine_mesh(opened, mesh, segments=segments, method=method, weld=weld, **extra)
    _finish(result, mesh, out, started, json_output, quiet)


def _numbers(option: str, text: str, separator: str, kind: type) -> tuple[Any, Any]:
    """Two numbers of one word, such as 1280x1024 or 30,20."""
    try:
        first, second = text.lower().split(separator)
        return kind(first), kind(second)
    except ValueError:
        raise ValueError(f"{option}: expected A{separator}B, got {text!r}") from None


@app.command()
def render(
    source: InArgument,
    out: Annotated[Path, typer.Argument(metavar="OUT", help="Where the picture goes: PNG.")],
    size: Annotated[str, typer.Option("--size", help="Pixels: WIDTHxHEIGHT.")] = "1280x1024",
    camera: Annotated[
        str, typer.Option("--camera", help="AZIMUTH,ELEVATION of the eye, degrees.")
    ] = "30,20",
    colour: Annotated[
        str, typer.Option("--colour", help="smooth, flat, wireframe or triangle.")
    ] = "smooth",
    wireframe: Annotated[bool, typer.Option("--wireframe", help="Draw the edges too.")] = False,
    cull: Annotated[bool, typer.Option("--cull", help="Leave out faces that turn away.")] = False,
    up: Annotated[str, typer.Option("--up", help="The axis that points upwards.")] = "y",
    device: DeviceOption = None,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """A picture of a mesh.

    Example: lodbench render scan.ply scan.png --camera 120,10 --wireframe
    """
    from lodbench.kernels import Device
    from lodbench.kernels.image import write_png
    from lodbench.kernels.render import render as draw

    pixels = _numbers("size", size, "x", int)
    angles = _numbers("camera", camera, ",", float)
    if out.suffix.lower() != ".png":
        raise ValueError(f"OUT: expected a name that ends in .png, got {out}")
    mesh = input_mesh(source)
    opened = Device.open(device)
    started = time.perf_counter()
    image = draw(
        mesh, camera=angles, size=pixels, colour=colour, wireframe=wireframe, cull=cull, up=up,
        device=opened,
    )  # fmt: skip
    write_png(out, image)
    facts = {"out": out, "triangles_in": mesh.triangle_count, "width": pixels[0],
             "height": pixels[1], "wall_s": time.perf_counter() - started}  # fmt: skip
    if json_output:
        say_json(facts)
    elif not quiet:
        say(f"{out}: {mesh.triangle_count:,} triangles, {size} pixels, {facts['wall_s']:.2f} s")


datasets = typer.Typer(help="Surfaces to measure on: list, fetch, make.", no_args_is_help=True)
app.add_typer(datasets, name="datasets")


def dataset_rows() -> list[dict[str, Any]]:
    """What the catalogue holds, without making any of it."""
    from lodbench.datasets_gen import catalogue

    return [{"dataset": name, **facts} for name, facts in catalogue.describe().items()]


@datasets.command("list")
def list_datasets(json_output: JsonOption = False) -> None:
    """Surfaces by name, generated and read.

    Example: lodbench datasets list
    """
    rows = dataset_rows()
    if json_output:
        say_json(rows)
    else:
        say_rows([{"key": key, "label": key} for key in rows[0]], rows)


@datasets.command("make")
def make(
    name: Annotated[str, typer.Argument(help="A name from `lodbench datasets list`.")],
    out: OutArgument,
) -> None:
    """Write a dataset of triangles to a file.

    Example: lodbench datasets make torus_20k torus.ply
    """
    from lodbench.datasets_gen import catalogue, read

    catalogue.find(name)
    read.check_writable(out)
    mesh = input_mesh(Path(name))
    read.write_mesh(out, mesh)
    say(f"{out}: {mesh.triangle_count:,} triangles, {mesh.vertex_count:,} points")


@datasets.command("fetch")
def fetch(
    names: Annotated[list[str] | None, typer.Argument(help="Default: all that can be had.")] = None,
) -> None:
    """Download the classic scans into the data folder.

    Example: lodbench datasets fetch bunny_69k
    """
    from lodbench.datasets_gen import catalogue

    for path in catalogue.fetch(names or None, lambda line: typer.echo(line, err=True)):
        say(str(path))
