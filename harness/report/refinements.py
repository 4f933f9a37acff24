"""Pictures of refined surfaces: a wave under coarser and finer patterns, a curved sphere, creases, maps of depth tags.

Source: Boubekeur & Schlick 2005, figures 4 to 6, and 2007 for the maps, for what is shown; the meshes are ours.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.plan import registry
from lodbench.harness.record.record import GroupRecord, RunRecord, SubjectRecord
from lodbench.harness.report.amounts import rounded
from lodbench.kernels.opencl import Device
from lodbench.kernels.render import mesh_view, render
from lodbench.kernels.system import Frame, run

SPHERE = "icosphere_0"
FLAT, CURVED, TAGGED = "pattern", "pn_triangles", "st_triangles"
ADAPTIVE = "adaptive_patterns"
TAGS: Mapping[str, Mapping[str, float]] = {
    "curvature": {"tolerance": 1e-3}, "distance": {"near": 0.4}, "screen": {"pixels": 12.0},
}  # fmt: skip
SEGMENTS = 16
SHARPNESS = (0.0, 0.5, 1.0)
MOST_TRIANGLES = 5_000_000  # refined

Picture = tuple[dict[str, Any], NDArray[np.uint8]]


def refinement_pictures(
    record: RunRecord, size: tuple[int, int], device: Device
) -> Iterator[Picture]:
    """What the run's refinements are shown by, each of the four where it has measured such.

    Args:
        record: the run.
        size: of a picture, pixels.
        device: what refines and draws.

    Yields:
        `file`, `caption` and `series`, and the pixels.
    """
    yield from _waves(record, size, device)
    both = (group for group in _measured(record, CURVED) if group in [*_measured(record, FLAT)])
    curved = next(both, None) or next(_measured(record, CURVED), None)
    if curved is not None:
        yield from _sphere(size, device, {"table": curved.table})
    yield from _creases(record, size, device)
    yield from _depths(record, size, device)


def _measured(record: RunRecord, system: str) -> Iterator[GroupRecord]:
    """The groups that have a subject of this system."""
    for group in record.groups:
        if any(subject.system == system for subject in group.subjects.values()):
            yield group


def _coarse(name: str) -> TriangleMesh | None:
    mesh = catalogue.find(name).surface
    return mesh.with_origin(None) if isinstance(mesh, TriangleMesh) else None


def _refined(
    mesh: TriangleMesh, system: str, device: Device, options: Mapping[str, Any]
) -> TriangleMesh:
    """The instances that a system makes of the mesh: edges where it has them, nothing welded."""
    return registry.system(system).verbs["refine"](device, mesh, weld=False, **options).mesh


def _segments(segments: int) -> str:
    return f"{segments:,} segment{'' if segments == 1 else 's'}"


def _shown(group: GroupRecord, triangles: int) -> list[SubjectRecord]:
    """Of the subjects that were compared with a reference the coarsest, the middle one and the finest."""
    found = [
        subject
        for subject in group.subjects.values()
        if subject.status == "ok" and "rms_difference" in (subject.quality or {})
        and "refine" in registry.system(subject.system).verbs
        and triangles * subject.params["segments"] ** 2 <= MOST_TRIANGLES
    ]  # fmt: skip
    found.sort(key=lambda subject: subject.params["segments"])
    return [found[k] for k in dict.fromkeys((0, len(found) // 2, len(found) - 1))] if found else []


def _waves(record: RunRecord, size: tuple[int, int], device: Device) -> Iterator[Picture]:
    """The last group whose results were compared with a reference, from one camera."""
    compared = [group for group in record.groups if group.config.get("reference")]
    groups = [group for group in compared if not group.config.get("nearest")]
    mesh = _coarse(groups[-1].dataset) if groups else None
    shown = _shown(groups[-1], mesh.triangle_count) if mesh is not None else []
    if mesh is None or not shown:
        return
    surfaces = [_refined(mesh, subject.system, device, subject.params) for subject in shown]
    view = mesh_view(surfaces[-1], size=size)
    for number, (subject, surface) in enumerate(zip(shown, surfaces, strict=True)):
        params, off = subject.params, rounded((subject.quality or {})["rms_difference"], 2)
        caption = (
            f"{groups[-1].dataset}, {params['waves']:g} waves per diagonal, {_segments(params['segments'])}: "
            f"{surface.triangle_count:,} triangles, RMS difference {off} of the diagonal"
        )
        yield (
            {
                "file": f"wave_{number}_{groups[-1].dataset}.png",
                "caption": caption,
                "series": "waves",
                "table": groups[-1].table,
            },
            render(surface, camera=view, device=device),
        )


def _sphere(size: tuple[int, int], device: Device, about: Mapping[str, str]) -> Iterator[Picture]:
    """A sphere of few triangles, flat and curved, from one camera."""
    mesh = _coarse(SPHERE)
    assert mesh is not None
    systems = (FLAT, CURVED)
    surfaces = [_refined(mesh, system, device, {"segments": SEGMENTS}) for system in systems]
    view = mesh_view(surfaces[-1], size=size)
    for number, (system, surface) in enumerate(zip(systems, surfaces, strict=True)):
        caption = f"{SPHERE}, {system}, {_segments(SEGMENTS)}: {surface.triangle_count:,} triangles"
        yield (
            {
                "file": f"curved_{number}_{SPHERE}.png",
                "caption": caption,
                "series": "curved",
                **about,
            },
            render(surface, camera=view, device=device),
        )


def _creases(record: RunRecord, size: tuple[int, int], device: Device) -> Iterator[Picture]:
    """The first mesh with tags of its own that was refined by them, with shares of their sharpness."""
    for group in _measured(record, TAGGED):
        mesh = _coarse(group.dataset)
        if mesh is None or mesh.tags is None:
            continue
        view = mesh_view(mesh, size=size)
        for number, share in enumerate(SHARPNESS):
            tags = mesh.tags * np.asarray((1, share, 1), np.float32)
            sharpened = replace(mesh, tags=tags)
            surface = _refined(sharpened, TAGGED, device, {"segments": SEGMENTS})
            caption = (
                f"{group.dataset}, {TAGGED}, {_segments(SEGMENTS)}, sharpness up to "
                f"{rounded(float(tags[:, 1].max(initial=0)), 2)}: {surface.triangle_count:,} triangles"
            )
            yield (
                {
                    "file": f"crease_{number}_{group.dataset}.png",
                    "caption": caption,
                    "series": "creases",
                    "table": group.table,
                },
                render(surface, camera=view, device=device),
            )
        return


def _depths(record: RunRecord, size: tuple[int, int], device: Device) -> Iterator[Picture]:
    """The first mesh under adaptive patterns, coloured by depth tags of each kind, with the triangles they ask for."""
    group = next(_measured(record, ADAPTIVE), None)
    mesh = _coarse(group.dataset) if group else None
    if group is None or mesh is None:
        return
    view = mesh_view(mesh, size=size)
    system = registry.system(ADAPTIVE)
    for number, by in enumerate(TAGS):
        params = registry.parameters(system, None, {"by": by, "segments": SEGMENTS, **TAGS[by]})
        prepared: Any = system.prepare(device, mesh, params)
        run(device, prepared, Frame(view))
        tags = prepared.tags()
        tagged = replace(mesh, uvs=np.stack([tags, tags], axis=1))  # interpolated along
        surface = system.verbs["refine"](
            device, tagged, weld=False, segments=SEGMENTS, by=by, view=view, **TAGS[by]
        ).mesh
        assert surface.uvs is not None
        caption = (
            f"{group.dataset}, depth tags by {by}, up to {_segments(SEGMENTS)}: "
            f"{surface.triangle_count:,} triangles; the brighter the deeper"
        )
        options = {"wireframe": True, "colour_range": (0.0, float(np.log2(SEGMENTS)))}
        yield (
            {"file": f"depths_{number}_{by}_{group.dataset}.png", "caption": caption,
             "series": "depths", "table": group.table},
            render(surface, camera=view, colour=surface.uvs[:, 0], device=device, **options),
        )  # fmt: skip
