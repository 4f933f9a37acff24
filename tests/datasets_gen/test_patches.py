import numpy as np
import pytest

from lodbench.datasets_gen import patches
from lodbench.datasets_gen.patches import read_patches
from lodbench.datasets_gen.read import FileError


def bernstein(t):
    s = 1 - t
    return np.stack([s**3, 3 * s * s * t, 3 * s * t * t, t**3], axis=-1)


def shared_edges(points):
    """How many patch edges have the control points of 1, 2 ... other edges; and of collapsed ones."""
    counts, collapsed = {}, 0
    for p in points:
        for edge in (p[0], p[3], p[:, 0], p[:, 3]):
            if (edge == edge[0]).all():
                collapsed += 1
                continue
            key = min(edge.tobytes(), edge[::-1].copy().tobytes())
            counts[key] = counts.get(key, 0) + 1
    return np.bincount(list(counts.values())).tolist(), collapsed


@pytest.mark.parametrize("segments", [4, 8, 32])
def test_pot_is_closed_but_for_its_poles(segments):
    pot = patches.pot(segments).points
    assert len(pot) == 4 * segments
    # 4 * segments vertical edges and 4 * (segments - 1) rings between; 4 collapsed at each pole
    assert shared_edges(pot) == ([0, 0, 8 * segments - 4], 8)


def test_cup_has_26_patches_a_rim_and_a_loose_handle():
    cup = patches.cup().points
    assert len(cup) == 26
    counts, collapsed = shared_edges(cup)
    assert collapsed == 4
    assert max(len(counts) - 1, 0) == 2  # no edge with three patches
    assert counts[1] == 4 + 4  # the rim; two ends of each half of the handle


def test_revolution_is_round_and_faces_outwards():
    profile = np.array([[(2.0, 0.0), (2.0, 1.0), (2.0, 2.0), (2.0, 3.0)]])
    points = patches.revolution(profile).points.astype(np.float64)
    weights = bernstein(np.linspace(0, 1, 33))
    surface = np.einsum("ai,bj,pijk->pabk", weights, weights, points)
    radius = np.linalg.norm(surface[..., :2], axis=-1)
    # a cubic quarter circle is at most 0.0273 % too far out
    assert radius.min() > 2 - 1e-6 and radius.max() < 2 * 1.000273
    step_u = surface[:, 1:, :-1] - surface[:, :-1, :-1]
    step_v = surface[:, :-1, 1:] - surface[:, :-1, :-1]
    assert ((np.cross(step_u, step_v) * surface[:, :-1, :-1]).sum(-1) > 0).all()


def test_copies_do_not_touch():
    one = patches.pot(4).points
    many = patches.copies(patches.pot(4), 5).points.reshape(5, *one.shape)
    assert np.array_equal(many[0], one)
    boxes = [(m.min((0, 1, 2)), m.max((0, 1, 2))) for m in many]
    for i in range(5):
        for j in range(i):
            assert (boxes[i][0][:2] > boxes[j][1][:2]).any() or (
                boxes[i][1][:2] < boxes[j][0][:2]
            ).any()


def test_read_patches_of_both_formats(tmp_path):
    points = patches.pot(4).points
    np.savez(tmp_path / "pot.npz", patches=points.astype(np.float64))
    rows = "".join(
        "3 3\n" + "".join(f"{p[0]!r} {p[1]!r} {p[2]!r}\n" for p in s.reshape(16, 3).tolist())
        for s in points
    )
    (tmp_path / "pot.bpt").write_text(f"16\n{rows}")
    for name in ("pot.npz", "pot.bpt"):
        assert np.array_equal(read_patches(tmp_path / name).points, points)


def test_read_patches_names_what_is_wrong(tmp_path):
    with pytest.raises(FileError, match="no such file"):
        read_patches(tmp_path / "none.npz")
    with pytest.raises(FileError, match="expected a suffix"):
        read_patches(tmp_path / "none.xyz")
    contents = {
        "a.bpt": b"2\n3 3\n0 0 0\n",
        "b.bpt": b"words",
        "c.npz": b"PK\x03\x04broken",
        "d.bpt": b"",
    }
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
        if name == "d.bpt":
            continue
        with pytest.raises(FileError) as caught:
            read_patches(tmp_path / name)
        assert "\n" not in str(caught.value)
    np.savez(tmp_path / "e.npz", points=np.zeros((1, 4, 4, 3)))
    np.savez(tmp_path / "f.npz", patches=np.full((1, 4, 4, 3), np.nan))
    np.savez(tmp_path / "g.npz", patches=np.array([object()]))
    for name in ("e.npz", "f.npz", "g.npz"):
        with pytest.raises(FileError):
            read_patches(tmp_path / name)


def test_real_patches_are_read(data_folder):
    for name, count in {"teapot": 32, "teacup": 26, "teaspoon": 16, "elephant_gumbo": 128}.items():
        archive, text = (read_patches(data_folder / f"bezier/{name}.{s}") for s in ("npz", "bpt"))
        assert len(archive.points) == count
        assert np.allclose(archive.points, text.points, atol=1e-4)
