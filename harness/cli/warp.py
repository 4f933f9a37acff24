"""What `--region`, `--view` and `--warp` mean: where a clustering's cells are finer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lodbench.harness.cli.displace import text_of


def warping(
    regions: list[str] | None, view: str | None, function: Path | None, surface: Any
) -> dict[str, Any]:
    """The options of the API that these words stand for.

    Args:
        regions: X,Y,Z,RADIUS,WEIGHT each, model units.
        view: AZIMUTH,ELEVATION, degrees, of an eye that sees the whole as `lodbench render --camera` does; or X,Y,Z of
            one that looks at the middle of the box.
        function: a file of OpenCL C.
        surface: what is simplified.

    Raises:
        ValueError: another form; FileError where a file cannot be read.
    """
    options: dict[str, Any] = {}
    if regions:
        form = "X,Y,Z,RADIUS,WEIGHT"
        options["regions"] = tuple(_numbers("region", text, (5,), form) for text in regions)
    if view is not None:
        options["view"] = view_of(view, surface)
    if function is not None:
        options["warp"] = text_of(function)
    return options


def _numbers(option: str, text: str, counts: tuple[int, ...], form: str) -> tuple[float, ...]:
    try:
        found = tuple(float(word) for word in text.split(","))
    except ValueError:
        found = ()
    if len(found) not in counts:
        raise ValueError(f"{option}: expected {form}, got {text!r}")
    return found


def view_of(text: str, surface: Any) -> Any:
    """What `--view` sees of a mesh: AZIMUTH,ELEVATION of an eye that sees the whole, or X,Y,Z of one.

    Raises:
        ValueError: neither, no mesh, or an eye in its middle.
    """
    from lodbench.datasets_gen.surfaces import TriangleMesh
    from lodbench.kernels.render import mesh_view
    from lodbench.kernels.stages.camera import look_at

    numbers = _numbers("view", text, (2, 3), "AZIMUTH,ELEVATION or X,Y,Z of the eye")
    if not isinstance(surface, TriangleMesh):
        raise ValueError(f"view: expected a mesh to look at, got a {type(surface).__name__}")
    if len(numbers) == 2:
        return mesh_view(surface, numbers)
    low, high = surface.box
    middle = (low.astype(float) + high) / 2
    middle = middle if surface.origin is None else middle + surface.origin
    try:
        return look_at(numbers, middle)
    except ValueError:
        wanted = "view: expected an eye other than the middle of the mesh"
        raise ValueError(f"{wanted}, got {text!r}") from None
