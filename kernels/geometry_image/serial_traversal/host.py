"""One work-item walks the tree of a `QuadtreeLod`, whose image, tree and output it shares."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from lodbench.datasets_gen.surfaces import GeometryImage, TriangleMesh
from lodbench.kernels.geometry_image.quadtree_lod import reference
from lodbench.kernels.geometry_image.quadtree_lod.host import QuadtreeLod, image_of
from lodbench.kernels.geometry_image.quadtree_lod.view import LodCriterion
from lodbench.kernels.geometry_image.serial_traversal.reference import differing
from lodbench.kernels.opencl import Device, Timeline, Unsupported
from lodbench.kernels.subject import POINT, WORD
from lodbench.kernels.system import Check

if TYPE_CHECKING:
    from lodbench.kernels.geometry_image.quadtree_lod import Params


def prepare(device: Device, mesh: TriangleMesh | GeometryImage, params: Params) -> SerialTraversal:
    """As `quadtree_lod`'s.

    Raises:
        NotSpherical: the mesh is not one closed surface of genus 0.
        Unsupported: no room; or a threshold for each node, or fitted vertices, are asked for.
    """
    if params.view == "node":
        raise Unsupported("needs one threshold for the whole model, got view='node'")
    if params.placement != "samples":
        raise Unsupported(f"needs vertices on the samples, got placement={params.placement!r}")
    setup = Timeline()
    params = params.counted(mesh.triangle_count)
    return SerialTraversal(device, image_of(device, mesh, params, setup), params, setup)


class SerialTraversal(QuadtreeLod):
    """Draws what `quadtree_lod` draws, with one work-item."""

    def _make_frame(self) -> None:
        super()._make_frame()
        device, tree = self.device, self.tree
        self._steps.clear()
        self._filter = device.build("geometry_image/serial_traversal/geometry.cl").launch(
            "serial_traversal_geometry", 1, stage="traversal", local=1,
            errors=tree.errors, image=tree.positions, image_normals=tree.normals,
            flags=self._flags, ranks=self._ranks, positions=self._positions,
            normals=self._normals, triangles=self._triangles, counts=self._counts,
            threshold=0.0, n=tree.n,
        )  # fmt: skip
        self.fill("traversal", self._flags, 0)
        self.add(self._filter, SerialTraversal._moved)

    def _moved(self) -> int:
        """Flags cleared, errors of the nodes visited, vertices and triangles written."""
        vertices, triangles = self.live()
        visited = 4 * WORD * triangles // 3
        return self.tree.side**2 + 2 * visited + 52 * vertices + POINT * triangles

    def _aim(self, criterion: LodCriterion) -> None:
        self.last = criterion
        self._filter.set(threshold=criterion.threshold)

    def check(self) -> Check:
        """Triangles that the reference lacks, or has beyond these."""
        what = "triangles that differ from the reference"
        mesh = self.result()[0]
        if self.image is None:
            return Check(mesh.triangle_count == 0, what, float(mesh.triangle_count), 0.0)
        assert self.last is not None
        fine = reference.fine_nodes(self.tree.read_errors(), [], self.last)
        expected = reference.merge(self.image, reference.node_states(fine))
        wrong = differing(mesh, expected)
        return Check(wrong == 0, what, float(wrong), 0.0)

    def more_counters(self) -> Mapping[str, int | float]:
        """None: the nodes are not kept."""
        return {}
