"""One subject on small inputs, to be run under Oclgrind: `oclgrind python -m tests.oclgrind_subject NAME`.

The last line of standard output is JSON: the checks that failed, the reasons to skip, the kernels that were launched.
"""

import dataclasses
import json
import sys
import tempfile

import numpy as np

from lodbench.datasets_gen import read
from lodbench.datasets_gen.batches import MeshFile
from lodbench.datasets_gen.nurbs import ball, quilt
from lodbench.datasets_gen.patches import cup
from lodbench.datasets_gen.surfaces import (
    BezierPatches,
    GeometryImage,
    NurbsModel,
    TriangleMesh,
)
from lodbench.datasets_gen.triangles import icosphere, plane
from lodbench.harness.measure.limits import measure, measure_compaction
from lodbench.harness.plan.registry import systems
from lodbench.kernels.bezier.semi_adaptive import Params as SemiParams
from lodbench.kernels.cluster import clustering
from lodbench.kernels.cluster.borders import cancel, edge_sums
from lodbench.kernels.cluster.edge_collapse import sweeps
from lodbench.kernels.cluster.upload import Upload
from lodbench.kernels.opencl.device import Device
from lodbench.kernels.opencl.launch import Launch
from lodbench.kernels.opencl.timeline import Timeline
from lodbench.kernels.refine.function_text import SIGNATURE
from lodbench.kernels.stages import scan
from lodbench.kernels.stages.camera import fit_box
from lodbench.kernels.stages.compact import Compact
from lodbench.kernels.stages.raster import Raster, Shading
from lodbench.kernels.stages.scan import ExclusiveScan
from lodbench.kernels.system import Frame, Unsupported, run

# the simulator runs a million instructions a second: what grows with these would take minutes
LARGEST = {
    "cells": 9,
    "segments": 4,
    "n": 4,
    "levels": 3,
    "level": 3,
    "size_bytes": 4096,
    "depth": 4,
    "width": 70,
    "height": 66,
    "sweeps": 1,
}
sweeps.MORE = 2  # a launch takes 0.08 s here, whatever it does
SIZE = LARGEST["width"], LARGEST["height"]  # pixels: two tiles in each direction


def smaller(params):
    """The same parameters with every size at most the `LARGEST` one."""
    changed = {}
    if isinstance(
        params, SemiParams
    ):  # a pattern for each combination of edges: 125 in place of 17,576
        params = dataclasses.replace(params, depth=min(params.depth, 2))
    for field in dataclasses.fields(params):
        value, most = getattr(params, field.name), LARGEST.get(field.name)
        if most is not None and value is not None:
            small = [min(one, most) for one in np.atleast_1d(value).tolist()]
            changed[field.name] = type(value)(small) if np.ndim(value) else small[0]
    return dataclasses.replace(params, **changed)


def geometry_image(n=3):
    axis = np.linspace(-1, 1, 2**n + 1)
    x, y = np.meshgrid(axis, axis, indexing="ij")
    z = 1 - np.abs(x) - np.abs(y)
    folded = z < 0
    fx = np.where(folded, (1 - np.abs(y)) * np.where(x < 0, -1, 1), x)
    fy = np.where(folded, (1 - np.abs(x)) * np.where(y < 0, -1, 1), y)
    points = np.stack([fx, fy, z], -1)
    points /= np.linalg.norm(points, axis=-1, keepdims=True)
    return GeometryImage(points, points)


def surfaces(takes):
    """Small surfaces of the types taken, an empty one and a single triangle among them."""
    if (
        TriangleMesh in takes and GeometryImage not in takes
    ):  # laid out on a sphere first: minutes here
        sphere = icosphere(1)
        yield (
            "sphere",
            TriangleMesh(sphere.positions, sphere.triangles, colours=np.abs(sphere.positions)),
        )
        yield "triangle", TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
        thin = [[0, 0, 0], [0, 9, 0], [0, 0, 9], [1e-39, 9, 9]]
        yield "thin", TriangleMesh(thin, [[0, 1, 2], [1, 3, 2]])
        yield "empty", TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), np.uint32))
    if BezierPatches in takes:
        yield "cup", BezierPatches(cup().points[:3])
        yield "one patch", BezierPatches(cup().points[:1])
        yield "empty", BezierPatches(np.zeros((0, 4, 4, 3)))
    if NurbsModel in takes:
        yield "ball", ball()
        yield "quilt", quilt(1, 2, 2)
    if GeometryImage in takes:
        yield "image", geometry_image()
        yield "image in runs", geometry_image(4)  # wide enough for the vector paths


