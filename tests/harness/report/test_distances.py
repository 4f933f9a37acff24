import numpy as np
from numpy.testing import assert_allclose, assert_array_equal

from lodbench.datasets_gen.shapes import blob_with_ears
from lodbench.datasets_gen.triangles import torus
from lodbench.harness.report.distances import DISTANCES, distance_pictures, farther, nodes_picture
from lodbench.kernels.geometry_image.parameterisation import as_pictures
from lodbench.kernels.geometry_image.quadtree_lod import SYSTEM, Params
from lodbench.kernels.render import mesh_view
from lodbench.kernels.system import run
from tests.kernels.geometry_image.test_quadtree_lod import bumpy_image


def test_farther_view_sees_the_centre_where_it_was_and_smaller():
    mesh = blob_with_ears(6)
    near = mesh_view(mesh, size=(64, 48))
    centre = sum(mesh.box) / 2
    far = farther(near, centre, 4)
    assert_allclose(np.linalg.norm(far.eye - centre), 4 * np.linalg.norm(near.eye - centre))

    def on_screen(view, point):
        clip = view.world_to_clip @ np.append(point, 1)
        return clip[:2] / clip[3]

    assert_allclose(on_screen(far, centre), on_screen(near, centre), atol=1e-9)
    aside = centre + np.cross(near.eye - centre, (0.3, 0.4, 0.5)) * 0.1
    apart = [np.linalg.norm(on_screen(v, aside) - on_screen(v, centre)) for v in (near, far)]
    assert 0 < apart[1] < 0.3 * apart[0]


def test_nodes_picture_shows_leaves_as_they_are_and_nodes_as_blocks(device):
    image = bumpy_image(5)
    full = SYSTEM.prepare(device, image, Params(threshold=0.0))
    run(device, full)
    assert_array_equal(
        nodes_picture(full)[::-16, ::16], as_pictures(image)[0][:-1, :-1]
    )  # 32 leaves a side, 16 pixels each
    coarse = SYSTEM.prepare(device, image, Params(threshold=1e6))
    run(device, coarse)
    assert len(np.unique(nodes_picture(coarse).reshape(-1, 3), axis=0)) == 4


def test_pictures_get_coarser_with_distance(device):
    mesh = blob_with_ears(16)
    measured = mesh_view(mesh, size=(1280, 1024))
    seen = mesh_view(mesh, size=(64, 48))
    made = list(distance_pictures("blob", mesh, measured, seen, device))
    assert len(made) == 2 * len(DISTANCES)
    counts = [int(p["caption"].split(": ")[1].split(" ")[0].replace(",", "")) for p, _ in made]
    assert counts[::2] == counts[1::2] == sorted(counts[::2], reverse=True)
    assert counts[0] > counts[-1]
    assert made[0][1].shape == (512, 512, 3)
    assert made[1][1].shape == (48, 64, 3)


def test_surface_with_a_handle_has_no_pictures(device):
    mesh = torus(12, 8)
    view = mesh_view(mesh, size=(64, 48))
    assert list(distance_pictures("torus", mesh, view, view, device)) == []
