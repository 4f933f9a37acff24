import pytest

from lodbench.harness.plan.table import table
from tests.harness.records import group, rows_of, subject


def test_gmr05_rows_have_both_counts_and_published_values():
    counters = {"vertices": 10 * 2145}
    static = {"stored_vertices": 21_450, "static_vertices": 21_450, "batches": 1}
    small = {"stored_vertices": 2145, "static_vertices": 21_450, "batches": 1}
    rows, made = rows_of(
        "gmr05_figure7",
        group(
            subject("static_vbo", [0.002] * 10, counters=counters, footprint=static),
            subject("pattern_per_triangle", [0.004] * 10, counters=counters, footprint=small),
            subject("device_fill", [0.001] * 10),
            table="gmr05_figure7", segments=64, coarse_triangles=10, dataset="sphere_10",
        ),
    )  # fmt: skip
    assert rows["static_vbo"]["published_frame_fps"] == 973.10
    assert rows["static_vbo"]["stored_vertices_square"] == 42_250
    assert rows["static_vbo"]["published_vertices"] == 42_250
    ours = rows["pattern_per_triangle"]
    assert ours["stored_vertices"] == 2145
    assert ours["stored_vertices_square"] == ours["published_vertices"] == 4225
    assert ours["stored_share"] == 0.1  # one pattern for ten coarse triangles
    assert ours["stage_fps"] == pytest.approx(250)
    assert ours["frame_fps"] is None
    assert ours["fill_share"] == pytest.approx(0.25)
    assert ours["ratio_to_static_vbo"] == pytest.approx(0.5)
    assert ours["published_ratio_to_static_vbo"] == pytest.approx(965.12 / 973.10)
    assert ours["vertices_per_s"] == pytest.approx(10 * 2145 / 0.004)
    assert any("331,938" in note for note in made["notes"])


def test_gmr05_frames_stand_apart_from_samples_and_beside_the_published_ones():
    static, ours = subject("static_vbo", [0.001] * 4), subject("pattern_per_triangle", [0.002] * 4)
    for found, seconds in ((static, 0.02), (ours, 0.01)):
        found.frames = [{"turn": turn, "wall_s": seconds} for turn in range(3, 7)]
    rows, _ = rows_of(
        "gmr05_figure7",
        group(static, ours, table="gmr05_figure7", segments=64, coarse_triangles=10),
    )
    row = rows["pattern_per_triangle"]
    assert row["stage_fps"] == pytest.approx(500)
    assert (row["frame_fps"], row["frames"]) == (pytest.approx(100), 4)
    assert row["frame_ratio_to_static_vbo"] == pytest.approx(2)
    assert row["ratio_to_static_vbo"] == pytest.approx(0.5)
    assert row["published_frame_fps"] == 965.12
    assert rows["static_vbo"]["frame_ratio_to_static_vbo"] is None


def test_figure4_says_how_densely_a_wave_is_sampled_and_what_that_leaves_out():
    quality = {"rms_difference": 0.5, "max_difference": 0.75, "compared_points": 9}
    _, made = rows_of(
        "gmr05_figure4",
        group(
            subject("pattern_16", [0.002] * 10, params={"segments": 16}, quality=quality),
            subject("pattern_512", [0.004] * 10, params={"segments": 512}),
            table="gmr05_figure4", waves=64.0, longest_edge=0.25,
        ),
    )  # fmt: skip
    coarse, reference = made["rows"]
    assert coarse["least_segments"] == 32, "2 pi 64 / pi times a quarter"
    assert coarse["samples_per_wave"] == 1 and reference["samples_per_wave"] == 32
    assert (coarse["rms_difference"], coarse["max_difference"]) == (0.5, 0.75)
    assert reference["rms_difference"] is None


@pytest.mark.parametrize("quick", [True, False])
def test_figure4_patterns_are_nested_in_their_reference_on_either_side_of_the_limit(quick):
    groups = table("gmr05_figure4").groups(quick)
    for found in groups:
        found.validate()
        segments = {s.name: s.params["segments"] for s in found.subjects}
        assert all(segments[found.reference] % each == 0 for each in segments.values())
        assert {1, 16, 256} <= set(segments.values()), "those that the paper shows"
    limit = 2 * groups[-1].facts["waves"] * groups[-1].facts["longest_edge"]
    assert 16 < limit < 256