def draw(device, prepared, subject):
    """The frame again, drawn, with private maps and with a shared one, and as two surfaces."""
    view = fit_box((-1, -1, -1), (1, 1, 1), size=SIZE)
    for shared in (False, True):
        shading = Shading(wireframe=shared, by_triangle=shared)
        raster = Raster(device, prepared.output, *SIZE, shading, shared=shared, view=view)
        run(device, prepared, Frame(view), raster)
    twice = [*prepared.output, *prepared.output]
    Raster(device, twice, *SIZE, view=view)(twice, Frame(view), Timeline())
    device.wait()
    counting = Raster(device, prepared.output, *SIZE, count=True, view=view)
    run(device, prepared, Frame(view), counting)


def run_in_chunks(device, system):
    """The first case again, cut into more chunks than so few rows have by themselves."""
    whole, few = scan.CHUNK_ROWS, clustering.FEW_WORDS
    scan.CHUNK_ROWS, clustering.FEW_WORDS = 16, 0
    try:
        surface = next(surface for _, surface in surfaces(system.takes))
        prepared = system.prepare(device, surface, smaller(next(iter(system.cases.values()))))
        run(device, prepared)
        check = prepared.check()
        return [] if check.passed else [f"in chunks: {check.what} {check.value}"]
    finally:
        scan.CHUNK_ROWS, clustering.FEW_WORDS = whole, few


def run_borders(device):
    """Border edges of more rows than a chunk has, by two cores' maps."""
    whole, facts, scan.CHUNK_ROWS = scan.CHUNK_ROWS, device.facts, 16
    try:
        device.facts = dataclasses.replace(facts, compute_units=2)
        sheet = Upload(device, plane(6))
        found = len(sheet.border_edges)
        closed = cancel(device.read(edge_sums(device, sheet.program, sheet.triangles)))
        return [] if found == 24 and not closed else [f"borders: {found} edges, closed: {closed}"]
    finally:
        scan.CHUNK_ROWS, device.facts = whole, facts


def run_shared(device, system):
    """The first case where items share a map, as on a GPU: what atomics placed is brought into order."""
    whole, kind, scan.GPU_CHUNK_ROWS, device.is_cpu = scan.GPU_CHUNK_ROWS, device.is_cpu, 16, False
    try:
        params = dataclasses.replace(smaller(next(iter(system.cases.values()))), form="blocks")
        prepared = system.prepare(device, icosphere(1), params)
        run(device, prepared)
        check = prepared.check()
        return [] if check.passed else [f"shared: {check.what} {check.value}"]
    finally:
        scan.GPU_CHUNK_ROWS, device.is_cpu = whole, kind


def run_system(device, name):
    failed, skipped = [], []
    system = systems()[name]
    drawn = False
    cases = {smaller(params): case for case, params in reversed(system.cases.items())}
    for params, case in reversed(cases.items()):  # those that differ in size alone, once
        for label, surface in surfaces(system.takes):
            subject = f"{case} {label}"
            try:
                prepared = system.prepare(device, surface, params)
                run(device, prepared)
            except Unsupported as reason:
                skipped.append(f"{subject}: {reason}")
                continue
            check = prepared.check()
            if not check.passed:
                failed.append(f"{subject}: {check.what} {check.value} > {check.tolerance}")
            if prepared.output and not drawn:
                draw(device, prepared, subject)
                drawn = True
    if name in ("adaptive_patterns", "level_chain"):
        failed += run_in_chunks(device, system)
    if name == "vst":
        failed += run_long_rows(device, system)
    if name == "quadric_clustering":
        failed += run_borders(device)
    if name == "edge_collapse":
        failed += run_shared(device, system)
    failed += run_mapped(device, system)
    if system.streams is not None:
        run_streamed(device, system)
    simplify = getattr(sys.modules[system.prepare.__module__.rpartition(".")[0]], "simplify", None)
    if (
        simplify is not None
    ):  # the search for a number of triangles, and the vertex map, have kernels of their own
        made = simplify(device, icosphere(0), target_count=16)
        if made.mesh.triangle_count > 16:
            failed.append(f"simplify: {made.mesh.triangle_count} triangles, 16 asked for")
        if hasattr(next(iter(system.cases.values())), "remove_duplicates"):
            both = {"remove_duplicates": True} | (
                {} if name == "level_chain" else {"manifold": True}
            )
            simplify(device, icosphere(0), target_count=16, **both)
        if name == "quadric_clustering":
            simplify(device, plane(3), target_count=10, border="keep")
    return failed, skipped


