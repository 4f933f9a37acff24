import numpy as np
import pytest
import trimesh

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.datasets_gen.triangles import icosphere
from lodbench.kernels import Unsupported, refine
from lodbench.kernels.image import psnr
from lodbench.kernels.render import colour_table, mesh_view, render

SPHERE = icosphere(3)
SIZE = (120, 90)
TETRAHEDRON = TriangleMesh(
    [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
)


def covered(image):
    """Pixels that differ from the background of their row."""
    return (image != image[:, :1]).any(-1)


def test_render_gives_an_image_with_the_mesh_in_its_middle(device):
    image = render(SPHERE, size=SIZE, device=device)
    assert image.shape == (90, 120, 3) and image.dtype == np.uint8
    rows, columns = np.nonzero(covered(image))
    assert abs((rows.min() + rows.max()) / 2 - 44.5) <= 1
    assert abs((columns.min() + columns.max()) / 2 - 59.5) <= 1
    assert 0.9 < (rows.max() - rows.min()) / 90 < 1


def test_render_takes_every_form_of_a_mesh(device):
    expected = render(SPHERE, size=SIZE, device=device)
    mesh = trimesh.Trimesh(SPHERE.positions, SPHERE.triangles, process=False)
    pair = (SPHERE.positions.astype(float).tolist(), SPHERE.triangles.astype(np.int64))
    for given in ((mesh,), (pair,), pair):
        image = render(*given, size=SIZE, device=device)
        assert psnr(image, render(pair[0], pair[1], size=SIZE, device=device)) == np.inf
        assert psnr(image, expected) > 30  # normals made, or those of the sphere


def test_render_shows_facets_edges_and_triangles(device):
    pictures = [
        render(icosphere(1), size=SIZE, colour=colour, device=device)
        for colour in ("smooth", "flat", "wireframe", "triangle")
    ]
    for k, a in enumerate(pictures):
        for b in pictures[:k]:
            assert psnr(a, b) < 40
        np.testing.assert_array_equal(covered(a), covered(pictures[0]))


def test_render_colours_by_values_of_points_or_faces(device):
    height = SPHERE.positions[:, 1]
    image = render(
        SPHERE,
        size=SIZE,
        camera=(0, 0),
        colour=height,
        colour_map=[(0, 0, 1), (1, 0, 0)],
        device=device,
    ).astype(int)
    middle = image[:, 60]
    assert middle[10, 0] > middle[10, 2] + 50 and middle[80, 2] > middle[80, 0] + 30
    faces = (np.arange(SPHERE.triangle_count) % 2).astype(float)
    striped = render(SPHERE, size=SIZE, colour=faces, colour_map="gray", device=device)
    assert striped.std() > 10
    same = render(SPHERE, size=SIZE, colour=height * 0 + 3, device=device)
    assert covered(same).any()


def test_render_shows_the_colours_of_vertices(device):
    corners, colours = [[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.eye(3)
    mesh = TriangleMesh(corners, [[0, 1, 2]], colours=colours)
    image = render(mesh, size=(90, 90), camera=(0, 0), colour="vertex", device=device)
    view = mesh_view(mesh, (0, 0), (90, 90))
    inside = np.full((3, 3), 0.06) + 0.82 * np.eye(3)
    for weights in (*inside, np.full(3, 1 / 3)):
        clip = view.world_to_clip @ (*(weights @ corners), 1)
        x, y = ((clip[:2] / clip[3]) * (1, -1) + 1) * 45
        light = image[int(y), int(x)].astype(float) ** 2
        shares = light / light.sum()
        # a white highlight and the sky add a little to each channel
        assert np.abs(shares - weights).max() < 0.05


def test_render_looks_from_where_it_is_told(device):
    marks = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
    for axis, camera, up, where in (
        ("x", (0, 0), "y", "right"),
        ("y", (0, 0), "y", "top"),
        ("z", (90, 0), "y", "left"),
        ("x", (0, 0), "z", "right"),
        ("z", (0, 0), "z", "top"),
        ("y", (90, 0), "z", "right"),
        ("x", (0, 0), "x", "top"),
    ):
        view = mesh_view(TETRAHEDRON, camera, (100, 100), up)
        ends = np.array([(*np.multiply(marks[axis], t), 1) for t in (0, 1)])
        clip = ends @ view.world_to_clip.T
        move = np.diff(clip[:, :2] / clip[:, 3:], axis=0)[0]
        side = np.argmax(np.abs(move))
        assert (
            ("right", "top")[side] == where if move[side] > 0 else ("left", "bottom")[side] == where
        )


def test_render_takes_a_view_with_its_own_size(device):
    view = mesh_view(SPHERE, (10, 20), (64, 48))
    image = render(SPHERE, camera=view, device=device)
    assert image.shape == (48, 64, 3)
    np.testing.assert_array_equal(
        image, render(SPHERE, camera=(10, 20), size=(64, 48), device=device)
    )


def test_edges_are_as_wide_with_any_number_of_samples(device):
    plain, drawn = (
        [
            render(TETRAHEDRON, size=SIZE, colour="flat", wireframe=edges, samples=n, device=device)
            for n in (1, 2, 4)
        ]
        for edges in (False, True)
    )
    light = [a.astype(float) ** 2 - b.astype(float) ** 2 for a, b in zip(plain, drawn, strict=True)]
    ink = [taken.sum() for taken in light]
    assert ink[0] > 0
    assert ink == pytest.approx([ink[0]] * 3, rel=0.15)


def test_render_smooths_outlines_by_samples(device):
    once = render(SPHERE, size=SIZE, samples=1, device=device)
    twice = render(SPHERE, size=SIZE, device=device)
    assert psnr(once, twice) > 25
    steps = [np.abs(np.diff(image.astype(int), axis=1)).max() for image in (once, twice)]
    assert steps[1] < steps[0]


def test_render_leaves_out_faces_that_turn_away(device):
    inside_out = TriangleMesh(TETRAHEDRON.positions, TETRAHEDRON.triangles[:, ::-1])
    whole = render(TETRAHEDRON, size=SIZE, colour="flat", device=device)
    culled = render(TETRAHEDRON, size=SIZE, colour="flat", cull=True, device=device)
    np.testing.assert_array_equal(culled, whole)
    hollow = render(inside_out, size=SIZE, colour="flat", cull=True, device=device)
    assert psnr(hollow, whole) < 30


@pytest.mark.parametrize(
    ("points", "faces"),
    [(np.zeros((0, 3)), np.zeros((0, 3), int)), ([[1, 2, 3]] * 3, [[0, 1, 2]])],
)
def test_render_of_nothing_is_background(device, points, faces):
    assert not covered(render(points, np.reshape(faces, (-1, 3)).astype(int), size=SIZE)).any()


def test_render_far_from_the_origin_is_the_same_picture(device):
    moved = TriangleMesh(TETRAHEDRON.positions + np.float32(1000), TETRAHEDRON.triangles)
    image = render(moved, size=SIZE, colour="flat", samples=1, device=device)
    expected = render(TETRAHEDRON, size=SIZE, colour="flat", samples=1, device=device)
    assert (image != expected).any(-1).mean() < 0.01


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"colour": "blue"}, "colour: expected one of smooth, flat, wireframe, triangle, vertex"),
        (
            {"colour": "vertex"},
            "colour: expected a mesh with vertex colours for 'vertex', got none",
        ),
        ({"colour": [1.0, 2.0]}, r"colour: expected \(4,\) values of points or \(4,\) of faces"),
        ({"colour": [1.0, np.nan, 0, 0]}, "colour: expected finite values"),
        ({"size": (0, 10)}, "size: expected 1 to 16384, got 0"),
        ({"samples": 0}, "samples: expected 1 to 136, got 0"),
        ({"samples": 137}, "samples: expected 1 to 136, got 137"),
        ({"up": "w"}, "up: expected one of x, y, z, got 'w'"),
        ({"camera": (np.nan, 0)}, "camera: expected a finite number, got nan"),
        ({"colour": [0.0] * 4, "colour_map": "none such"}, "colour_map: expected a matplotlib"),
    ],
)
def test_render_refuses_wrong_arguments_by_name(device, options, text):
    with pytest.raises(ValueError, match=text):
        render(TETRAHEDRON, device=device, **({"size": SIZE} | options))


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"size": (2.5, 3)}, "size: expected a whole number, got 2.5"),
        ({"size": 640}, "size: expected (a whole number, 1 to 16384, a whole number, 1 to 16384)"),
        ({"device": 3}, "device: expected text or None, got 3"),
        ({"samples": 1.5}, "samples: expected a whole number, got 1.5"),
        ({"camera": "front"}, "camera: expected (a number, a number), got 'front'"),
        ({"wireframe": "yes"}, "wireframe: expected True or False, got 'yes'"),
        ({"colour": [0.0] * 4, "colour_range": (0, "1")}, "colour_range: expected"),
    ],
)
def test_render_refuses_other_types_by_name(device, options, text):
    with pytest.raises(TypeError) as raised:
        render(TETRAHEDRON, **({"size": SIZE, "device": device} | options))
    assert str(raised.value).startswith(text)


