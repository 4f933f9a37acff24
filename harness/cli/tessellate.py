"""The command that makes triangles of Bezier patches: tessellate."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli import complete
from lodbench.harness.cli.app import app
from lodbench.harness.cli.files import STANDARD, FormatOption, MeshTarget, OutArgument, Source
from lodbench.harness.cli.options import (
    DeviceOption,
    JsonOption,
    OwnOption,
    QuietOption,
    parameters,
)


def _patches(path: Path) -> Any:
    """The patches of a file or of standard input, or of a dataset where there is no file of that name."""
    from lodbench.datasets_gen import catalogue
    from lodbench.datasets_gen.patches import parse_patches, read_patches
    from lodbench.datasets_gen.surfaces import BezierPatches

    if str(path) == STANDARD:
        if sys.stdin.isatty():
            raise ValueError("IN: expected patches on standard input, got a terminal")
        return parse_patches(sys.stdin.buffer.read(), "<stdin>")
    if path.exists() or path.suffix or len(path.parts) > 1:
        return read_patches(path)
    surface = catalogue.load(str(path)).surface
    if not isinstance(surface, BezierPatches):
        raise ValueError(f"IN: expected Bezier patches, got {type(surface).__name__} of {path}")
    return surface


@app.command()
def tessellate(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="IN",
            autocompletion=complete.datasets,
            help="Bicubic Bezier patches: BPT, NPZ with `patches` (n, 4, 4, 3), a dataset, or - for standard input.",
        ),
    ],
    out: OutArgument,
    level: Annotated[
        int, typer.Option("--level", "-n", help="2^level segments along each side of a patch.")
    ] = 4,
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
    weld: Annotated[bool, typer.Option(help="Share the points on borders between patches.")] = True,
    form: FormatOption = None,
    device: DeviceOption = None,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """Triangles of Bezier patches, with normals.

    Example: lodbench tessellate pot_32 pot.glb --level 4

    Seen from there: lodbench tessellate pot_32 near.glb --level 6 --view 30,20
    """
    from lodbench.datasets_gen.finest import finest
    from lodbench.harness.cli.warp import view_of
    from lodbench.kernels import Device, tessellate_surface

    target = MeshTarget(out, form)
    target.check()
    patches = _patches(source)
    opened = Device.open(device)
    started = time.perf_counter()
    options = {"view": view_of(view, finest(patches))} if view else {}
    result = tessellate_surface(
        opened, patches, level=level, method=method, weld=weld, **options, **parameters(settings)
    )
    target.write_mesh(result.mesh, Source(patches), json_output)
    facts = {
        "out": out,
        "patches": len(patches.points),
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
            f"{out}: {facts['patches']:,} patches -> {facts['triangles_out']:,} triangles, "
            f"{facts['vertices_out']:,} points, {facts['wall_s']:.2f} s"
        )
