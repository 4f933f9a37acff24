"""The pipeline's subject: what its last frame left, and whether it was right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.kernels.nurbs.rpns.frames import Frames
from lodbench.kernels.nurbs.rpns.reference import visible
from lodbench.kernels.nurbs.rpns.sampling import Sampled, judged
from lodbench.kernels.system import Check, Frame, View


class Rpns(Frames):
    """A model under the pipeline: see `lodbench.kernels.nurbs.rpns`."""

    _lost: tuple[Frame | None, tuple[int, int, float]] | None = (
        None  # of a frame, once it was asked for
    )

    def kept(self) -> NDArray[np.bool_]:
        """Which KSQuads the last frame kept, in their order."""
        self.live()
        if not self.quads:
            return np.zeros(0, bool)
        return self.device.read(self._flags).astype(bool)

    def sampled(self) -> Sampled:
        """How the last frame's KSQuads were cut."""
        kept = np.flatnonzero(self.kept())
        if not self.quads:
            return Sampled.none()
        sizes, factors = self.device.read_all((self._sizes, len(kept)), (self._factors, None))
        return Sampled(self._tables, kept, sizes, factors, self._params)

    def result(self) -> Sequence[TriangleMesh]:
        """The last frame's mesh, KSQuad after KSQuad."""
        vertices, triangles = self.live()
        wanted = [
            (self.output[0].positions, vertices), (self.output[0].triangles, triangles),
            (self.output[0].normals or self.output[0].positions, vertices),
        ]  # fmt: skip
        points, faces, normals = (a.reshape(-1, 3) for a in self.device.read_all(*wanted))
        return [TriangleMesh(points, faces, normals if self._params.normals else None)]

    def _split(self) -> tuple[TriangleMesh, NDArray[np.int64], NDArray[np.int64]]:
        """The last frame's mesh, and of each vertex its surface and what place it stands at."""
        (mesh,) = self.result()
        found = self.sampled()
        root = np.arange(self.vertices)
        root[self.shared.vertices] = self.shared.roots
        return mesh, found.surfaces(), found.keys(root)

    def welded(self) -> TriangleMesh:
        """The last frame's mesh with every shared vertex once, and triangles at collapsed edges left out.

        A vertex has the mean of the normals there. With tolerant edges KSQuads share nothing.
        """
        mesh, _, keys = self._split()
        return _joined(mesh, keys)

    def parts(self) -> list[TriangleMesh]:
        """A mesh for each surface; where surfaces share a border, its points are the same to the bit in both."""
        mesh, surfaces, keys = self._split()
        made = []
        for s in range(len(self.model.surfaces)):
            first, end = np.searchsorted(surfaces, [s, s + 1])
            a = mesh.triangles[:, 0]
            own = mesh.triangles[(a >= first) & (a < end)] - np.uint32(first)
            normals = None if mesh.normals is None else mesh.normals[first:end]
            part = TriangleMesh(mesh.positions[first:end], own, normals)
            made.append(_joined(part, keys[first:end]))
        return made

    def check(self) -> Check:
        """Points and normals of some KSQuads against float64; certified culling dropped nothing that is visible."""
        (mesh,) = self.result()
        found = judged(self.model, self.sampled(), mesh)
        certified = self._params.culling == "certified"
        if found.passed and certified and (wrong := self.lost()[1]):
            what = "KSQuads culled of which a sample is in view and faces the eye"
            return Check(False, what, float(wrong), 0.0)
        return found

    def lost(self) -> tuple[int, int, float]:
        """KSQuads that the last frame culled, those of them of which some sample is in view and faces the eye, and
        which share of all samples that do these are.
        """
        frame = self.frame
        if self._lost is None or self._lost[0] is not frame:
            self._lost = frame, self._found_lost(None if frame is None else frame.view)
        return self._lost[1]

    def _found_lost(self, view: View | None) -> tuple[int, int, float]:
        kept = self.kept()
        if view is None or kept.all():
            return int((~kept).sum()), 0, 0.0
        seen = visible(self.model, view)
        share = float(seen[~kept].sum() / max(float(seen.sum()), 1e-9))
        return int((~kept).sum()), int((seen[~kept] > 0).sum()), share

    def more_counters(self) -> Mapping[str, int | float]:
        """With the KSQuads kept and culled, what was lost, and how fine the others are."""
        culled, wrong, share = self.lost()
        sizes = self.sampled().segments
        return {
            **super().more_counters(),
            "quads_kept": self.quads - culled,
            "quads_culled": culled,
            "quads_lost": wrong,
            "visible_lost": share,
            "dices": int(sizes.prod(axis=1).sum()),
            "most_segments": int(sizes.max(initial=0)),
        }


def _joined(mesh: TriangleMesh, keys: NDArray[np.int64]) -> TriangleMesh:
    """With vertices of one key once, and no triangle that has one twice."""
    _, first, vertex = np.unique(keys, return_index=True, return_inverse=True)
    order = np.argsort(first)  # as they came
    number = np.empty(len(first), np.uint32)
    number[order] = np.arange(len(first), dtype=np.uint32)
    vertex, first = number[vertex.reshape(-1)], first[order]
    triangles = vertex[mesh.triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    normals = mesh.normals
    if normals is not None:
        sums = np.stack([np.bincount(vertex, normals[:, k], len(first)) for k in range(3)], axis=1)
        length = np.linalg.norm(sums, axis=1, keepdims=True)
        unit = sums / np.where(length > 0, length, 1)
        normals = np.where(length > 1e-6, unit, normals[first]).astype(np.float32)
    used = np.zeros(len(first), bool)
    used[triangles] = True
    place = (np.cumsum(used) - 1).astype(np.uint32)
    return TriangleMesh(
        mesh.positions[first][used], place[triangles], None if normals is None else normals[used]
    )
