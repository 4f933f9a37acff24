"""The command that makes triangles of curved surfaces: tessellate."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli import complete
from lodbench.harness.cli.app import app
from lodbench.harness.cli.files import FormatOption, MeshTarget, OutArgument, Source, read_curved
from lodbench.harness.cli.options import (
    DeviceOption,
    JsonOption,
    OwnOption,
    QuietOption,
    method_option,
    parameters,
)
from lodbench.harness.cli.output import say


@app.command()
def tessellate(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="IN",
            autocompletion=complete.datasets,
            help="Bicubic Bezier patches: BPT, NPZ with `patches` (n, 4, 4, 3), or - for standard input; NURBS "
            "surfaces: IGES, STEP, JSON; or a dataset's name.",
        ),
    ],
    out: OutArgument,
    level: Annotated[
        int | None,
        typer.Option(
            "--level",
            "-n",
            help="2^level segments along each side of a patch or surface; default 4. By pixels: the most of a span, 6.",
        ),
    ] = None,
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--tolerance",
            help="In place of a level: largest distance to NURBS surfaces, as a share of the box's diagonal.",
        ),
    ] = None,
    pixel_area: Annotated[
        float | None,
        typer.Option(
            "--pixel-area",
            help="In place of a level: pixels that a cell of NURBS surfaces may cover, as --view sees them, or whole.",
        ),
    ] = None,
    method: Annotated[str | None, method_option(complete.tessellate_methods)] = None,
    view: Annotated[
        str | None,
        typer.Option(
            "--view",
            help="AZIMUTH,ELEVATION as of render's --camera, or X,Y,Z of an eye: each patch or span as fine as it "
            "needs, up to --level; -s pixels=8, for NURBS --pixel-area 8, says how fine.",
        ),
    ] = None,
    settings: OwnOption = None,
    weld: Annotated[bool, typer.Option(help="Share the points on borders.")] = True,
    form: FormatOption = None,
    device: DeviceOption = None,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Triangles of Bezier patches or NURBS surfaces, with normals; surfaces are named parts of a GLB or glTF.

    Example: lodbench tessellate pot_32 pot.glb --level 4

    Seen from there: lodbench tessellate pot_32 near.glb --level 6 --view 30,20

    NURBS by pixels: lodbench tessellate rational_torus near.glb --pixel-area 8 --view 30,20
    """
    from lodbench.datasets_gen.finest import finest
    from lodbench.datasets_gen.surfaces import NurbsModel
    from lodbench.harness.cli.warp import view_of
    from lodbench.kernels import Device, tessellate_surface

    target = MeshTarget(out, form)
    target.check()
    surface = read_curved(source)
    for note in getattr(surface, "notes", ()):
        say(f"note: {source}: {note}", err=True)
    options: dict[str, Any] = {} if tolerance is None else {"tolerance": tolerance}
    if pixel_area is not None:
        options["pixel_area"] = pixel_area
    by_screen = isinstance(surface, NurbsModel) and (view is not None or pixel_area is not None)
    if level is not None or not by_screen:
        options["level"] = 4 if level is None else level
    opened = Device.open(device)
    started = time.perf_counter()
    if view:
        curved = isinstance(surface, NurbsModel)  # whose spans may be many
        whole = tessellate_surface(opened, surface, level=4).mesh if curved else finest(surface)
        options["view"] = view_of(view, whole)
    result = tessellate_surface(
        opened,
        surface,
        method=method,
        weld=weld,
        **options,
        **parameters(settings),
    )
    target.write_parts(result.parts, result.mesh, Source(surface), json_output)
    what = "patches" if "patches" in result.counters else "surfaces"
    facts = {
        "out": out,
        what: result.counters[what],
        "triangles_out": result.mesh.triangle_count,
        "vertices_out": result.mesh.vertex_count,
        "carried": target.carried(result.mesh),
        "wall_s": time.perf_counter() - started,
        "counters": dict(result.counters),
    }
    if json_output:
        target.say_json(facts)
    elif not quiet:
        target.say(
            f"{out}: {facts[what]:,} {what} -> {facts['triangles_out']:,} triangles, "
            f"{facts['vertices_out']:,} points, {facts['wall_s']:.2f} s"
        )
