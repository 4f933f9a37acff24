"""Pictures of a run: each mesh once, one at falling levels of detail with frame rates, what else its systems show."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Any

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.baselines.drawn_mesh import DrawnMesh, Params
from lodbench.harness.measure.timing import interleave, take
from lodbench.harness.record.record import RunRecord, read_run, write_json
from lodbench.harness.report import chains, compared
from lodbench.harness.report.adaptive_tessellations import adaptive_pictures
from lodbench.harness.report.amounts import rounded
from lodbench.harness.report.dices import dice_pictures
from lodbench.harness.report.distances import DRAWN_FROM, distance_pictures
from lodbench.harness.report.methods import method_pictures
from lodbench.harness.report.octrees import octree_pictures
from lodbench.harness.report.refinements import refinement_pictures
from lodbench.harness.report.statistics import summary
from lodbench.harness.report.tessellations import tessellation_pictures
from lodbench.harness.report.warps import warp_pictures
from lodbench.kernels import simplify_mesh
from lodbench.kernels.image import write_png
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.render import mesh_view, render
from lodbench.kernels.stages.camera import TABLE_SIZE
from lodbench.kernels.system import Frame, View, run
from lodbench.kernels.verbs import PREFERRED

FOLDER, LIST = "images", "pictures.json"
SIZE = (640, 512)  # pixels; of the same shape as the tables' images, and drawn at twice the size
MOST_TRIANGLES = 2_000_000  # larger ones take longer to make than all pictures together
SHARES = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003)  # of the triangles, in the strip of levels
LEAST_TRIANGLES = 12  # of a level
LYING = ("terrain", "plane", "plate")  # shapes whose z points upwards
SAMPLES = 10


def write_pictures(folder: Path, device: Device) -> list[dict[str, Any]]:
    """Draw what the run measured into `images/`, listed with captions in `images/pictures.json`.

    Pictures of one `series` stand together.

    Args:
        folder: the run's folder.
        device: what draws, and draws the levels some ten times more to time them.

    Raises:
        ValueError: not a run's folder.
        OSError: a picture cannot be written.
    """
    record = read_run(folder)
    images = Path(folder) / FOLDER
    images.mkdir(exist_ok=True)
    found = []
    for picture, pixels in chain(
        _levels(record, device),
        _chain(record, device),
        _distances(record, device),
        _compared(record, device),
        warp_pictures(record, SIZE, device),
        octree_pictures(record, SIZE, device),
        method_pictures(record, SIZE, device),
        refinement_pictures(record, SIZE, device),
        tessellation_pictures(record, SIZE, device),
        adaptive_pictures(record, SIZE, device),
        dice_pictures(record, SIZE, device),
        _datasets(record, device),
    ):
        write_png(images / picture["file"], pixels)
        found.append(picture)
    write_json(images / LIST, found)
    return found


def _datasets(record: RunRecord, device: Device) -> Iterator[tuple[dict[str, Any], Any]]:
    """Every other mesh once; not again in another order of its triangles."""
    names = dict.fromkeys(group.dataset.removesuffix("_sorted") for group in record.groups)
    names.pop(_simplified(record) or "", None)
    for name in names:
        mesh = _mesh(name)
        if mesh is not None:
            pixels = render(mesh, size=SIZE, up=_up(name), device=device)
            caption = f"{name}: {mesh.triangle_count:,} triangles"
            yield {"file": f"{name}.png", "caption": caption, "name": name}, pixels


def _chain(record: RunRecord, device: Device) -> Iterator[tuple[dict[str, Any], Any]]:
    """The first mesh of which a chain of levels was made."""
    for group in record.groups:
        if any(subject.system == chains.DRAWN_FROM for subject in group.subjects.values()):
            mesh = _mesh(group.dataset)
            if mesh is not None:
                view = mesh_view(mesh, size=SIZE, up=_up(group.dataset))
                yield from chains.chain_pictures(group.dataset, mesh, view, device, group.table)
            return


def _compared(record: RunRecord, device: Device) -> Iterator[tuple[dict[str, Any], Any]]:
    """The subjects of the first group of each table that compares them by eye."""
    for table, series in compared.TABLES.items():
        for group in record.groups:
            mesh = _mesh(group.dataset) if group.table == table else None
            if mesh is not None:
                view = mesh_view(mesh, size=SIZE, up=_up(group.dataset))
                yield from compared.subject_pictures(series, group, mesh, view, device)
                break


def _distances(record: RunRecord, device: Device) -> Iterator[tuple[dict[str, Any], Any]]:
    """The first mesh that was drawn from its geometry image, for several distances."""
    for group in record.groups:
        if any(subject.system == DRAWN_FROM for subject in group.subjects.values()):
            mesh = _mesh(group.dataset)
            if mesh is not None:
                up = _up(group.dataset)
                measured, seen = (mesh_view(mesh, size=size, up=up) for size in (TABLE_SIZE, SIZE))
                yield from distance_pictures(
                    group.dataset, mesh, measured, seen, device, group.table
                )
            return


def _mesh(name: str) -> TriangleMesh | None:
    dataset = catalogue.find(name)
    if dataset.kind != "triangles" or (dataset.triangles or 0) > MOST_TRIANGLES:
        return None
    mesh = dataset.surface
    if not isinstance(mesh, TriangleMesh) or not mesh.triangle_count:
        return None
    return mesh.with_origin(None)  # as it was measured


def _up(name: str) -> str:
    return "z" if name.startswith(LYING) else "y"


def _simplified(record: RunRecord) -> str | None:
    """The first mesh that was simplified."""
    for group in record.groups:
        if any(subject.system in PREFERRED["simplify"][:2] for subject in group.subjects.values()):
            return group.dataset
    return None


def _levels(record: RunRecord, device: Device) -> Iterator[tuple[dict[str, Any], Any]]:
    """The first mesh that was simplified, from one camera, and how fast each level is drawn."""
    name = _simplified(record)
    mesh = None if name is None else _mesh(name)
    if name is None or mesh is None:
        return
    levels = {}
    for share in SHARES:
        count = round(share * mesh.triangle_count)
        if count < LEAST_TRIANGLES:
            break
        level = mesh if share == 1 else simplify_mesh(device, mesh, target_count=count).mesh
        levels[f"{rounded(100 * share)} %"] = level
    rates = _frame_rates(levels, mesh_view(mesh, size=TABLE_SIZE, up=_up(name)), device)
    view = mesh_view(mesh, size=SIZE, up=_up(name))
    for number, (share, level) in enumerate(levels.items()):
        rate = rates.get(share)
        caption = f"{name} at {share}: {level.triangle_count:,} triangles"
        picture = {
            "file": f"level_{number}_{name}.png",
            "series": "levels",
            "level": number,
            "caption": f"{caption}, {rounded(rate['fps'], 3)} frames/s" if rate else caption,
            **(rate or {}),
        }
        colour = "smooth" if level is mesh else "flat"
        yield picture, render(level, camera=view, colour=colour, device=device)


def _frame_rates(
    levels: Mapping[str, TriangleMesh], view: View, device: Device
) -> dict[str, dict[str, Any]]:
    """Frames per second of drawing each level at the tables' size, from the median of samples taken in turns."""
    frame = Frame(view)
    try:
        drawn = {
            name: DrawnMesh(device, level, Params(*TABLE_SIZE)) for name, level in levels.items()
        }
    except Unsupported:  # no room for the image: pictures go without
        return {}
    frames = {name: (lambda mine=mine: run(device, mine, frame)) for name, mine in drawn.items()}
    firsts = {name: take(name, call, 0, warmup=True) for name, call in frames.items()}
    seconds: dict[str, list[float]] = {name: [] for name in drawn}
    slow = {name: first.wall_s for name, first in firsts.items() if first is not None}
    for sample in interleave(frames, slow, samples=SAMPLES):
        if not sample.warmup:
            seconds[sample.subject].append(sample.wall_s)
    medians = {name: summary(values) for name, values in seconds.items()}
    return {
        name: {"fps": 1 / median.median, "samples": median.n, "size": TABLE_SIZE}
        for name, median in medians.items()
        if median is not None
    }