def test_st_mesh_has_the_papers_count_beside_ours_and_its_rate_both_ways():
    counters = {"triangles": 663_552, "vertices": 162 * 2145}
    _, made = rows_of(
        "gmr05_st_mesh",
        *(
            group(
                subject("static_vbo", [0.002] * 10, counters=counters),
                subject(system, [0.001] * 10, counters=counters),
                table="gmr05_st_mesh", surface=surface, segments=64, triangles_in=162,
            )
            for surface, system in (("flat", "pattern"), ("st_triangles", "st_triangles"))
        ),
    )  # fmt: skip
    *flat, static, tagged = made["rows"]
    assert [row["published_frame_fps"] for row in (*flat, static, tagged)] == [None, None, 61, 61]
    assert tagged["published_triangles"] == 331_938 == 162 * 2049
    assert (tagged["triangles_out"], tagged["vertices_welded"]) == (663_552, 331_778)
    assert tagged["ratio_to_static_vbo"] == pytest.approx(2)
    assert tagged["triangles_per_s"] == pytest.approx(663_552 / 0.001)


def test_st_mesh_is_the_closed_one_of_as_many_triangles_as_the_papers():
    for found in table("gmr05_st_mesh").groups(True):
        found.validate()
        mesh = found.found().surface
        assert (mesh.triangle_count, mesh.vertex_count) == (162, 83)
        assert mesh.tags is not None


def test_pn_rows_tell_vertices_from_frames_and_instances_from_welded():
    counters = {"vertices": 1000, "triangles": 2000}
    made = [
        subject("pn_triangles", [0.001] * 10, counters=counters),
        subject("numpy_pn_triangles", [0.004] * 10, counters=counters),
        subject("igl_loop", [0.1] * 10, counters={"vertices": 500, "triangles": 2000}),
    ]
    rows, _ = rows_of("gmr05_pn", group(*made, table="gmr05_pn", work="refine", segments=16))
    ours, loop = rows["pn_triangles"], rows["igl_loop"]
    assert ours["vertices_per_s"] == pytest.approx(1e6)
    assert ours["ratio_to_numpy_pn_triangles"] == pytest.approx(4)
    assert ours["ratio_to_igl_loop"] == pytest.approx(100)
    assert ours["frame_fps"] is None
    assert (ours["welded"], loop["welded"]) == ("no", "yes")


def test_pn_frames_are_compared_with_a_tessellator_of_more_triangles():
    shader = subject(
        "gl_pn_tessellation", [2.0] * 3, counters={"triangles": 3000}, driver="a driver"
    )
    ours = subject("pn_triangles", [0.01] * 10, counters={"vertices": 1000, "triangles": 2000})
    rows, _ = rows_of(
        "gmr05_pn", group(ours, shader, table="gmr05_pn", work="refine and draw", segments=16)
    )
    assert rows["gl_pn_tessellation"]["driver"] == "a driver"
    assert rows["pn_triangles"]["frame_fps"] == pytest.approx(100)
    assert rows["pn_triangles"]["vertices_per_s"] is None
    assert rows["pn_triangles"]["ratio_to_gl_pn_tessellation"] == pytest.approx(200)


def test_pn_groups_keep_packages_to_few_segments():
    made = table("gmr05_pn")
    for quick in (True, False):
        groups = made.groups(quick)
        named = {
            found.facts["segments"]: {
                one.system
                for other in groups
                if other.facts["segments"] == found.facts["segments"]
                for one in other.subjects
            }
            for found in groups
        }
        assert {"gl_pn_tessellation", "igl_loop", "trimesh_subdivide"} <= named[16]
        assert ("vtk_loop_subdivision" in named[16]) != quick
        assert quick == (64 not in named)
        if not quick:
            assert "gl_pn_pattern" in named[64]
            assert not {"igl_loop", "vtk_loop_subdivision"} & named[64]


def test_pn_groups_leave_out_a_scan_that_is_not_there(monkeypatch, tmp_path):
    monkeypatch.setenv("LODBENCH_DATA", str(tmp_path))
    made = table("gmr05_pn").groups(False)
    assert {found.dataset for found in made} == {"sphere_1000"}
    for found in made:
        found.validate()
