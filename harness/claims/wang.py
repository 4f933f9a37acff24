"""Claims of Wang, Liu, Feng & Li (Hohai University): multiresolution rendering from geometry images on the GPU."""

from lodbench.harness.claims.model import Claim, Comparison, Pick, Rows

_PAPER = Pick("quadtree_lod", {"placement": "samples"})
_FULL = Pick("uniform_grid", {"target_count": None})
_SECTION3, _SECTION4 = (f"Wang et al., section {section}" for section in (3, 4))

W14 = (
    Claim(
        "w14_real_time",
        "a multiresolution model of the bunny is filtered, merged and drawn in real time",
        "Wang et al., section 4, table 1",
        (
            Rows(
                "w14_table1",
                "frame_s",
                {"system": "quadtree_lod"},
                "s for a frame",
                most=1 / 30,
            ),
        ),
        published="0.006 s for 69,444 triangles to 0.002 s for 17,240",
        note="real time is 30 frames per second; their picture's size is not known, here it is 1280 x 1024",
    ),
    Claim(
        "w14_predecessor",
        "it is 2.8 times faster than the CUDA predecessor with 69,444 triangles, and as fast with 17,240",
        "Wang et al., section 4, table 1",
        published="17 against 6 ms; 2 against 2 ms",
        not_on_cpu="the predecessor is a CUDA program that the paper does not describe",
    ),
    Claim(
        "w14_parallel",
        "choosing and merging by shaders takes less time than walking the tree",
        "Wang et al., abstract; section 3.2",
        (Comparison(_PAPER, Pick("serial_traversal"), least=1.0),),
        note="the walk is one work-item of the same device; theirs ran on a CPU beside a GPU",
    ),
    Claim(
        "w14_growth",
        "time grows more slowly than the number of triangles",
        "Wang et al., section 4, table 1",
        (
            Rows(
                "w14_scale",
                "slope",
                {"system": "quadtree_lod", "n": 8},
                "is the slope of log time over log triangles",
                most=1.0,
            ),
        ),
        published="0.8, from 6, 5, 3 and 2 ms",
    ),
    Claim(
        "w14_merge",
        "merging the triangles of nodes leaves fewer triangles than the image has, without cracks",
        _SECTION3,
        (
            Comparison(_PAPER, _FULL, "fewer triangles", least=1.0, table="w14_table1"),
            Rows("w14_table1", "open_edges", {"system": "quadtree_lod"}, "open edges", most=0),
        ),
        published="17,240 triangles of 69,444",
        note="how nodes of different depth meet is not said; here by fans along their borders",
    ),
    Claim(
        "w14_pays",
        "a model of fewer triangles is drawn faster than the whole one",
        _SECTION4,
        (Comparison(_PAPER, _FULL, "frames faster", least=1.0, table="w14_table1"),),
        published="6 ms down to 2 ms",
        note="the whole image of 131,072 triangles needs no choosing and no merging",
    ),
    Claim(
        "w14_quality",
        "fewer triangles further away make no visible difference",
        "Wang et al., section 4, figure 6",
        (
            Rows(
                "w14_table1",
                "rms_error",
                {"system": "quadtree_lod"},
                "diagonals off, RMS",
                most=1e-3,
            ),
        ),
        note="invisible is a pixel of a model 1,000 pixels across",
    ),
    Claim(
        "w14_rays",
        "rays from the centre, and the remaining vertices solved, map a model of genus 0 to the sphere",
        "Wang et al., section 2",
        (
            Rows(
                "w14_parameterisation",
                "rms_error",
                {"system": "ray"},
                "diagonals off, RMS, of the image",
                most=1e-3,
            ),
        ),
        note="a map is one that keeps the shape to 1e-3; models whose centre lies outside have none at all",
    ),
    Claim(
        "w14_clustering",
        "clustering on the GPU, DeCoro & Tatarchuk's, is not as precise",
        "Wang et al., section 1",
        (Comparison(_PAPER, Pick("quadric_clustering"), "closer", least=1.0),),
        note="as many triangles by either, whole models",
    ),
)
