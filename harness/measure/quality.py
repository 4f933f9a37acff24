"""How good a result is: its distance to the input, both ways, and what became of its topology."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from lodbench.datasets_gen.surfaces import Floats, TriangleMesh
from lodbench.harness.measure.areas import vertex_areas
from lodbench.harness.measure.border import border_distance
from lodbench.kernels.opencl import Unsupported

POINTS_LIMIT = 1_000_000  # vertices or centroids looked up per mesh: a few seconds
COMPARED = 200_000  # points of a finer surface that are looked up: a second
EPSILON32 = float(np.finfo(np.float32).eps)


def _igl() -> Any:
    try:
        import igl
    except ImportError:
        raise Unsupported(
            "needs libigl to measure errors, this environment has none: pip install 'lodbench[report]'"
        ) from None
    return igl


Placed = tuple[NDArray[np.float64], NDArray[np.float64], float]


def _frame(mesh: TriangleMesh) -> Placed:
    """The mesh's origin, lower box corner from there, and diagonal: what both meshes are moved and scaled by.

    The square of 1e20 is within float64, but its product in the distance code is not always: all is unit size.
    """
    return _origin(mesh), mesh.box[0], mesh.diagonal or 1.0


def _origin(mesh: TriangleMesh) -> NDArray[np.float64]:
    return np.zeros(3) if mesh.origin is None else mesh.origin


def _placed(mesh: TriangleMesh, points: Floats, frame: Placed) -> NDArray[np.float64]:
    """Points that count from the mesh's origin, moved and scaled by `frame`."""
    origin, low, scale = frame
    low = low + (origin - _origin(mesh))  # the difference first: it is small where the sum is not
    return (points.astype(np.float64) - low) / scale


