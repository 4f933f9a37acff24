"""One mesh by every method at the same number of triangles, coloured by the distance to the input, with their names."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.measure.quality import located
from lodbench.harness.plan import registry
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.ratios import LIKE_COUNTS
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.render import mesh_view, render
from lodbench.kernels.system import run

SERIES = "methods"
TABLE = "pareto"  # before others
LEAST = 3  # rivals that make a strip
MOST_TRIANGLES = 200_000  # in; some rivals take seconds for more
SHAPE = (
    0.8,
    0.84,
)  # of a picture over others', of which the sides are empty; below is room for the name
BAND, INK = (238, 240, 243), (20, 24, 28)  # behind a name, and its own colour
FORMS = ("one_core", "_rounds")  # of a subject that is there, for other machines
RANGE = (0.0, 0.004)  # of the colours, distance as a share of the diagonal

Picture = tuple[dict[str, Any], NDArray[np.uint8]]


def method_pictures(record: RunRecord, size: tuple[int, int], device: Device) -> Iterator[Picture]:
    """A strip of the rivals of one group, nearest first: of those that leave like numbers of triangles, the fewest.

    Args:
        record: the run.
        size: of other pictures, pixels; these are less wide.
        device: what simplifies and draws.

    Yields:
        `file`, `caption`, `series`, `table` and `name`, and the pixels with the name in them.
    """
    found = [(group, rivals(group)) for group in record.groups]
    found = [(group, subjects) for group, subjects in found if len(subjects) >= LEAST]
    found.sort(key=lambda pair: pair[0].table != TABLE)
    if not found:
        return
    table, dataset = found[0][0].table, found[0][0].dataset
    group, subjects = min(
        (pair for pair in found if (pair[0].table, pair[0].dataset) == (table, dataset)),
        key=lambda pair: pair[1][0].counters["triangles"],
    )
    yield from _strip(
        group, subjects, (round(SHAPE[0] * size[0]), round(SHAPE[1] * size[1])), device
    )


def rivals(group: GroupRecord) -> list[SubjectRecord]:
    """The subjects that simplify and leave like numbers of triangles, nearest first; each system's first alone.

    A whole call is left out where the method itself is there.
    """
    if (group.facts.get("triangles_in") or 0) > MOST_TRIANGLES:
        return []
    found: list[SubjectRecord] = []
    for subject in group.subjects.values():
        error, count = (subject.quality or {}).get("rms_error"), subject.counters.get("triangles")
        known = subject.status == "ok" and error and count and not subject.label.endswith(FORMS)
        if known and subject.label.removesuffix("_call") not in group.subjects.keys() - {
            subject.label
        }:
            found.append(subject)
    if not found:
        return []
    middle = float(np.median([subject.counters["triangles"] for subject in found]))
    alike = [s for s in found if abs(s.counters["triangles"] / middle - 1) <= 2 * LIKE_COUNTS]
    once: dict[tuple[float, float], SubjectRecord] = {}  # who makes the same mesh is shown once
    for subject in alike:
        same = subject.counters["triangles"], (subject.quality or {})["rms_error"]
        once.setdefault(same, subject)
    return sorted(once.values(), key=lambda subject: (subject.quality or {})["rms_error"])


def _strip(
    group: GroupRecord, subjects: list[SubjectRecord], size: tuple[int, int], device: Device
) -> Iterator[Picture]:
    mesh = catalogue.find(group.dataset).surface
    assert isinstance(mesh, TriangleMesh)
    mesh = mesh.with_origin(None)
    view = mesh_view(mesh, size=size)
    for number, subject in enumerate(subjects):
        system = registry.system(subject.system)
        params = registry.parameters(system, None, subject.params or {})
        try:
            prepared: Any = system.prepare(device, mesh, params)
        except Unsupported:
            continue
        run(device, prepared)
        (made,) = prepared.result()
        look = {"colour": distances(mesh, made), "colour_range": RANGE, "wireframe": True}
        pixels = render(made, camera=view, device=device, **look)
        off = f"{(subject.quality or {})['rms_error']:.1e}".replace("e-0", "e-")
        said = f"{made.triangle_count:,} triangles, RMS error {off}"
        picture = {
            "file": f"methods_{number}_{group.dataset}.png",
            "series": SERIES,
            "table": group.table,
            "name": subject.label,
            "caption": f"{group.dataset} by {subject.label}: {said} of the diagonal; the brighter the farther from the "
            f"input, up to {RANGE[1]:g} of the diagonal",
        }
        yield (
            picture,
            named(pixels, subject.label, said.replace(" triangles", "").replace("RMS ", "")),
        )


def distances(mesh: TriangleMesh, made: TriangleMesh) -> NDArray[np.float64]:
    """Of the middle of each triangle of `made` to the mesh, (m,), share of the diagonal."""
    squared, _ = located(mesh).nearest(located(made, mesh).positions[made.triangles].mean(axis=1))
    return np.sqrt(squared)


def named(pixels: NDArray[np.uint8], name: str, said: str) -> NDArray[np.uint8]:
    """The picture, (h, w, 3), and under it a band with a name, as large as fits, and a line: (h + b, w, 3)."""
    from PIL import Image, ImageDraw, ImageFont

    height, width = pixels.shape[:2]
    fonts = Path(matplotlib.get_data_path()) / "fonts" / "ttf"
    large = max(height / 11, 6.0)
    margin = max(round(large / 4), 1)
    band = Image.new("RGB", (width, round(2.6 * large)), BAND)
    draw, top = ImageDraw.Draw(band), margin
    for text, file, most in (
        (name, "DejaVuSans-Bold.ttf", large),
        (said, "DejaVuSans.ttf", 0.95 * large),
    ):
        wide = draw.textlength(text, ImageFont.truetype(str(fonts / file), 100)) / 100
        size = min(most, (width - 2 * margin) / max(wide, 1e-3))
        font = ImageFont.truetype(str(fonts / file), max(size, 1))
        draw.text((margin, top), text, fill=INK, font=font)
        top += round(1.1 * most)
    return np.concatenate([pixels, np.asarray(band)])
