"""Claims of Concheiro: Real Time Rendering of Parametric Surfaces on the GPU, PhD thesis, A Coruña 2013."""

from lodbench.harness.claims.model import Claim, Comparison, Pick, Rows

_TESTS, _OURS = ("distance", "flat", "length"), {"test": "mean"}  # of adaptive tessellation
_VST, _DABT, _SEMI = Pick("vst"), Pick("dabt", without=_OURS), Pick("semi_adaptive", without=_OURS)
_WHOLE, _STRONG, _LIGHT = (
    Pick("rpns", {"culling": culling}) for culling in ("none", "strong", "light")
)
_DICES, _NO_DICES = (
    Pick("rpns", {"culling": "none", "dice_culling": dices}) for dices in (True, False)
)
_2016 = "Concheiro 2013, section 6.4; GRAPP 2016, of deformable models"
_PSNR = "rc13_6_7_to_6_10"

_BEZIER = (
    Claim(
        "rc13_reuse",
        "a geometry shader that evaluates a surface once and reuses it for its samples is faster than without",
        "Concheiro 2013, chapter 2 (GST)",
        (Comparison(Pick("gst", {"reuse": "row"}), Pick("gst", {"reuse": "none"}), least=1.0),),
    ),
    Claim(
        "rc13_zones",
        "zones lift the limit of 1,024 numbers that a geometry shader may put out, at any resolution",
        "Concheiro 2013, section 2.3",
        (
            Rows(
                "rc13_figures_2_10_to_2_13",
                "zone_values",
                {"system": "gst", "level": (4, 5, 6, 7)},
                "numbers of a zone, levels 4 to 7",
                most=1024,
            ),
        ),
    ),
    Claim(
        "rc13_draws",
        "many surfaces to a draw are faster than a draw for each, which waits for the host",
        "Concheiro 2013, sections 2.2 and 5.2",
        (
            Rows(
                "rc13_5_13_to_5_18",
                "ratio_to_vst",
                {"surfaces_per_draw": 1},
                "times the speed of one draw for all",
                most=0.5,
            ),
        ),
        note="the rule, half the speed, is ours; a launch stands for a draw",
    ),
    Claim(
        "rc13_real_time",
        "models of Bezier surfaces are tessellated anew and drawn in real time",
        "Concheiro 2013, section 2.4",
        (
            Rows(
                "rc13_figures_2_10_to_2_13",
                "frame_s",
                {"system": "vst", "level": 6},
                "s for a frame of 1.1 to 5.2 million triangles",
                most=1 / 30,
            ),
        ),
        note="real time is 30 frames per second; the thesis' figures were not at hand",
    ),
    Claim(
        "rc13_hardware",
        "tessellation in software is in some cases faster than what hardware offers",
        "Concheiro 2013, summary",
        (Comparison(_VST, Pick("dx11"), "frames faster", least=1.0, reach="one"),),
        note="a CPU has no tessellator: its rules, each vertex evaluated by itself, run as kernels",
    ),
    Claim(
        "rc13_esc",
        "adapting on edges is up to 2.05 and 2.25 times faster than tessellation hardware",
        "Concheiro et al., GRAPP 2014, after chapter 4",
        (Comparison(_SEMI, Pick("dx11"), "frames faster", least=2.05, reach="one"),),
        published="2.25 and 2.05, ATI Radeon 5870 and 6970",
        note="a CPU has no tessellator: its rules run as kernels",
    ),
    Claim(
        "rc13_divergence",
        "adaptive tessellation makes fewer triangles and yet takes longer than non-adaptive, since its threads diverge",
        "Concheiro 2013, chapter 3 (DABT)",
        (
            Comparison(_DABT, _VST, "fewer triangles", least=1.0),
            Comparison(_DABT, _VST, most=1.0),
        ),
        note="tessellation alone; that it is slower is measured, that divergence is why is not",
    ),
    Claim(
        "rc13_divergence_frames",
        "frames with adaptive tessellation are slower than with non-adaptive, for all its fewer triangles",
        "Concheiro 2013, chapter 3 (DABT)",
        (Comparison(_DABT, _VST, "frames faster", most=1.0),),
        note="a CPU draws triangles more slowly than it makes them, and gains by fewer",
    ),
    Claim(
        "rc13_fewer",
        "adaptive tessellation takes considerably fewer triangles with no loss of quality",
        "Concheiro 2013, chapter 3 (DABT)",
        (
            Rows(
                "rc13_4_6_to_4_8",
                "share_at_error",
                {"work": "error", "system": "dabt_*", "test": _TESTS},
                "times the uniform grid's triangles at equal mean error",
                most=0.9,
            ),
        ),
        note="considerably is a tenth; the grid may have any number of segments",
    ),
    Claim(
        "rc13_fewer_by_mean",
        "adaptive tessellation takes half the triangles or fewer with no more of a mean error",
        "ours, after Concheiro 2013, chapters 3 and 4",
        tuple(
            Rows(
                "rc13_4_6_to_4_8",
                "share_at_error",
                {
                    "work": "error",
                    "system": f"{system}_mean_*",
                    **_OURS,
                    "fitted": True,
                    "dataset": "elephant_gumbo",
                },
                f"times the uniform grid's triangles on an elephant, by {system}",
                most=0.5,
            )
            for system in ("dabt", "semi_adaptive")
        ),
        note="by the test mean, whose vertices rise over the surface; the grid's lie on it",
    ),
    Claim(
        "rc13_length",
        "with the test of length 284.94 thousand triangles are drawn 148.97 times per second",
        "Concheiro et al., GRAPP 2011, after chapter 3",
        published="148.97 frames per second, GeForce 295 GTX",
        not_on_cpu="it is a frame rate of one graphics card, of a walk through a scene that was not published",
    ),
    Claim(
        "rc13_tests",
        "the test of distance costs about as much as that of length, though it computes more",
        "Concheiro et al., GRAPP 2011, after chapter 3",
        (
            Comparison(
                Pick("dabt", {"test": "distance"}),
                Pick("dabt", {"test": "length"}),
                "frames faster",
                least=0.8,
                table="rc13_3_18_3_19",
            ),
        ),
        note="about as much is 0.8 of the frame rate; published of a card that issues several operations at once",
    ),
    Claim(
        "rc13_semi_adaptive",
        "semi-adaptive tessellation wins back the speed that adaptive tessellation loses",
        "Concheiro 2013, chapter 4",
        (Comparison(_SEMI, _DABT, least=1.0),),
    ),
    Claim(
        "rc13_semi_fewer",
        "semi-adaptive tessellation makes many fewer triangles than non-adaptive",
        "Concheiro 2013, chapter 4",
        (Comparison(_SEMI, _VST, "fewer triangles", least=2.0),),
        note="many fewer is half",
    ),
    Claim(
        "rc13_semi_frames",
        "semi-adaptive tessellation draws faster than non-adaptive",
        "Concheiro 2013, chapter 4",
        (Comparison(_SEMI, _VST, "frames faster", least=1.0),),
    ),
    Claim(
        "rc13_constant_memory",
        "on handheld devices control points in constant memory are faster than in a texture",
        "Concheiro 2013, chapter 5; WSCG 2013",
        (
            Comparison(
                Pick("vsthd", {"memory": "uniform"}),
                Pick("vsthd", {"memory": "texture"}),
                least=1.0,
            ),
        ),
        note="a CPU has one memory for both: what is measured is the call of a sampler for each control point",
    ),
)

