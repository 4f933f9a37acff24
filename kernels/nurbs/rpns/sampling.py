"""The sampler in float64: how many KSDices a KSQuad gets, and where the vertices of a frame stand."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodbench.datasets_gen.nurbs_surface import Doubles, NurbsModel, NurbsSurface
from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.kernels.exactness import verdict
from lodbench.kernels.nurbs.reference import normals_at, points_at
from lodbench.kernels.nurbs.rpns.params import Params
from lodbench.kernels.nurbs.rpns.quads import Quads
from lodbench.kernels.nurbs.samples import Numbers, Samples, first_knots
from lodbench.kernels.stages.camera import pixel_rows
from lodbench.kernels.system import Check, View

CHECKED = 200  # KSQuads that a check looks at
NEAREST_W = 1e-20  # in front of the eye


def lengths(surface: NurbsSurface, view: View) -> tuple[Doubles, Doubles]:
    """Lengths on the screen, pixels, of curves along u, and along v, by the polyline through five points.

    Returns:
        (spans_u, spans_v, 3) each: of one border, the curve in the middle and the other border; infinite where
        some of it is behind the eye.

    Source: Concheiro 2013, section 6.3; how lengths are taken is a reconstruction.
    """
    sides = []
    for knots in (surface.knots_u, surface.knots_v):
        spans = len(first_knots(knots))
        t = np.tile(np.arange(5) / 4, spans)
        sides.append(Samples(np.repeat(np.arange(spans), 5), t))
    points = points_at(surface, *sides)
    x, y, w = (points @ np.array(row[:3]) + row[3] for row in pixel_rows(view))
    with np.errstate(all="ignore"):
        screen = np.where(
            (w > NEAREST_W)[..., None], np.stack([x, y], axis=-1) / w[..., None], np.inf
        )
        screen = screen.reshape(len(sides[0]) // 5, 5, -1, 5, 2)
        found = []
        for axis in (1, 3):
            off = np.linalg.norm(np.diff(screen, axis=axis), axis=-1).sum(axis=axis)
            off = np.where(np.isfinite(off), off, np.inf)
            found.append(np.moveaxis(off, 2 if axis == 1 else 1, 2)[..., [0, 2, 4]])
    return found[0], found[1]


def segments(surface: NurbsSurface, view: View, params: Params) -> Numbers:
    """How many segments each KSQuad gets along u and along v, (spans_u, spans_v, 2), but for those on borders."""
    side = np.sqrt(params.pixel_area)
    wanted = np.stack([length.max(axis=2) for length in lengths(surface, view)], axis=2)
    return np.clip(np.ceil(np.minimum(wanted / side, params.finest)), 1, params.finest).astype(int)


def place(k: Numbers, n: float, breaks: Doubles, even: bool) -> Doubles:
    """Where vertex k of n is, 0 to 1, (...,); breaks (..., 3) share out a side unless places are even."""
    share = k / n
    if even:
        return share
    ends = np.concatenate(
        [np.zeros((*breaks.shape[:-1], 1)), breaks, np.ones((*breaks.shape[:-1], 1))], axis=-1
    )
    part = (share[..., None] >= breaks).sum(axis=-1)
    low = np.take_along_axis(ends, part[..., None], -1)[..., 0]
    high = np.take_along_axis(ends, part[..., None] + 1, -1)[..., 0]
    return (part + (share - low) / (high - low)) / 4


@dataclass(frozen=True, eq=False)
class Sampled:
    """How the KSQuads that stayed in a frame were cut.

    Attributes:
        tables: the model's.
        quads: (k,) their numbers.
        sizes: (k, 8) as `nurbs/rpns/sampler.cl` writes them.
        factors: (edges, 4) likewise.
        params: of the frame.
    """

    tables: Quads
    quads: Numbers
    sizes: Floats
    factors: Floats
    params: Params

    @property
    def segments(self) -> Numbers:
        """Along u and v, (k, 2)."""
        return self.sizes[:, :2].astype(np.int64)

    @property
    def firsts(self) -> Numbers:
        """The first vertex of each, and the end of all, (k + 1,)."""
        return np.append(0, np.cumsum((self.segments + 1).prod(axis=1)))

    def surfaces(self) -> Numbers:
        """The surface of each vertex, (n,)."""
        return np.repeat(self.tables.places[self.quads, 0], np.diff(self.firsts))

    def _borders(self) -> list[tuple[NDArray[np.bool_], Numbers, Numbers, Numbers, Numbers]]:
        """Of each of a KSQuad's four borders its vertices, their numbers k there and its segments n; its edge and m."""
        n = np.repeat(self.segments, np.diff(self.firsts), axis=0)
        local = np.arange(self.firsts[-1]) - np.repeat(self.firsts[:-1], np.diff(self.firsts))
        i, j = np.divmod(local, n[:, 1] + 1)
        names = np.repeat(self.tables.rows[self.quads, 4:8], np.diff(self.firsts), axis=0)
        names = names.astype(np.int64)
        found = []
        for e, (on, k, own) in enumerate(
            ((i == 0, j, 1), (i == n[:, 0], j, 1), (j == 0, i, 0), (j == n[:, 1], i, 0))
        ):
            m = self.factors[names[:, e] >> 1, 0].astype(np.int64)
            found.append((on, k, n[:, own], names[:, e], m))
        return found

    def keys(self, corner_roots: Numbers) -> Numbers:
        """A number for each vertex, (n,): the same where vertices are one, by integers alone.

        Args:
            corner_roots: (corners,) the first of those that are one.
        """
        count = int(self.firsts[-1])
        if self.params.edges == "tolerant":
            return np.arange(count)
        corners = len(corner_roots)
        starts = corners + np.append(0, np.cumsum(self.factors[:, 0].astype(np.int64)))
        keys = starts[-1] + np.arange(count)
        rows = np.repeat(self.tables.rows[self.quads], np.diff(self.firsts), axis=0)
        low, width = rows[:, 8].astype(np.int64), rows[:, 9].astype(np.int64)
        ends = (
            (low, low + 1), (low + width, low + width + 1), (low, low + width),
            (low + 1, low + width + 1),
        )  # fmt: skip
        for (on, k, n, name, m), (begin, end) in zip(self._borders(), ends, strict=True):
            nearest = (2 * k * m + n) // (2 * n)
            inner = starts[name >> 1] + np.where(name & 1, m - nearest, nearest)
            corner = corner_roots[np.where(nearest == 0, begin, end)]
            keys = np.where(on, np.where((nearest == 0) | (nearest == m), corner, inner), keys)
        return keys

    @classmethod
    def none(cls) -> Sampled:
        """Of a model without surfaces."""
        none = np.zeros((0, 16), np.uint32)
        empty = np.zeros((0, 8), np.float32)
        tables = Quads(
            none[:, :8], none[:, 0], empty, empty, empty, empty, np.zeros((0, 3), np.int64), none,
            none[:, :8],
        )  # fmt: skip
        return cls(tables, np.zeros(0, np.int64), empty, empty[:, :4], Params())


