"""The command that draws: render."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli import complete
from lodbench.harness.cli.app import app
from lodbench.harness.cli.files import Target, is_curved, read_curved, read_source
from lodbench.harness.cli.options import (
    DeviceOption,
    JsonOption,
    OwnOption,
    QuietOption,
    parameters,
)

SECONDS_PER_TURN = 4.0


def _numbers(option: str, text: str, separator: str, kind: type) -> tuple[Any, Any]:
    """Two numbers of one word, such as 1280x1024 or 30,20."""
    try:
        first, second = text.lower().split(separator)
        return kind(first), kind(second)
    except ValueError:
        raise ValueError(f"{option}: expected A{separator}B, got {text!r}") from None


def _write_all(folder: Path, images: Any) -> None:
    """0000.png and so on, in a folder that is made where there is none; others of its files stay."""
    from lodbench.kernels.image import write_png

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ValueError(
            f"OUT: expected a folder or a place for one, got {folder}: {error}"
        ) from None
    for number, image in enumerate(images):
        write_png(folder / f"{number:04}.png", image)


def _amounts(surface: Any) -> dict[str, int]:
    """How much there is to draw, and of what."""
    from lodbench.datasets_gen.surfaces import BezierPatches, NurbsModel

    if isinstance(surface, BezierPatches):
        return {"patches": len(surface.points)}
    if isinstance(surface, NurbsModel):
        return {"surfaces": len(surface.surfaces)}
    return {"triangles_in": surface.triangle_count}


@app.command()
def render(
    source: Annotated[
        Path,
        typer.Argument(
            metavar="IN",
            autocompletion=complete.datasets,
            help="What `simplify` takes, or `tessellate`; or - for a mesh on standard input.",
        ),
    ],
    out: Annotated[
        Path,
        typer.Argument(
            metavar="OUT", help="PNG; for a full turn GIF, or a folder; - for standard output."
        ),
    ],
    size: Annotated[
        str | None,
        typer.Option("--size", help="Pixels: WIDTHxHEIGHT; 1280x1024, of a turn 640x512."),
    ] = None,
    frames: Annotated[
        int | None,
        typer.Option("--turntable", help="Frames of a full turn, as a GIF or a folder of PNG."),
    ] = None,
    path: Annotated[
        str,
        typer.Option(
            "--path",
            autocompletion=complete.paths,
            help="Of the eye: turntable, orbit (draws back and returns), fly_through.",
        ),
    ] = "turntable",
    refine: Annotated[
        str | None,
        typer.Option(
            "--refine",
            autocompletion=complete.drawing_methods,
            help="A system that refines the mesh, or tessellates patches, anew for each picture.",
        ),
    ] = None,
    level: Annotated[
        int | None,
        typer.Option(
            "--level", "-n", help="Of patches: 2^level segments a side; with -s by=screen at most."
        ),
    ] = None,
    settings: OwnOption = None,
    camera: Annotated[
        str, typer.Option("--camera", help="AZIMUTH,ELEVATION of the eye, degrees.")
    ] = "30,20",
    colour: Annotated[
        str,
        typer.Option(
            "--colour",
            "--color",
            autocompletion=complete.colours,
            help="smooth, flat, wireframe, triangle, or vertex: the mesh's own.",
        ),
    ] = "smooth",
    wireframe: Annotated[bool, typer.Option("--wireframe", help="Draw the edges too.")] = False,
    cull: Annotated[bool, typer.Option("--cull", help="Leave out faces that turn away.")] = False,
    up: Annotated[str, typer.Option("--up", help="The axis that points upwards.")] = "y",
    device: DeviceOption = None,
    json_output: JsonOption = False,
    quiet: QuietOption = False,
) -> None:
    """A picture of a mesh or of Bezier patches, or a full turn of it.

    Example: lodbench render small.ply small.png --camera 120,10 --wireframe

    Turning: lodbench render small.ply small.gif --turntable 12 --size 160x128

    Refined anew for each: lodbench render small.ply lod.gif --path orbit --refine adaptive_patterns -s by=screen

    Patches: lodbench render pot_32 pots.gif --path orbit --turntable 8 --size 160x128 -s by=screen

    Piped: lodbench datasets make terrain_2k - | lodbench render - terrain.png --up z
    """
    from lodbench.kernels import Device
    from lodbench.kernels import render as draw
    from lodbench.kernels import turntable as draw_turning
    from lodbench.kernels.image import gif_bytes, png_bytes

    target = Target(out)
    folder = frames is not None and not out.suffix and not target.piped
    turning = out.suffix.lower() == ".gif" or frames is not None
    if not folder:
        gif = () if target.piped else (".gif",)
        target.check(*(gif if frames is not None else (".png", ".gif")))
    pixels = _numbers("size", size or ("640x512" if turning else "1280x1024"), "x", int)
    look: dict[str, Any] = {
        "camera": _numbers("camera", camera, ",", float), "size": pixels, "colour": colour,
        "wireframe": wireframe, "cull": cull, "up": up, "refine": refine,
        "device": Device.open(device), **parameters(settings),
    }  # fmt: skip
    curved = is_curved(source)
    mesh = read_curved(source) if curved else read_source(source).triangles().surface
    if level is not None:
        if not curved:
            raise ValueError(f"--level: expected patches or NURBS surfaces, got a mesh: {source}")
        look["level"] = level
    started = time.perf_counter()
    if not turning:
        target.write(png_bytes(draw(mesh, **look)))
    else:
        images = draw_turning(mesh, frames=frames or 36, path=path, **look)  # pyright: ignore[reportArgumentType]
        if folder:
            _write_all(out, images)
        else:
            target.write(gif_bytes(images, SECONDS_PER_TURN))
    amounts = _amounts(mesh)
    facts = {"out": out, **amounts, "width": pixels[0], "height": pixels[1],
             "wall_s": time.perf_counter() - started}  # fmt: skip
    if json_output:
        target.say_json(facts)
    elif not quiet:
        what, count = next(iter(amounts.items()))
        target.say(
            f"{out}: {count:,} {what.removesuffix('_in')}, {pixels[0]}x{pixels[1]} pixels, "
            f"{facts['wall_s']:.2f} s"
        )