_NURBS = (
    Claim(
        "rc13_stair",
        "basis functions as sums of products, the stair strategy, are faster than by recursion",
        "Concheiro 2013, section 6.5",
        (
            Comparison(
                Pick("uniform_nurbs", {"basis": "stair"}),
                Pick("uniform_nurbs", {"basis": "cox_de_boor"}),
                least=1.0,
                stage="basis",
            ),
        ),
        note="of the stage that evaluates them; the recursion is its cells in loops, each function by itself",
    ),
    Claim(
        "rc13_light_culls",
        "light quad culling removes more KSQuads than strong quad culling",
        "Concheiro 2013, section 6.4, tables 6.3 to 6.6",
        (Comparison(_LIGHT, _STRONG, "fewer KSQuads", least=1.0),),
    ),
    Claim(
        "rc13_culling",
        "culling KSQuads that face away makes frames faster",
        "Concheiro 2013, section 6.4, tables 6.11 to 6.14",
        (
            Comparison(_STRONG, _WHOLE, "frames faster", least=1.0),
            Comparison(_LIGHT, _WHOLE, "frames faster", least=1.0),
        ),
    ),
    Claim(
        "rc13_strong",
        "strong quad culling makes frames up to 2.37 times faster",
        _2016,
        (Comparison(_STRONG, _WHOLE, "frames faster", least=2.37, reach="one"),),
        published="2.37",
    ),
    Claim(
        "rc13_light",
        "light quad culling makes frames up to 2.86 times faster",
        _2016,
        (Comparison(_LIGHT, _WHOLE, "frames faster", least=2.86, reach="one"),),
        published="2.86",
    ),
    Claim(
        "rc13_dice",
        "dice culling at the end of the sampler makes frames faster",
        "Concheiro 2013, section 6.4, tables 6.11 to 6.15",
        (Comparison(_DICES, _NO_DICES, "frames faster", least=1.0),),
    ),
    Claim(
        "rc13_culling_loses",
        "light quad culling also removes what is seen, strong quad culling does not",
        "Concheiro 2013, tables 6.3 to 6.10",
        (
            Rows(
                "rc13_6_3_to_6_6",
                "quads_lost",
                {"system": "light"},
                "KSQuads lost by light",
                least=1,
                reach="one",
            ),
            Rows(
                "rc13_6_3_to_6_6", "quads_lost", {"system": "strong"}, "by strong culling", most=0
            ),
        ),
        note="the thesis has PSNR of both; the rule is ours",
    ),
    Claim(
        "rc13_psnr",
        "pictures with strong and light quad culling are hardly different from those without",
        "Concheiro 2013, tables 6.7 to 6.10",
        (
            Rows(_PSNR, "psnr", {"system": "strong"}, "dB with strong quad culling", least=30.0),
            Rows(_PSNR, "psnr", {"system": "light"}, "dB with light quad culling", least=30.0),
        ),
        note="hardly different is 30 dB; the thesis' values were not at hand",
    ),
)

RC13 = (*_BEZIER, *_NURBS)
