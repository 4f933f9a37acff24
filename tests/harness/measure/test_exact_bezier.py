from dataclasses import replace

import numpy as np
import pytest

from lodbench.datasets_gen import patches
from lodbench.datasets_gen.surfaces import BezierPatches, TriangleMesh
from lodbench.harness.measure import exact_bezier
from lodbench.harness.measure.figure import Seen
from lodbench.kernels.bezier.gst import Gst
from lodbench.kernels.bezier.gst import Params as GstParams
from lodbench.kernels.bezier.vst import Params, Vst
from lodbench.kernels.opencl import Unsupported
from lodbench.kernels.system import Check, run
from tests.kernels.bezier.patches import sheet

CUP = patches.cup()


LEVEL_3 = Params(3)


def seen(device, surface=CUP, kind=Vst, params=LEVEL_3, first=None):
    prepared = kind(device, surface, params)
    run(device, prepared)
    return Seen(device, prepared, surface, params, prepared.check(), first)


class Moved:
    """A subject with one of its vertices elsewhere."""

    def __init__(self, prepared, vertex, by=1e-3):
        self._prepared, self.arrangement = prepared, prepared.arrangement
        self._vertex, self._by = vertex, by

    def result(self):
        (mesh,) = self._prepared.result()
        points = mesh.positions.copy()
        points[self._vertex] += np.float32(self._by)
        return [TriangleMesh(points, mesh.triangles, mesh.normals)]


def test_points_and_normals_are_those_of_the_check(device):
    found = seen(device)
    points, normals = exact_bezier.points(found), exact_bezier.normals(found)
    assert points.kept and 0 < points.value == found.check.parts["position"]
    assert normals.kept and normals.limit == pytest.approx(0.1)
    assert points.looked_at == "26 of 26 patches"
    other = replace(found, check=Check(True, "triangles", 0, 0))
    with pytest.raises(Unsupported, match="needs a check of points and normals"):
        exact_bezier.points(other)


def test_open_borders_are_no_cracks_and_a_moved_vertex_is_one(device):
    found = seen(device)
    figure = exact_bezier.cracks(found)
    open_edges = found.prepared.counters()["open_edges"]
    assert figure.value == 0 and figure.looked_at == f"{8 * open_edges} more at open borders"
    points = exact_bezier.open_borders(CUP)
    (mesh,) = found.prepared.result()
    away = np.linalg.norm(mesh.positions[:9, None] - points[None], axis=2).min(axis=1)
    vertex = int(away.argmax())  # of a border: one that two patches have
    assert exact_bezier.cracks(replace(found, prepared=Moved(found.prepared, vertex))).value > 0


def test_patches_named_in_any_way_have_no_cracks(device):
    surface = sheet(3, turns=(1, 4, 6, 3))
    assert exact_bezier.cracks(seen(device, surface)).value == 0


def test_open_edges_are_those_of_an_odd_number_of_triangles():
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    same, turned = [[0, 1, 2], [2, 1, 3]], [[0, 1, 2], [1, 2, 3]]
    assert len(exact_bezier.open_edges(TriangleMesh(points, np.array(same)))) == 4
    assert len(exact_bezier.open_edges(TriangleMesh(points, np.array(turned)))) == 5
    assert len(exact_bezier.open_edges(TriangleMesh(points, np.array(turned)), False)) == 4


@pytest.mark.parametrize("reuse", ["row", "zone", "none"])
def test_gst_has_the_vertices_of_vst_and_one_that_moved_is_found(device, reuse):
    first = seen(device).prepared
    found = seen(device, CUP, Gst, GstParams(3, reuse=reuse), first)
    figure = exact_bezier.unlike_vertices(found)
    assert (figure.value, figure.looked_at) == (0, f"{26 * 81:,} vertices")
    moved = replace(found, prepared=Moved(found.prepared, 100))
    assert exact_bezier.unlike_vertices(moved).value == 1


def test_bytes_are_compared_with_those_of_the_first(device):
    found = seen(device, first=seen(device).prepared)
    assert exact_bezier.unlike_bytes(found).value == 0
    assert exact_bezier.unlike_bytes(replace(found, prepared=Moved(found.first, 5))).value > 0
    with pytest.raises(Unsupported, match="needs the group's first subject"):
        exact_bezier.unlike_bytes(replace(found, first=None))


def test_no_patches_have_no_cracks(device):
    none = BezierPatches(np.zeros((0, 4, 4, 3)))
    assert exact_bezier.cracks(seen(device, none)).value == 0
