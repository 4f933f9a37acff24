"""The command that lays a mesh out as a geometry image: geometry-image."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from lodbench.harness.cli import complete
from lodbench.harness.cli.app import app
from lodbench.harness.cli.files import InArgument, Target, read_source
from lodbench.harness.cli.options import DeviceOption, JsonOption, QuietOption
from lodbench.harness.measure.progress import Progress


@app.command("geometry-image")
def geometry_image(
    source: InArgument,
    out: Annotated[
        Path,
        typer.Argument(
            metavar="OUT", help="Where positions and normals go: NPZ; - for standard output."
        ),
    ],
    level: Annotated[
        int, typer.Option("--level", "-n", min=1, max=11, help="(2^n + 1)^2 samples.")
    ] = 8,
    mode: Annotated[
        str,
        typer.Option(
            "--mode",
            autocompletion=complete.modes,
            help="coarse_to_fine, cmcf or ray: the way to the sphere.",
        ),
    ] = "coarse_to_fine",
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of what is random in it.")] = 0,
    png: Annotated[
        bool, typer.Option("--png", help="Also write both as pictures beside it.")
    ] = False,
    cache: Annotated[bool, typer.Option(help="Keep the sphere on disk for the next time.")] = True,
    device: DeviceOption = None,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """A closed mesh of genus 0 as a square image of positions and normals.

    Example: lodbench geometry-image icosphere_4 ball.npz --level 6 --png

    Piped: lodbench geometry-image icosphere_4 - | lodbench simplify - small.ply -n 5000
    """
    from lodbench.datasets_gen import images
    from lodbench.kernels import Device
    from lodbench.kernels.geometry_image.parameterisation import as_pictures, make
    from lodbench.kernels.image import write_png

    target = Target(out)
    if png and target.piped:
        raise ValueError("png: expected OUT to be a file, pictures stand beside it, got -")
    target.check(".npz")
    found = read_source(source).triangles()
    mesh = found.surface
    opened = Device.open(device)
    started = time.perf_counter()
    with Progress(1.0, quiet or json_output) as progress:
        reached, told = 0.0, ""

        def report(what: str, share: float, _left: float | None) -> None:
            nonlocal reached, told
            if what != told:
                progress.task(what)
                told = what
            # turning and sampling are a few seconds after the long part
            if what == "parameterisation" and share > reached:
                progress.advance(share - reached)
                reached = share

        made = make(mesh, level, mode, seed, device=opened, cache=cache, progress=report)
    target.write(images.geometry_image_bytes(made.image))
    lost = target.lost(found, {"normals"}, json_output)
    if png:
        for picture, ending in zip(as_pictures(made.image), ("", "_normals"), strict=True):
            write_png(out.with_name(f"{out.stem}{ending}.png"), picture)
    side = made.image.positions.shape[0]
    facts = {
        "out": out, "triangles_in": mesh.triangle_count, "side": side, "mode": mode,
        "from_cache": made.spherical.from_cache, "flipped": made.spherical.flipped, "lost": lost,
        "degree": made.spherical.degree, "wall_s": time.perf_counter() - started, **made.seconds,
    }  # fmt: skip
    if json_output:
        target.say_json(facts)
    elif not quiet:
        target.say(
            f"{out}: {mesh.triangle_count:,} triangles as {side} x {side} samples, "
            f"{facts['wall_s']:.1f} s{' (sphere from cache)' if facts['from_cache'] else ''}"
        )
