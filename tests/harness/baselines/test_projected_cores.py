import numpy as np
import pytest

from lodbench.harness.baselines.projected_cores import Params, longest_chain, prepare
from lodbench.kernels.cluster.quadric_clustering import host
from lodbench.kernels.cluster.quadric_clustering.params import Params as Clustering
from lodbench.kernels.system import run
from tests.kernels.cluster.meshes import sphere


@pytest.mark.parametrize(
    ("seconds", "cores", "expected"),
    [([], 4, 0), ([3], 4, 3), ([1, 1, 1, 1], 2, 2), ([1, 1, 4], 2, 5), ([4, 1, 1, 1], 2, 4),
     ([2, 3], 1, 5)],
)  # fmt: skip
def test_longest_chain_is_that_of_cores_that_take_the_next_as_they_come_free(
    seconds, cores, expected
):
    assert longest_chain(seconds, cores) == expected


@pytest.mark.parametrize("way", ["private", "slabs"])
@pytest.mark.parametrize("cores", [1, 7])
def test_projection_gives_the_systems_mesh_and_a_chain_between_a_share_and_all_of_the_work(
    device, way, cores
):
    mesh = sphere(90, 180)
    projected = prepare(device, mesh, Params(20, accumulate=way, cores=cores))
    for _ in range(2):
        run(device, projected)
    subject = host.prepare(device, mesh, Clustering(20, accumulate=way))
    run(device, subject)
    (got,), (expected,) = projected.result(), subject.result()
    assert got.positions.tobytes() == expected.positions.tobytes()
    assert np.array_equal(got.triangles, expected.triangles)
    assert projected.check().passed
    counters = projected.counters()
    work, chain = counters["work_s"], counters["chain_s"]
    assert 0 < work / cores <= chain * (1 + 1e-9) and chain <= work * (1 + 1e-9)
    assert counters["chain_share"] == pytest.approx(chain / work)
    assert counters["launches"] == (8 if way == "private" else 10)
    assert 0 < counters["serial_s"] <= work
    stages = counters["chain_pass_1_and_3_s"] + counters["chain_pass_2_s"]
    assert stages == pytest.approx(chain)


def test_projection_refuses_no_cores():
    with pytest.raises(ValueError, match="cores: expected"):
        Params(cores=0)
