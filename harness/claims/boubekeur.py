"""Claims of Boubekeur & Schlick: Generic Mesh Refinement on GPU, 2005, and GPU Gems 3, chapter 5, 2007."""

from lodbench.harness.claims.model import Claim, Comparison, Pick, Rows, Share

_PATTERN, _STATIC = Pick("pattern"), Pick("static_vbo")
_FIGURE7 = "Boubekeur & Schlick 2005, section 5, figure 7"
_AMPLITUDE = 0.008  # of the sine of figure 4, in diagonals

GMR05 = (
    Claim(
        "gmr05_rate",
        "refinement patterns draw as fast as a static vertex buffer of the refined mesh",
        _FIGURE7,
        (Comparison(_PATTERN, _STATIC, "frames faster", least=0.9, table="gmr05_figure7"),),
        published="0.96 to 1.00 of the frame rate; 3.81 against 3.97 frames per second at most triangles",
        note="as fast is 0.9 of the rate; patterns are drawn in one launch, and in one for each triangle as published",
    ),
    Claim(
        "gmr05_memory",
        "patterns divide the memory of the refined mesh by about the number of coarse triangles",
        _FIGURE7,
        tuple(
            Comparison(
                _PATTERN,
                _STATIC,
                "fewer stored vertices",
                least=count,
                table="gmr05_figure7",
                facts={"coarse_triangles": count},
            )
            for count in (10, 100, 1000)
        ),
        published="4,225 vertices in place of 42,250, 422,500 and 4,225,000",
    ),
    Claim(
        "gmr05_st_rate",
        "with an expensive surface, an ST mesh, patterns and a static buffer have the same frame rate",
        "Boubekeur & Schlick 2005, section 5",
        (
            Rows(
                "gmr05_st_mesh",
                "frame_ratio_to_static_vbo",
                {"system": "st_triangles"},
                "times the static buffer's frame rate",
                least=0.9,
                most=1.1,
            ),
        ),
        published="61 frames per second both",
    ),
    Claim(
        "gmr05_st_triangles",
        "an ST mesh of 162 triangles has 331,938 with 64 segments",
        "Boubekeur & Schlick 2005, section 5",
        (
            Rows(
                "gmr05_st_mesh",
                "triangles_out",
                {"system": "st_triangles", "segments": 64},
                "triangles",
                least=331_938,
                most=331_938,
            ),
        ),
        published="331,938",
        note="162 triangles of 64 segments are 162 x 64 x 64; the published number is half of that and 162",
    ),
    Claim(
        "gmr05_fine",
        "a displacement of high frequency looks smooth at a very high rate of tessellation alone",
        "Boubekeur & Schlick 2005, section 4, figure 4",
        (
            Rows(
                "gmr05_figure4",
                "rms_difference",
                {"segments": 256},
                "diagonals off, RMS, with 256 segments",
                most=_AMPLITUDE / 100,
            ),
            Rows(
                "gmr05_figure4",
                "rms_difference",
                {"segments": 16},
                "with 16",
                least=_AMPLITUDE / 100,
            ),
        ),
        note="smooth is a hundredth of the amplitude; the paper shows pictures",
    ),
    Claim(
        "gmr05_pn",
        "patterns are an economic way to curved PN triangles: a frame costs little more than flat ones",
        "Boubekeur & Schlick 2005, sections 4 and 6",
        (
            Rows(
                "gmr05_pn",
                "ratio_to_pattern",
                {"system": "pn_triangles", "work": "refine and draw"},
                "times the frame rate of flat triangles",
                least=0.9,
            ),
        ),
        note="the paper gives no figure; little is a tenth",
    ),
    Claim(
        "gmr05_strips",
        "the topology of a static buffer adds half to its memory, as strips; that of patterns is negligible",
        "Boubekeur & Schlick 2005, section 5",
        published="about 50 % more",
        not_on_cpu="no system here draws strips: vertices of a static buffer are listed by index",
    ),
    Claim(
        "gmr05_bus",
        "what crosses the graphics bus does not grow with the refinement",
        "Boubekeur & Schlick 2005, sections 3.2 and 5",
        not_on_cpu="a CPU has no bus between host and device",
    ),
)

_SOURCE = "Boubekeur & Schlick 2007, GPU Gems 3, chapter 5"
_VIEWS = {"work": "path", "system": ("levels", "distance", "screen", "curvature", "mixed")}

GEMS3 = (
    Claim(
        "gems3_bottleneck",
        "the rate of vertices is the one bottleneck: choosing a pattern for each triangle costs next to nothing",
        _SOURCE,
        (
            Share(
                Pick("adaptive_patterns"),
                ("tags", "selection"),
                "of the refinement's device time",
                most=0.1,
            ),
        ),
        note="tags are computed by the device here, by the host there; next to nothing is a tenth",
    ),
    Claim(
        "gems3_pool",
        "all patterns are made once and fit the GPU's memory: their pool is small beside what it refines",
        _SOURCE,
        tuple(
            Rows(
                "gems3_pool",
                "pool_bytes",
                {"segments": n},
                f"bytes with {n} segments",
                most=1000 * 24 * (n + 1) * (n + 2) // 2,  # points and normals, float32
            )
            for n in (16, 32, 64, 128)
        ),
        note="small is less than 1,000 triangles take with as many segments; the chapter's figures were not at hand",
    ),
    Claim(
        "gems3_vertices",
        "a pattern of the pool refines at the rate of one for all: only the index buffer that is bound differs",
        _SOURCE,
        (
            Rows(
                "gems3_adaptive",
                "ratio_to_uniform",
                {"work": "vertices", "system": "all_finest"},
                "times the rate of one pattern for all",
                least=0.9,
            ),
        ),
        note="at the rate is 0.9 of it",
    ),
    Claim(
        "gems3_view",
        "refining by the view draws faster than the same refinement everywhere",
        _SOURCE,
        (
            Rows(
                "gems3_adaptive",
                "frame_ratio_to_uniform",
                _VIEWS,
                "times the frame rate of one pattern for all",
                least=1.0,
            ),
        ),
        note="along a camera's path; the chapter's frame rates were not at hand",
    ),
    Claim(
        "gems3_curvature",
        "refining by curvature takes fewer triangles than the same refinement everywhere, as near to the surface",
        _SOURCE,
        (
            Rows(
                "gems3_adaptive",
                "share_at_error",
                {"work": "error", "system": "curvature_*"},
                "times the triangles at equal largest error",
                most=1.0,
            ),
        ),
        note="the chapter shows a picture; coarse meshes here are scans that were simplified",
    ),
    Claim(
        "gems3_rate",
        "meshes are refined anew for each frame in real time",
        _SOURCE,
        (Rows("gems3_adaptive", "frame_s", _VIEWS, "s for a frame", most=1 / 30),),
        note="real time is 30 frames per second; 1,000 triangles with up to 32 segments",
    ),
)