def judged(model: NurbsModel, found: Sampled, mesh: TriangleMesh) -> Check:
    """Were these the points and normals of the KSQuads? Some, spread over all, are compared with float64."""
    low, high = model.box if model.surfaces else (np.zeros(3), np.zeros(3))
    size = max(float(np.linalg.norm(high - low)), float(np.abs([low, high]).max()), 1e-37)
    count = len(found.quads)
    chosen = np.unique(np.linspace(0, max(count - 1, 0), min(CHECKED, count)).astype(int))
    even = found.params.sampling != "non_uniform"
    position = normal = 0.0
    for slot in chosen:
        s, iu, iv = found.tables.places[found.quads[slot]]
        surface, sides = model.surfaces[s], []
        for n, breaks, span in zip(
            found.segments[slot],
            (found.sizes[slot, 2:5], found.sizes[slot, 5:8]),
            (iu, iv),
            strict=True,
        ):
            k = np.arange(n + 1)
            b = np.tile(breaks.astype(np.float64), (n + 1, 1))
            sides.append(Samples(np.full(n + 1, span), place(k, float(n), b, even)))
        rows = slice(found.firsts[slot], found.firsts[slot + 1])
        shape = len(sides[0]), len(sides[1]), 3
        positions = mesh.positions[rows].reshape(shape)
        expected = points_at(surface, *sides)
        free = np.ones(shape[:2], bool)  # vertices whose normals are their own
        if found.params.edges == "watertight":
            _border_points(surface, found, slot, sides, expected, free)
        off = float(np.abs(positions - expected).max())
        position = float(np.max([position, off / size]))  # NaN is worst
        if mesh.normals is not None:
            normals, certain = normals_at(surface, *sides)
            turned = np.linalg.norm(mesh.normals[rows].reshape(shape) - normals, axis=-1)
            normal = float(np.max([normal, turned[certain & free].max(initial=0)]))
    return verdict(position, normal, f"{len(chosen)} of {count} KSQuads")


def _border_points(
    surface: NurbsSurface,
    found: Sampled,
    slot: int,
    sides: list[Samples],
    points: Doubles,
    free: NDArray,
) -> None:
    """Put the points of a KSQuad's borders where they are shared, and mark those that are."""
    names = found.tables.rows[found.quads[slot], 4:8].astype(np.int64)
    even = found.params.sampling != "non_uniform"
    for e, name in enumerate(names):
        along, across = sides[int(e < 2)], sides[int(e >= 2)]
        n = len(along) - 1
        m = int(found.factors[name >> 1, 0])
        nearest = (2 * np.arange(n + 1) * m + n) // (2 * n)
        k = m - nearest if name & 1 else nearest
        breaks = np.tile(found.factors[name >> 1, 1:].astype(np.float64), (n + 1, 1))
        t = place(k, float(m), breaks, even)
        own = Samples(along.spans, 1 - t if name & 1 else t)
        end = across.ends(e % 2 == 1)
        at = (0, -1)[e % 2]
        if e < 2:
            points[at], free[at] = points_at(surface, end, own)[0], own.t == along.t
        else:
            points[:, at] = points_at(surface, own, end)[:, 0]
            free[:, at] = own.t == along.t
