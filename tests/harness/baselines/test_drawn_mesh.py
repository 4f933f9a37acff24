import numpy as np
import pytest

from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.baselines.drawn_mesh import SYSTEM, Params, outside
from lodbench.kernels.stages.camera import orbit
from lodbench.kernels.system import Frame, run

SMALL = Params(160, 128)


def test_drawn_mesh_frame_is_the_three_stages_of_drawing(device):
    prepared = SYSTEM.prepare(device, icosphere(2), SMALL)
    assert set(run(device, prepared).stage_s) == {"vertex_transform", "raster", "fragment"}
    assert prepared.check().passed
    assert not prepared.output


def test_drawn_mesh_is_checked_in_the_view_it_was_drawn_in(device):
    prepared = SYSTEM.prepare(device, icosphere(2), SMALL)
    view = orbit((0.4, 0, 0), 2.5, size=(SMALL.width, SMALL.height))
    run(device, prepared, Frame(view))
    assert prepared.check().passed
    prepared._view = orbit((0, 0, 0), 2.5, size=(SMALL.width, SMALL.height))
    check = prepared.check()
    assert not check.passed, "the image of one view is no image of another"
    assert check.value > 1


@pytest.mark.parametrize("turned", [False, True])
def test_distance_outside_a_triangle_is_that_of_its_worst_edge(turned):
    triangle = np.array([[0.0, 0], [4, 0], [0, 4]])[:: -1 if turned else 1]
    points = np.array([[1.0, 1], [-0.5, 1], [4, 4], [0, 0]])
    found = outside(np.broadcast_to(triangle, (4, 3, 2)), points)
    np.testing.assert_allclose(found, [0, 0.5, np.sqrt(8), 0])
