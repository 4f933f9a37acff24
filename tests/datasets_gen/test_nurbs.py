import json

import numpy as np
import pytest
from scipy.interpolate import BSpline

from lodbench.datasets_gen import nurbs
from lodbench.datasets_gen.nurbs import read_nurbs
from lodbench.datasets_gen.read import FileError


def sample(surface, count=17):
    """Points (count, count, 3) on a grid of the whole domain."""

    def basis(knots, degree, size):
        places = np.linspace(knots[degree], knots[-degree - 1], count)
        return BSpline(knots, np.eye(size), degree)(places)

    u = basis(surface.knots_u, surface.degree_u, surface.points.shape[0])
    v = basis(surface.knots_v, surface.degree_v, surface.points.shape[1])
    weighted = np.concatenate(
        [surface.points * surface.weights[..., None], surface.weights[..., None]], axis=2
    )
    homogeneous = np.einsum("ai,bj,ijk->abk", u, v, weighted)
    return homogeneous[..., :3] / homogeneous[..., 3:]


def test_cylinder_is_exact():
    points = sample(nurbs.cylinder(radius=2.0).surfaces[0])
    assert np.linalg.norm(points[..., :2], axis=-1) == pytest.approx(2.0, abs=1e-12)


def test_ball_is_exact():
    assert np.linalg.norm(sample(nurbs.ball().surfaces[0]), axis=-1) == pytest.approx(
        1.0, abs=1e-12
    )


def test_quilt_neighbours_share_their_edge_to_the_bit():
    model = nurbs.quilt(2, 3, 4)
    assert len(model.surfaces) == 6
    grid = [[model.surfaces[row * 3 + column].points for column in range(3)] for row in range(2)]
    for row in range(2):
        for column in range(2):
            assert np.array_equal(grid[row][column][-1], grid[row][column + 1][0])
    for column in range(3):
        assert np.array_equal(grid[0][column][:, -1], grid[1][column][:, 0])
    assert len(np.unique(model.surfaces[0].knots_u)) - 1 == 4


def test_read_nurbs_round_trip_and_faults(tmp_path):
    surface = nurbs.ball().surfaces[0]
    entry = {
        "degree_u": 2,
        "degree_v": 2,
        "knots_u": surface.knots_u.tolist(),
        "knots_v": surface.knots_v.tolist(),
        "control_points": surface.points.tolist(),
        "weights": surface.weights.tolist(),
    }
    path = tmp_path / "model.json"
    path.write_text(json.dumps({"surfaces": [entry, entry]}))
    model = read_nurbs(path)
    assert len(model.surfaces) == 2
    assert np.array_equal(model.surfaces[1].points, surface.points)
    faults = [
        "{",
        "[]",
        '{"surfaces": 3}',
        '{"surfaces": [{}]}',
        json.dumps({"surfaces": [entry | {"weights": [[1.0]]}]}),
        json.dumps({"surfaces": [entry | {"knots_u": [0, 1]}]}),
        json.dumps({"surfaces": [entry | {"control_points": [[["x"]]]}]}),
    ]
    for text in faults:
        path.write_text(text)
        with pytest.raises(FileError, match=r"model\.json: .+") as caught:
            read_nurbs(path)
        assert "\n" not in str(caught.value)
    with pytest.raises(FileError, match="no such file"):
        read_nurbs(tmp_path / "none.json")
    with pytest.raises(FileError, match="expected a suffix"):
        read_nurbs(tmp_path / "none.iges")


def test_real_models_are_read(data_folder):
    counts = {"killeroo": 89, "ducky": 3, "hammer_nd": 34, "cylinder_rational": 1}
    for name, count in counts.items():
        assert len(read_nurbs(data_folder / f"nurbs/{name}.json").surfaces) == count
