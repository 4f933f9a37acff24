import numpy as np
import pytest

from lodbench.kernels.stages.paths import FAR, CameraPath

LOW, HIGH = np.array([-1.0, -2.0, 0.5]), np.array([3.0, 0.0, 1.5])
CENTRE = (LOW + HIGH) / 2


def distances(kind, frames=24):
    views = CameraPath(kind, frames).views(LOW, HIGH, size=(70, 66))
    assert len(views) == frames
    return views, np.array([np.linalg.norm(view.eye - CENTRE) for view in views])


def in_image(view, point):
    x, y, _, w = view.world_to_clip @ np.append(point, 1.0)
    return w > 0 and abs(x) <= w and abs(y) <= w


def test_turntable_goes_once_around_at_one_distance():
    views, away = distances("turntable")
    assert np.ptp(away) < 1e-9 * away[0]
    around = np.unwrap([np.arctan2(*(view.eye - CENTRE)[[0, 2]]) for view in views])
    assert np.allclose(np.diff(around), 2 * np.pi / 24)
    assert all(in_image(view, CENTRE) for view in views)


def test_orbit_draws_back_and_returns():
    views, away = distances("orbit")
    assert away.argmax() == 12 and away.max() / away.min() == pytest.approx(FAR)
    assert (np.diff(away[:13]) > 0).all() and (np.diff(away[12:]) < 0).all()
    assert all(in_image(view, CENTRE) for view in views)


def test_fly_through_passes_the_middle_and_looks_ahead():
    views, away = distances("fly_through", 33)
    assert away.argmin() == 16 and away.min() < 1e-9
    assert away[0] == pytest.approx(away[-1])
    assert [in_image(view, CENTRE) for view in views] == [True] * 16 + [False] * 17
    assert all(np.isfinite(view.world_to_clip).all() for view in views)


def test_path_of_another_kind_or_length_is_refused():
    with pytest.raises(ValueError, match="kind: expected one of turntable, orbit, fly_through"):
        CameraPath("spiral")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="frames: expected 2 to 10000, got 1"):
        CameraPath("orbit", 1)
