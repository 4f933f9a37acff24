import numpy as np

from lodbench.datasets_gen.triangles import icosphere
from lodbench.harness.report.chains import chain_pictures
from lodbench.kernels.render import mesh_view


def test_each_level_with_triangles_is_drawn_and_named_by_them(device):
    mesh = icosphere(3)
    found = list(chain_pictures("ball", mesh, mesh_view(mesh, size=(80, 64)), device))
    assert [picture["file"] for picture, _ in found] == ["chain_1_ball.png", "chain_2_ball.png"]
    assert {picture["series"] for picture, _ in found} == {"chain"}
    first, second = (picture["caption"] for picture, _ in found)
    assert first.startswith("ball, level 1 of a chain: 1")
    assert second.startswith("ball, level 2 of a chain: ")
    (_, fine), (_, coarse) = found
    assert fine.shape == (64, 80, 3) and not np.array_equal(fine, coarse)
