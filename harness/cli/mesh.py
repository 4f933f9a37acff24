"""Commands that work on one's own meshes: simplify, refine."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli import complete
from lodbench.harness.cli.app import app
from lodbench.harness.cli.displace import displacement
from lodbench.harness.cli.files import (
    STANDARD,
    FormatOption,
    InArgument,
    MeshTarget,
    OutArgument,
    Source,
    read_source,
)
from lodbench.harness.cli.options import (
    DeviceOption,
    JsonOption,
    OwnOption,
    QuietOption,
    method_option,
    parameters,
)
from lodbench.harness.cli.output import say
from lodbench.harness.cli.warp import warping


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


def _bounded(max_error: float | None, settings: dict[str, Any]) -> dict[str, Any]:
    """The settings, with the largest error among them where it is given by its own option."""
    return settings if max_error is None else settings | {"max_error": max_error}


def _finish(
    result: Any,
    source: Source,
    target: MeshTarget,
    started: float,
    json_output: bool,
    quiet: bool,
) -> None:
    levels, out = result.levels, [target.path]
    if len(levels) > 1:
        out, lost = target.write_chain(levels, source, json_output)
    else:
        lost = target.write_mesh(result.mesh, source, json_output)
    facts = {
        "out": out[0],
        "triangles_in": source.surface.triangle_count,
        "triangles_out": result.mesh.triangle_count,
        "vertices_in": source.surface.vertex_count,
        "vertices_out": result.mesh.vertex_count,
        "carried": target.carried(result.mesh),
        "lost": lost,
        "wall_s": time.perf_counter() - started,
        "counters": dict(result.counters),
    }
    if len(levels) > 1:
        facts["levels"] = [
            {"out": path, "triangles": level.triangle_count, "vertices": level.vertex_count}
            for path, level in zip(out if len(out) > 1 else out * len(levels), levels, strict=True)
        ]
    _say(facts, target, json_output, quiet)


def _say(facts: dict[str, Any], target: MeshTarget, json_output: bool, quiet: bool) -> None:
    from lodbench.kernels.targets import off_target

    if json_output:
        target.say_json(facts)
    elif not quiet:
        missed = off_target(facts["counters"])
        if cracked := facts["counters"].get("cracked_edges"):
            target.hint(
                f"normals are split along {cracked:,} edges of the input: cracks open there"
            )
        target.say(
            f"{facts['out']}: {facts['triangles_in']:,} -> {facts['triangles_out']:,} triangles"
            f"{f' ({missed})' if missed else ''}, "
            f"{facts['vertices_in']:,} -> {facts['vertices_out']:,} points, {facts['wall_s']:.2f} s"
        )
        for level in facts.get("levels", [])[1:]:
            target.say(
                f"{level['out']}: {level['triangles']:,} triangles, {level['vertices']:,} points"
            )


def _within(
    memory: str, source: Path, target: MeshTarget, json_output: bool, quiet: bool, **options: Any
) -> None:
    """A file simplified within so much memory, in batches where it is larger."""
    from lodbench.harness.measure.progress import Progress
    from lodbench.kernels.simplify_file import simplify_file

    started = time.perf_counter()
    for name, path in (("IN", source), ("OUT", target.path)):
        if str(path) == STANDARD:
            raise ValueError(f"{name}: expected a file with --memory, got {STANDARD}")
    with Progress(1.0, quiet or json_output or not sys.stderr.isatty()) as progress:
        at: tuple[str, float] = "", 0.0

        def told(what: str, share: float) -> None:
            nonlocal at
            if what != at[0]:
                progress.task(f"{source.name}: {what}")
            progress.advance(share - at[1])
            at = what, share

        made = simplify_file(source, target.path, memory=memory, told=told, **options)
    if made.extras and not json_output:
        say(f"note: {made.path} lacks what the input has: {', '.join(made.extras)}", err=True)
    facts = {
        "out": made.path,
        "triangles_in": made.triangles_in,
        "triangles_out": made.triangles,
        "vertices_in": made.vertices_in,
        "vertices_out": made.vertices,
        "lost": list(made.extras),
        "wall_s": time.perf_counter() - started,
        "counters": dict(made.counters) if json_output else made.counters,
    }
    _say(facts, target, json_output, quiet)


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
    max_error: Annotated[
        float | None,
        typer.Option(
            "--max-error",
            help="Largest distance from the input, share of the bounding-box diagonal, of methods that keep to one: "
            "edge_collapse and octrees.",
        ),
    ] = None,
    method: Annotated[str | None, method_option(complete.simplify_methods)] = None,
    region: Annotated[
        list[str] | None,
        typer.Option(
            "--region",
            help="X,Y,Z,RADIUS,WEIGHT, model units: cells WEIGHT times as fine there; may be repeated.",
        ),
    ] = None,
    view: Annotated[
        str | None,
        typer.Option(
            "--view",
            help="AZIMUTH,ELEVATION as of render's --camera, or X,Y,Z of an eye: cells finer near to it.",
        ),
    ] = None,
    warp: Annotated[
        Path | None,
        typer.Option(
            "--warp",
            help="FUNCTION.cl with float warp(const float t, const int axis), which rises with t from 0 to 1: "
            "the steeper, the finer.",
        ),
    ] = None,
    memory: Annotated[
        str | None,
        typer.Option(
            "--memory",
            help="At most so much memory, such as 512M or 2G: a larger binary PLY or STL is streamed, with the same "
            "points and triangles; normals and colours are not parted at seams.",
        ),
    ] = None,
    settings: OwnOption = None,
    form: FormatOption = None,
    device: DeviceOption = None,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Fewer triangles of the same shape.

    Example: lodbench simplify torus_20k small.ply --target-reduction 0.9

    Finer at the right: lodbench simplify torus_20k fine.ply -n 4000 --region 1,0,0,0.3,8

    Piped: lodbench simplify - - --format obj -n 500 < small.ply > smaller.obj

    As few as are so near: lodbench simplify torus_20k near.ply --max-error 0.002 --method edge_collapse

    Several levels in one GLB or glTF; as OUT_0.ply, OUT_1.ply ... in other formats:

    Example: lodbench simplify torus_20k levels.glb -n 9000 --method level_chain -s levels=4
    """
    from lodbench.kernels import Device, simplify_mesh

    grid = _cells(cells)
    target = MeshTarget(out, form)
    target.check()
    if memory is not None:
        if region or view or warp:
            raise ValueError("memory: expected no region, view or warp beside it, got one")
        return _within(
            memory, source, target, json_output, quiet, target_reduction=target_reduction,
            target_count=target_count, cells=grid, method=method, device=device,
            **_bounded(max_error, parameters(settings)),
        )  # fmt: skip
    found = read_source(source)
    extra = _bounded(max_error, parameters(settings))
    extra |= warping(region, view, warp, found.surface)
    opened = Device.open(device)
    started = time.perf_counter()
    result = simplify_mesh(
        opened, found.surface, target_reduction=target_reduction, target_count=target_count, cells=grid,
        method=method, **extra,
    )  # fmt: skip
    _finish(result, found, target, started, json_output, quiet)


