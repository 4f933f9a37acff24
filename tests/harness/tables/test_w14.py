import pytest

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.read import read_mesh
from lodbench.harness.plan.table import table
from lodbench.harness.report.document import document
from lodbench.harness.tables import w14_parameterisation, w14_scale, w14_table1
from lodbench.kernels.geometry_image.parameterisation import topology
from tests.harness.records import group, run, subject


@pytest.mark.parametrize("name", ["w14_table1", "w14_scale", "w14_parameterisation"])
@pytest.mark.parametrize("quick", [True, False])
def test_groups_name_what_there_is(name, quick):
    found = table(name).groups(quick)
    assert found
    for one in found:
        one.validate()


def test_table1_shows_stages_published_times_and_the_error_beside_the_uniform_grid():
    stages = dict.fromkeys(w14_table1.STAGES, 0.001)
    ours = subject("quadtree_lod", [stages] * 10, quality={"rms_error": 2.0})
    found = group(
        ours,
        subject("serial_traversal", [0.012] * 10, quality={"rms_error": 2.0}),
        subject("uniform_grid", [0.001] * 10, quality={"rms_error": 3.0}),
        table="w14_table1", triangles_asked=34_627,
    )  # fmt: skip
    rows = {row["system"]: row for row in document(w14_table1.TABLE, run(found))["rows"]}
    row = rows["quadtree_lod"]
    assert row["filter_s"] == row["emit_s"] == 0.001
    assert row["ratio_to_serial_traversal"] == pytest.approx(2)
    assert row["error_of_uniform_grid"] == 1.5
    assert (row["published_wall_s"], rows["serial_traversal"]["published_wall_s"]) == (0.003, None)


def test_table1_gives_the_papers_predecessor_a_row_of_its_own_without_measurements():
    found = group(
        subject("quadtree_lod", [0.006] * 10), subject("numpy_quadtree_lod", [0.02] * 10),
        subject("uniform_grid", [0.001] * 10), table="w14_table1", triangles_asked=34_627,
    )  # fmt: skip
    rows = {row["system"]: row for row in document(w14_table1.TABLE, run(found))["rows"]}
    assert rows["numpy_quadtree_lod"]["published_wall_s"] is None
    predecessor = rows[w14_table1.PREDECESSOR]
    assert predecessor["status"] == "published"
    filled = {key for key, value in predecessor.items() if value is not None}
    assert filled == {"triangles_asked", "system", "status", "published_wall_s"} | (
        filled & {"dataset"}
    )
    assert predecessor["published_wall_s"] == 0.005


def test_published_times_are_the_papers():
    assert w14_table1.PUBLISHED_S[69_444] == (0.006, 0.017)
    assert [mine for mine, _ in w14_table1.PUBLISHED_S.values()] == [0.006, 0.005, 0.003, 0.002]
    assert [other for _, other in w14_table1.PUBLISHED_S.values()] == [0.017, 0.009, 0.005, 0.002]


def test_scale_fits_a_slope_per_subject_and_share():
    groups = []
    for n in (6, 7, 8):
        triangles = 2 * 4**n
        groups.append(
            group(
                subject("quadtree_lod", [1e-8 * triangles] * 10, counters={"triangles": triangles}),
                table="w14_scale", n=n, share="all",
            )
        )  # fmt: skip
    rows = document(w14_scale.TABLE, run(*groups))["rows"]
    assert [row["slope"] is None for row in rows] == [False] * 3
    assert rows[-1]["slope"] == pytest.approx(1)


def test_parameterisation_has_every_closed_scan_of_genus_0(data_folder):
    names = {group.dataset for group in w14_parameterisation.TABLE.groups(False)}
    closed = set()
    for path in (data_folder / "meshes").glob("*.ply"):
        mesh = read_mesh(path)
        if mesh.triangle_count <= 200_000 and not topology(mesh.triangles).faults:
            closed.add(path.stem)
    assert closed == names & {path.stem for path in (data_folder / "meshes").glob("*.ply")}
    assert closed <= set(catalogue.names())
