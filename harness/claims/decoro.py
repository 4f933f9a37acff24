"""Claims of DeCoro & Tatarchuk: Real-time Mesh Simplification Using the GPU, I3D 2007."""

from lodbench.harness.claims.model import Claim, Comparison, Pick, Rows, Share

_GRID = Pick("quadric_clustering")
_TREE = Pick("probabilistic_octree", {"storage": 0.08, "construction": "full"})

DT07 = (
    Claim(
        "dt07_speed",
        "clustering simplifies large models 20 times faster than simplification on a CPU",
        "DeCoro & Tatarchuk 2007, slides 2 and 19",
        (
            Rows(
                "dt07_timing",
                "ratio_to_fast_simplification",
                {"system": "quadric_clustering"},
                "times faster than fast-simplification",
                least=20.0,
            ),
        ),
        published="20 on average",
        note="both on the same CPU, against edge collapse; the paper's CPU program is not known",
    ),
    Claim(
        "dt07_speed_gpu",
        "clustering on the GPU is 20 times faster than the same on the CPU",
        "DeCoro & Tatarchuk 2007, slides 2, 4 and 19",
        (
            Rows(
                "dt07_timing",
                "ratio_to_numpy_quadric_clustering",
                {"system": "quadric_clustering"},
                "times faster than the same in NumPy",
                least=20.0,
            ),
        ),
        published="20 on average",
        not_on_cpu="it compares a GPU with a CPU",
    ),
    Claim(
        "dt07_real_time",
        "simplification is fast enough for real time",
        "DeCoro & Tatarchuk 2007, slides 2 to 4",
        (
            Rows(
                "dt07_timing",
                "wall_s",
                {"system": "quadric_clustering", "dataset": ("*k", "*k_sorted")},
                "s for 70 thousand to 1.3 million triangles",
                most=1 / 30,
            ),
        ),
        note="real time is a thirtieth of a second; the slides' models have 70 thousand to 1.1 million triangles",
    ),
    Claim(
        "dt07_linear",
        "time grows with the number of triangles, linearly",
        "DeCoro & Tatarchuk 2007, slide 19",
        (
            Rows(
                "dt07_timing",
                "slope",
                {"system": "quadric_clustering", "triangles_in": 1_310_720},
                "is the slope of log time over log triangles",
                least=0.8,
                most=1.2,
            ),
        ),
        published="1",
        note="linear is a slope of 0.8 to 1.2",
    ),
    Claim(
        "dt07_pass_1",
        "the first pass, which sums the quadrics, takes three quarters of the time",
        "DeCoro & Tatarchuk 2007, slide 18",
        (
            Share(
                Pick("quadric_clustering", {"strategy": "separate"}),
                ("pass_1",),
                "of the time",
                least=0.65,
                most=0.85,
            ),
        ),
        published="0.75",
        note="three quarters is 0.65 to 0.85; passes run apart, as published",
    ),
    Claim(
        "dt07_chain_free",
        "lower levels of detail are almost free once the first is there",
        "DeCoro & Tatarchuk 2007, slide 18",
        (
            Rows(
                "dt07_chain",
                "share",
                {"system": ("level_2", "level_3", "level_4")},
                "of the first level's time for all that follow",
                most=0.25,
            ),
        ),
        note="almost free is a quarter, what is left without the first pass",
    ),
    Claim(
        "dt07_chain",
        "a level from the sums of the level before avoids the first pass, 75 % of the work",
        "DeCoro & Tatarchuk 2007, slide 18",
        (
            Rows(
                "dt07_chain",
                "level_ratio",
                {"system": ("level_2", "level_3", "level_4")},
                "times faster than the level anew",
                least=4.0,
            ),
        ),
        published="4, by what pass 1 takes",
        note="levels here also read the triangles of the level before, as the slide says",
    ),
    Claim(
        "dt07_quadrics",
        "vertices placed by quadrics are nearer to the surface than averages of the cell's vertices",
        "DeCoro & Tatarchuk 2007, slide 14",
        tuple(
            Comparison(
                Pick("quadric_clustering", {"placement": placement}),
                Pick("vertex_average"),
                "closer",
                least=1.0,
                table="dt07_grids",
            )
            for placement in ("paper", "robust")
        ),
        note="the slide shows pictures; placed as published, then by a solver that never gives up",
    ),
    Claim(
        "dt07_region",
        "a grid warped by a Gaussian keeps the detail of a region",
        "DeCoro & Tatarchuk 2007, slides 25 to 27",
        (
            Rows(
                "dt07_warps",
                "closer",
                {"warp": "region", "system": "region_*"},
                "times closer there, with as many triangles",
                least=1.0,
            ),
        ),
    ),
    Claim(
        "dt07_view",
        "clustering after projection keeps more detail near the viewer",
        "DeCoro & Tatarchuk 2007, slide 24",
        (
            Rows(
                "dt07_warps",
                "closer",
                {"warp": "view", "system": "view_ndc"},
                "times closer in pixels, with as many triangles",
                least=1.0,
            ),
        ),
    ),
    Claim(
        "dt07_octree_collisions",
        "a table of 8 % of the octree's nodes loses fewer than 10 % of those in use",
        "DeCoro & Tatarchuk 2007, slide 33",
        (
            Rows(
                "dt07_octree",
                "collisions",
                {"system": "probabilistic_octree", "storage": 0.08},
                "of the nodes collide, with 5 to 8 levels",
                most=0.1,
            ),
        ),
        published="under 0.1",
        note="the slide does not say how many levels the tree has",
    ),
    Claim(
        "dt07_octree_speed",
        "adaptive simplification by the octree is 20 % slower than a grid",
        "DeCoro & Tatarchuk 2007, slide 33",
        (Comparison(_TREE, _GRID, least=1 / 1.2),),
        published="0.83",
        note="a graphics card adds to a hash table in its blending units",
    ),
    Claim(
        "dt07_octree_error",
        "an octree spends its triangles where there is detail: it is nearer to the surface than a grid of as many",
        "DeCoro & Tatarchuk 2007, slides 29 and 33",
        (Comparison(Pick("octree", {"shape": "cubes", "rule": None}), _GRID, "closer", least=1.0),),
        note="the slide shows a picture; an octree without losses, its cells cubes as in the paper",
    ),
)
