import numpy as np

from lodbench.datasets_gen import patches
from lodbench.kernels import tessellate
from lodbench.kernels.bezier.candidates import INSIDE, LEVEL, NODES, SECTOR, nodes_of
from lodbench.kernels.bezier.dabt import Dabt, Params
from lodbench.kernels.bezier.dabt.reference import candidates, inserted
from lodbench.kernels.system import run
from tests.kernels.bezier.patches import bicubic

NONE = np.zeros(7, bool)
ALL = np.ones(7, bool)


def test_dabt_sector_has_the_level_of_its_edge():
    on = np.stack([ALL, NONE, NONE])
    flags = inserted(on, np.zeros(NODES, bool), 3)
    tested = candidates(flags, 3)
    assert (tested[INSIDE] == (SECTOR == 0)[INSIDE]).all()  # rows have a base of level 0
    flags = inserted(
        np.stack([NONE, NONE, on[0] & (np.arange(7) % 2 == 1)]), np.ones(NODES, bool), 3
    )
    assert (flags[INSIDE] == ((SECTOR == 2) & (LEVEL <= 2))[INSIDE]).all()


def test_dabt_inserts_what_lies_between_inserted_vertices():
    on = np.stack([NONE, NONE, NONE])
    on[0, 0] = True  # the first of seven, on the left: with it the second and the fourth
    flags = inserted(on, np.zeros(NODES, bool), 3)
    assert flags.sum() == 3 + 3
    assert inserted(on, np.zeros(NODES, bool), 2).sum() == 3


def test_dabt_follows_a_ridge(device):
    # curved along u alone: rows run along v, and nothing is inserted between their ends
    surface = bicubic(np.array([0, 1, 1, 0.0])[:, None] * np.ones(4))
    prepared = Dabt(device, surface, Params(3, threshold=1e-3))
    run(device, prepared)
    flags = nodes_of(prepared.masks())
    assert not flags[..., INSIDE].any()
    assert prepared.live()[1] == 2 * (2 * 8 - 1)  # a fourth of what vst makes


def test_dabt_from_python():
    points, faces = tessellate(patches.cup(), method="dabt", test="flat", quality="medium")
    assert points.dtype == np.float32 and faces.dtype == np.uint32
    finer = tessellate(patches.cup(), method="dabt", test="flat", quality="high")
    assert len(faces) < len(finer[1])
