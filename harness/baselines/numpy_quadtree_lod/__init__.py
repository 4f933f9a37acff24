"""The quadtree of a geometry image walked on the host, level by level from the root: numpy, no loop over nodes.

The role of the predecessor, which chooses and merges on the CPU: here all nodes of a level are looked at together in
32-bit arrays, as good numpy code does it. Same tree, same threshold and same fans as `quadtree_lod`, with vertices on
the samples; each frame's are checked one by one.

Source: Wang et al., introduction and section 3.2; Zhu, Liu & Zhang 2013, as far as the former describe it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from lodbench.datasets_gen.arrays import box
from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.harness.baselines.host import HostPrepared, host_system
from lodbench.harness.baselines.numpy_quadtree_lod.walk import Walk
from lodbench.kernels.geometry_image.parameterisation import Level, Seed, Turn, topology
from lodbench.kernels.geometry_image.quadtree_lod import Params as KernelParams
from lodbench.kernels.geometry_image.quadtree_lod.fit import pyramid
from lodbench.kernels.geometry_image.quadtree_lod.host import image_of
from lodbench.kernels.geometry_image.quadtree_lod.reference import (
    fine_nodes,
    merge,
    node_errors,
    node_states,
)
from lodbench.kernels.geometry_image.quadtree_lod.tree import unit_scale
from lodbench.kernels.geometry_image.quadtree_lod.view import LodCriterion, at_most_float32
from lodbench.kernels.opencl import Device, Timeline
from lodbench.kernels.parameters import Parameters, Range
from lodbench.kernels.system import Check


@dataclass(frozen=True)
class Params(Parameters):
    """How much detail; the words mean what they mean for the kernels.

    Attributes:
        n: the image made of a triangle mesh has (2^n + 1)^2 samples, 1 to 11.
        threshold: largest error of a drawn node, as a fraction of the bounding-box diagonal.
        seed: of the layout on the sphere.
        turn: "best" or "identity".
        cache: keep the sphere on disk.
    """

    n: Level = 8
    threshold: Annotated[float, Range(0)] = 0.001
    seed: Seed = 0
    turn: Turn = "best"
    cache: bool = True

    def kernel(self) -> KernelParams:
        """The kernels' parameters for the same output."""
        return KernelParams(
            self.n, self.threshold, seed=self.seed, turn=self.turn, cache=self.cache
        )


def _verdict(mesh: TriangleMesh, expected: TriangleMesh) -> Check:
    """Vertices and triangles against the reference's, and what the triangles enclose."""
    wrong = abs(mesh.vertex_count - expected.vertex_count)
    wrong += abs(mesh.triangle_count - expected.triangle_count)
    if not wrong:
        for name in ("positions", "normals", "triangles"):
            wrong += int((getattr(mesh, name) != getattr(expected, name)).any(axis=1).sum())
    if mesh.triangle_count:
        wrong += len(topology(mesh.triangles).faults)
    what = "vertices and triangles that differ from the reference, and faults of a closed surface"
    return Check(wrong == 0, what, float(wrong), 0.0)


def prepare(device: Device, mesh: TriangleMesh | GeometryImage, params: Params) -> HostPrepared:
    """The image and its tree on the host.

    Raises:
        NotSpherical: the mesh is not one closed surface of genus 0.
    """
    setup = Timeline()
    image = image_of(device, mesh, params.kernel(), setup)
    if image is None:
        empty = TriangleMesh(np.zeros((0, 3)), np.zeros((0, 3), int), np.zeros((0, 3)))
        return HostPrepared(
            device,
            lambda _: empty,
            read=lambda mesh: [mesh],
            verdict=lambda meshes: _verdict(meshes[0], empty),
            setup=setup,
        )
    with setup.host("quadtree"):
        flat = image.positions.reshape(-1, 3).astype(np.float64)
        diagonal = float(np.linalg.norm(np.subtract(*box(flat))))
        scale = unit_scale(diagonal)
        places = [level * np.float32(scale) for level in pyramid(image, "samples")]
        errors = [e.astype(np.float32) for e in node_errors(places)]
        walk = Walk(image, errors)
    threshold = np.float32(at_most_float32(params.threshold * diagonal * scale))

    def verdict(meshes: Sequence[TriangleMesh]) -> Check:
        states = node_states(fine_nodes(errors, [], LodCriterion(float(threshold))))
        return _verdict(meshes[0], merge(image, states))

    return HostPrepared(
        device,
        lambda _: walk(threshold),
        read=lambda drawn: [TriangleMesh(drawn.positions, drawn.triangles, drawn.normals)],
        verdict=verdict,
        setup=setup,
        input_bytes=image.positions.nbytes + image.normals.nbytes + sum(e.nbytes for e in errors),
    )


SYSTEM = host_system(
    "numpy_quadtree_lod",
    "Wang, Liu, Feng & Li, section 3.2",
    prepare,
    {"thousandth": Params(n=6), "full": Params(n=6, threshold=0.0)},
    takes=(TriangleMesh, GeometryImage),
)