class Located:
    """A mesh in its reference's unit box, with the tree that answers nearest-triangle queries."""

    def __init__(self, mesh: TriangleMesh, frame: Placed) -> None:
        self.positions = _placed(mesh, mesh.positions, frame)
        self.triangles = mesh.triangles.astype(np.int64)
        corners = [self.positions[self.triangles[:, k]] for k in range(3)]
        self.normals = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        self._tree = _igl().AABB()
        self._tree.init(self.positions, self.triangles)

    def nearest(self, points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Squared distance to, and index of, the nearest triangle of each point."""
        squared, index, _ = self._tree.squared_distance(self.positions, self.triangles, points)
        return np.maximum(np.atleast_1d(squared), 0.0), np.atleast_1d(index)

    def samples(self, count: int, rng: np.random.Generator) -> NDArray[np.float64]:
        """Points spread evenly over the area, in the order of the triangles."""
        area = np.linalg.norm(self.normals, axis=1)
        total = np.cumsum(area if area.any() else np.ones(len(area)))
        chosen = np.searchsorted(total, np.sort(rng.random(count)) * total[-1], side="right")
        corners = self.triangles[np.minimum(chosen, len(area) - 1)]
        root, along = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
        a, b, c = (self.positions[corners[:, k]] for k in range(3))
        return (1 - root) * a + root * (1 - along) * b + root * along * c

    def vertices(self) -> NDArray[np.float64]:
        """The vertices that a triangle uses, or an even choice of `POINTS_LIMIT` of them."""
        used = np.zeros(len(self.positions), bool)
        used[self.triangles.ravel()] = True
        return self.positions[_spread(np.flatnonzero(used))]


def _spread(index: NDArray[np.int64]) -> NDArray[np.int64]:
    return index[:: -(-len(index) // POINTS_LIMIT)] if len(index) else index


@lru_cache(
    maxsize=1
)  # the tree of a reference costs more than all queries; its results follow each other
def _located(reference: TriangleMesh) -> Located:
    return Located(reference, _frame(reference))


def located(mesh: TriangleMesh, reference: TriangleMesh | None = None) -> Located:
    """A mesh as nearest triangles are asked for, in the unit box of `reference`, its own without one.

    Raises:
        Unsupported: libigl is not installed.
    """
    return _located(mesh) if reference is None else Located(mesh, _frame(reference))


def distance_from(
    reference: TriangleMesh, result: TriangleMesh, diagonal: float
) -> dict[str, float | int]:
    """How far the vertices of a finer surface, an even choice of them, are from the triangles of a coarser one.

    Args:
        reference: the finer surface.
        result: the coarser, in the same units.
        diagonal: that distances are fractions of.

    Returns:
        `rms_difference`, `max_difference`, `mean_difference`, in which a point counts by the area around it, and how
        many points there were, `compared_points`.

    Raises:
        Unsupported: libigl is not installed.
        ValueError: the result has no triangles.
    """
    if not result.triangle_count:
        raise ValueError("result: expected triangles to compare, got none")
    frame = _origin(result), result.box[0], diagonal or 1.0
    located = Located(result, frame)
    # odd: no row of a pattern is met at one place alone
    step = -(-reference.vertex_count // COMPARED) | 1
    points = _placed(reference, reference.positions[::step], frame)
    squared, _ = located.nearest(points)
    areas = vertex_areas(reference)[::step]
    return {
        "mean_difference": float((np.sqrt(squared) * areas).sum() / (areas.sum() or 1.0)),
        "rms_difference": float(np.sqrt(squared.mean())),
        "max_difference": float(np.sqrt(squared.max())),
        "compared_points": len(points),
    }


def measure(
    reference: TriangleMesh, result: TriangleMesh, seed: int = 0, *, samples: int = 100_000
) -> dict[str, float | int | None]:
    """Distances between two surfaces, the triangles that were turned over, and the result's topology.

    Args:
        reference: the input; distances are fractions of its bounding-box diagonal.
        result: what was made of it, in the same units.
        seed: of the samples: same seed, same figures.
        samples: points per direction, spread by area.

    Returns:
        `rms_error`: root of the mean squared distance from the reference's samples to the result.
        `rms_error_back`: the same from the result's samples to the reference.
        `max_error`: largest distance either way, over the samples and the vertices of both.
        `flipped_triangles`: triangles of the result that face away (a negative dot product) from the triangle of the
            reference nearest to their centroid; triangles without area are not counted. On a sheet thinner than the
            error this may be the sheet's other side. None above 1,000,000 triangles.
        `border_error`: largest distance between the borders, either way; see `border.border_distance`.
        `error_samples`: samples per direction. `error_vertices`: vertices tested, at most 1,000,000 per mesh.
        All errors are 0 when both meshes have no triangles, None when one has none. And what `topology` counts.

    Raises:
        Unsupported: libigl is not installed.
        ValueError: samples below 1.

    Source: Aspert, Santa-Cruz & Ebrahimi 2002, MESH (sampled distances, both directions); Cignoni, Rocchini &
    Scopigno 1998, Metro. Here the samples are seeded and spread by area, and vertices are always tested.
    """
    if samples < 1:
        raise ValueError(f"samples: expected at least 1, got {samples}")
    if not reference.triangle_count or not result.triangle_count:
        error = 0.0 if reference.triangle_count == result.triangle_count else None
        return {
            "rms_error": error, "rms_error_back": error, "max_error": error, "border_error": None,
            "flipped_triangles": 0, "error_samples": 0, "error_vertices": 0, **topology(result),
        }  # fmt: skip
    rng = np.random.default_rng(seed)
    there, here = _located(reference), Located(result, _frame(reference))
    figures, largest, tested = [], 0.0, 0
    for source, target in ((there, here), (here, there)):
        squared, _ = target.nearest(source.samples(samples, rng))
        vertices = source.vertices()
        at_vertices, _ = target.nearest(vertices)
        figures.append(float(np.sqrt(squared.mean())))
        largest = max(largest, float(np.sqrt(max(squared.max(), at_vertices.max()))))
        tested += len(vertices)
    flipped = None
    if result.triangle_count <= POINTS_LIMIT:
        _, nearest = there.nearest(here.positions[here.triangles].mean(axis=1))
        flipped = int((np.einsum("ij,ij->i", here.normals, there.normals[nearest]) < 0).sum())
    return {
        "rms_error": figures[0],
        "rms_error_back": figures[1],
        "max_error": largest,
        "border_error": border_distance(reference, result),
        "flipped_triangles": flipped,
        "error_samples": samples,
        "error_vertices": tested,
        **topology(result),
    }


def topology(mesh: TriangleMesh) -> dict[str, int]:
    """Counts that tell whether a surface is still one.

    Connectivity is by index: corners at the same place with different indices are different vertices. A triangle that
    names a vertex twice has no edges; vertices that no other triangle uses are no part of the surface.

    Returns:
        `open_edges`: edges of one triangle. `nonmanifold_edges`: edges of three or more.
        `flipped_edges`: edges whose two triangles run along them the same way, so one of them is turned over.
        `components`: connected parts (through shared vertices). `euler`: vertices - edges + triangles.
        `duplicate_triangles`: copies beyond the first, in any rotation or orientation.
        `degenerate_triangles`: a vertex named twice, or a height within float32 rounding of the longest edge.
    """
    if mesh.vertex_count >= 1 << 31:
        raise ValueError(f"mesh: expected fewer than 2^31 points, got {mesh.vertex_count}")
    t = mesh.triangles
    a, b, c = t[:, 0], t[:, 1], t[:, 2]
    whole = (a != b) & (b != c) & (c != a)
    t = t if whole.all() else t[whole]
    edges = _directed_edges(t)
    same: NDArray[np.uint64] = edges >> np.uint64(1)
    first = np.flatnonzero(np.append(True, same[1:] != same[:-1])[: len(same)])
    uses = np.diff(np.append(first, len(same)))
    pairs = first[uses == 2]
    unique: NDArray[np.uint64] = same[first]
    components, used = _components(unique, mesh.vertex_count)
    return {
        "open_edges": int((uses == 1).sum()),
        "nonmanifold_edges": int((uses > 2).sum()),
        "flipped_edges": int(((edges[pairs] ^ edges[pairs + 1]) & 1 == 0).sum()),
        "components": components,
        "euler": used - len(unique) + len(t),
        "duplicate_triangles": _duplicates(t),
        "degenerate_triangles": int((~whole).sum()) + _slivers(mesh, t),
    }


def _directed_edges(t: NDArray[np.uint32]) -> NDArray[np.uint64]:
    """All edges as sorted keys: lower index, higher index, and 1 where the triangle runs from high to low."""
    edges = np.zeros((3, len(t)), np.uint64)
    for k in range(3):
        start, end = t[:, k], t[:, (k + 1) % 3]
        edges[k] = np.minimum(start, end)
        edges[k] <<= np.uint64(31)
        edges[k] |= np.maximum(start, end)
        edges[k] <<= np.uint64(1)
        edges[k] |= start > end
    edges = edges.ravel()
    edges.sort()
    return edges


def _components(unique: NDArray[np.uint64], vertex_count: int) -> tuple[int, int]:
    """Connected parts that have an edge, and the vertices in them; the keys are sorted by their lower vertex."""
    low, high = unique >> np.uint64(31), unique & np.uint64((1 << 31) - 1)
    used = np.zeros(vertex_count, bool)
    used[low] = used[high] = True
    starts = np.searchsorted(low, np.arange(vertex_count + 1, dtype=np.uint64)).astype(np.int32)
    graph = csr_matrix(
        (np.ones(len(high), np.int8), high.astype(np.int32), starts),
        shape=(vertex_count, vertex_count),
    )
    parts = connected_components(graph, directed=False, return_labels=False) if vertex_count else 0
    vertices = int(used.sum())
    return int(parts) - (vertex_count - vertices), vertices


def _duplicates(t: NDArray[np.uint32]) -> int:
    rows = np.sort(t, axis=1).astype(np.uint64)
    pair, last = rows[:, 0] << np.uint64(32) | rows[:, 1], rows[:, 2]
    order = np.argsort(pair, kind="stable")
    pair, last = pair[order], last[order]
    rank = np.cumsum(np.append(0, pair[1:] != pair[:-1])).astype(np.uint64) if len(pair) else pair
    key = np.sort(rank << np.uint64(32) | last)
    return int((key[1:] == key[:-1]).sum())


def _slivers(mesh: TriangleMesh, t: NDArray[np.uint32]) -> int:
    positions = mesh.positions.astype(np.float64)  # fourth powers of any float32 are within range
    count = 0
    for start in range(0, len(t), POINTS_LIMIT):  # in pieces: all corners at once are 72 bytes each
        a, b, c = (positions[t[start : start + POINTS_LIMIT, k]] for k in range(3))
        sides = b - a, c - b, a - c
        longest = np.max([np.einsum("ij,ij->i", side, side) for side in sides], axis=0)
        normal = np.cross(sides[0], sides[1])
        count += int((np.einsum("ij,ij->i", normal, normal) <= (EPSILON32 * longest) ** 2).sum())
    return count
