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
        int,
        typer.Option(
            "--level", "-n", help="2^level segments along each side of a patch or surface."
        ),
    ] = 4,
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--tolerance",
            help="In place of a level: largest distance to NURBS surfaces, as a share of the box's diagonal.",
        ),
    ] = None,
    method: Annotated[
        str | None,
        typer.Option(
            "--method",
            "-m",
            autocompletion=complete.tessellate_methods,
            help="A system with this verb; default: the first that takes the surface.",
        ),
    ] = None,
    view: Annotated[
        str | None,
        typer.Option(
            "--view",
            help="AZIMUTH,ELEVATION as of render's --camera, or X,Y,Z of an eye: each patch as fine as it needs, up to "
            "--level; -s pixels=8 is how long a segment may be.",
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
    """
    from lodbench.datasets_gen.finest import finest
    from lodbench.datasets_gen.surfaces import BezierPatches
    from lodbench.harness.cli.warp import view_of
    from lodbench.kernels import Device, tessellate_surface

    target = MeshTarget(out, form)
    target.check()
    surface = read_curved(source)
    for note in getattr(surface, "notes", ()):
        say(f"note: {source}: {note}", err=True)
    near = {} if tolerance is None else {"tolerance": tolerance}
    opened = Device.open(device)
    started = time.perf_counter()
    options: dict[str, Any] = {}
    if view:
        if not isinstance(surface, BezierPatches):
            raise ValueError(f"--view: expected Bezier patches, got {type(surface).__name__}")
        options["view"] = view_of(view, finest(surface))
    result = tessellate_surface(
        opened,
        surface,
        level=level,
        method=method,
        weld=weld,
        **near,
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
