import numpy as np
import pytest

from lodbench.kernels.stages.raster import EMPTY_ID
from tests.kernels.common.calling import Caller


@pytest.fixture(scope="module")
def call(device, tmp_path_factory):
    return Caller(
        device, tmp_path_factory.mktemp("kernels"), "common/runs.cl",
        INSTANCED=1, SEVERAL=0, SMOOTH=0, STREAMING=0,
    )  # fmt: skip


def rows(seed):
    """Rows of 64 pixels: long runs, short ones, some without a hit."""
    rng = np.random.default_rng(seed)
    lengths = rng.integers(1, (2, 5, 30)[seed % 3], 64)
    ids = np.repeat(rng.integers(0, 9, 64), lengths)[:64].astype(np.uint32)
    ids[np.repeat(rng.random(64) < (0, 0.3, 0.9)[seed % 3], lengths)[:64]] = EMPTY_ID
    return ids


@pytest.mark.parametrize("seed", range(12))
def test_every_pixel_finds_the_triangle_that_it_sees_in_its_run(call, seed):
    ids = rows(seed)
    hit = (ids.reshape(8, 8) != EMPTY_ID).any(axis=1)
    found = call(
        """Row row;
    for (int k = 0; k < 64; ++k) row.ids[k] = ids[k];
    row.hits = hits[0];
    row_runs(&row, ids);
    runs[0] = row.count;
    for (int k = 0; k < 64; ++k)
        seen[k] = row.hits >> k / 8 & 1 ? row.shown[row.bases[k / 8] + row.places[k]] : 0xffffffffu;""",
        1,
        {"seen": (64, np.uint32), "runs": (1, np.uint32)},
        ids=ids,
        hits=np.packbits(hit, bitorder="little").astype(np.uint32),
    )
    assert (found["seen"] == ids)[ids != EMPTY_ID].all()
    others = found["seen"].reshape(8, 8)
    expected = np.where(ids == EMPTY_ID, ids.reshape(8, 8).min(axis=1).repeat(8), ids)
    np.testing.assert_array_equal(others.ravel(), expected)
    seen = expected.reshape(8, 8)[hit].ravel()
    starts = seen[1:] != seen[:-1]
    gaps = np.zeros(64, bool)
    gaps[8 * np.flatnonzero(hit)] = ~np.r_[False, hit[:-1]][hit]
    changes = np.r_[True, starts] | gaps.reshape(8, 8)[hit].ravel() if len(seen) else np.zeros(0)
    assert found["runs"][0] == changes.sum()


def test_values_of_runs_are_looked_up_for_eight_pixels(call):
    values = np.random.default_rng(0).normal(size=16).astype(np.float32)
    places = np.array([0, 0, 1, 1, 2, 5, 7, 7], np.int32)
    found = call(
        """float own[16];
    for (int k = 0; k < 16; ++k) own[k] = values[k];
    vstore8(runs_at(own + 3, vload8(0, places)), 0, out);""",
        1,
        {"out": (8, np.float32)},
        values=values,
        places=places,
    )
    np.testing.assert_array_equal(found["out"], values[3 + places])