@app.command()
def refine(
    source: InArgument,
    out: OutArgument,
    segments: Annotated[
        int, typer.Option("--segments", "-n", help="Segments along each edge of each triangle.")
    ] = 4,
    method: Annotated[str | None, method_option(complete.refine_methods)] = None,
    settings: OwnOption = None,
    displace: Annotated[
        str | None,
        typer.Option(
            "--displace",
            autocompletion=complete.displacements,
            help="[KIND:]HEIGHT[,WAVES] in and per bounding-box diagonal; sine, perlin, turbulence. "
            "Or PICTURE:HEIGHT[,BIAS] over texture coordinates, of PNG or NPY. Or FUNCTION.cl with float "
            "displace(float3 position, float3 normal, float2 uv, float time), in model units.",
        ),
    ] = None,
    weld: Annotated[bool, typer.Option(help="Share the points on edges between triangles.")] = True,
    form: FormatOption = None,
    device: DeviceOption = None,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """More triangles: each split into segments^2, displaced if wanted.

    Example: lodbench refine icosphere_2 fine.ply --segments 16 --displace perlin:0.02,8

    Piped: lodbench refine - - --segments 4 < smaller.obj > fine.ply
    """
    from lodbench.kernels import Device, refine_mesh

    extra = parameters(settings)
    extra |= displacement(displace) if displace else {}
    target = MeshTarget(out, form)
    target.check()
    found = read_source(source).triangles()
    opened = Device.open(device)
    started = time.perf_counter()
    result = refine_mesh(
        opened, found.surface, segments=segments, method=method, weld=weld, **extra
    )
    _finish(result, found, target, started, json_output, quiet)