def test_render_refuses_points_that_are_no_numbers(device):
    with pytest.raises(ValueError, match="points: expected finite"):
        render([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], device=device)


def test_colour_table_is_linear_and_interpolated():
    table = colour_table([(0, 0, 0), (1, 1, 1)])
    assert table.shape == (256, 3) and table.dtype == np.float32
    np.testing.assert_allclose(np.sqrt(table[:, 0]) * 255, np.arange(256), atol=1e-3)


def test_render_of_a_scan(device, data_folder):
    from lodbench.datasets_gen.read import read_mesh

    mesh = read_mesh(data_folder / "meshes" / "bunny_69k.ply")
    image = render(mesh, size=SIZE, device=device)
    assert 0.2 < covered(image).mean() < 0.8


def test_render_draws_what_a_system_makes_of_the_mesh_for_the_view(device):
    mesh = icosphere(0)
    refined = refine(mesh, method="pn_triangles", segments=16, weld=False, device=device)
    view = mesh_view(icosphere(2), size=SIZE)
    options = {"refine": "pn_triangles", "segments": 16, "device": device}
    image = render(mesh, camera=view, colour="flat", **options)
    assert np.array_equal(image, render(*refined, camera=view, colour="flat", device=device))
    far = render(mesh, None, (0, 0), SIZE, refine="adaptive_patterns", by="screen", device=device)
    assert covered(far).any()


@pytest.mark.parametrize(
    ("options", "error", "text"),
    [
        ({"segments": 4}, TypeError, "segments: expected with refine, the system whose option"),
        ({"refine": "pattern", "depth": 4}, TypeError, "option: expected one"),
        ({"refine": "quadric_clustering"}, ValueError, "method: expected one of"),
        ({"refine": "pattern", "colour": np.zeros(12)}, ValueError, "colour: expected no values"),
        ({"refine": "adaptive_patterns", "indices": False}, Unsupported, "needs a surface on"),
    ],
)
def test_render_refuses_what_it_cannot_refine(device, options, error, text):
    with pytest.raises(error, match=text):
        render(icosphere(0), size=SIZE, device=device, **options)