def run_long_rows(device, system):
    """Two patches with rows long enough to be walked from both ends."""
    surface = BezierPatches(cup().points[:2])
    prepared = system.prepare(device, surface, next(iter(system.cases.values())))
    run(device, prepared)
    check = prepared.check()
    return [] if check.passed else [f"long rows: {check.what} {check.value}"]


def run_streamed(device, system):
    """A file in batches, with a border that is held or kept and normals that come along."""
    sheet = plane(3)
    mesh = dataclasses.replace(sheet, normals=np.ones_like(sheet.positions))
    with tempfile.TemporaryDirectory() as folder:
        read.write_mesh(f"{folder}/a.ply", mesh)
        ways = [{"cells": 3}]
        if hasattr(next(iter(system.cases.values())), "border"):
            ways.append({"target_count": 10, "border": "keep"})
        for options in ways:
            with tempfile.TemporaryFile() as spill:
                file = MeshFile(f"{folder}/a.ply")
                system.streams(device, file, spill, 7, lambda what, share: None, **options)


def run_mapped(device, system):
    """What raises a surface over texture coordinates: of a system's cases none has a picture, or a mesh for it."""
    params, failed = smaller(next(iter(system.cases.values()))), []
    if not hasattr(params, "height_map"):
        return failed
    ball = icosphere(0)
    mesh = TriangleMesh(ball.positions, ball.triangles, uvs=ball.positions[:, :2] * 3)
    wave = f"{SIGNATURE} {{ return 0.1f * cos(uv.x + position.y); }}"
    picture = {"displacement": "height_map", "height_map": np.eye(3, 5), "amplitude": 0.1}
    for own in (
        {"displacement": "function", "function": wave},
        picture,
        picture | {"map_filter": "nearest"},
    ):
        prepared = system.prepare(device, mesh, dataclasses.replace(params, **own))
        run(device, prepared)
        if not prepared.check().passed:
            failed.append(f"{own}")
    return failed


def run_stages(device):
    """The shared pieces by themselves: sizes around a vector and a chunk, and a live count on the device."""
    failed = []
    for rows in (0, 1, 17, 4097, 9000):
        random = np.random.default_rng(rows)
        counts = random.integers(0, 9, rows, dtype=np.uint32)
        flags = (random.random(rows) < 0.3).astype(np.uint8)
        for live in (rows, rows // 2):
            limit = device.upload("live", np.array([live], np.uint32))
            total = device.allocate("total", 1, np.uint32)
            buffers = device.upload("counts", counts), device.upload("offsets", counts)
            ExclusiveScan(device, *buffers, total, live=limit)(Timeline())
            if device.read(total)[0] != counts[:live].sum():
                failed.append(f"scan of {live} of {rows}")
            Compact(
                device, device.upload("flags", flags), total, rows=[buffers], live=limit,
                indices=device.allocate("indices", rows, np.uint32),
            )(Timeline())  # fmt: skip
            if device.read(total)[0] != flags[:live].sum():
                failed.append(f"compaction of {live} of {rows}")
    measure(device, size_bytes=4096, samples=1, steps=8)
    measure_compaction(device, 100, samples=1)
    return failed, []


def main(name):
    launched = set()
    enqueue = Launch.__call__

    def recorded(self, timeline):
        launched.add(self._kernel.function_name)
        return enqueue(self, timeline)

    Launch.__call__ = recorded
    device = Device.open("oclgrind")
    failed, skipped = run_stages(device) if name == "stages" else run_system(device, name)
    found = {"failed": failed, "skipped": skipped, "launched": sorted(launched)}
    sys.stdout.write("\n" + json.dumps(found) + "\n")


if __name__ == "__main__":
    main(sys.argv[1])
