"""What the papers claim, as data: what is compared, and how it must come out. `report/claims.py` has the verdicts.

A claim is a sentence of a paper in our words and one or more comparisons, all of which must hold. A comparison takes
every group of a run in which both of its subjects took turns, with the same values of all other parameters that both
have, whatever table it belongs to: a new paper is new entries of `CLAIMS`, and needs no code.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal


@dataclass(frozen=True)
class Pick:
    """The subjects that a claim speaks of: a system, with these parameters whatever the others are, but not with those.

    Attributes:
        system: its name.
        params: that it has.
        without: that it does not have, such as what is ours and not the paper's.
    """

    system: str
    params: Mapping[str, Any] = field(default_factory=dict)
    without: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        words = [self.system, *(f"{key}={value}" for key, value in self.params.items())]
        return " ".join(words)


@dataclass(frozen=True)
class Comparison:
    """How many times `subject` is ahead of `other`, in every group that has both.

    Attributes:
        what: "faster", samples; "frames faster", whole frames that were drawn; "fewer triangles".
        least, most: the ratio that the claim allows; one of them.
        stage: of this stage's seconds in place of a sample's, where "faster".
    """

    subject: Pick
    other: Pick
    what: Literal["faster", "frames faster", "fewer triangles"] = "faster"
    least: float | None = None
    most: float | None = None
    stage: str = ""


@dataclass(frozen=True)
class Claim:
    """One claim.

    Attributes:
        name: short, unique.
        text: what is claimed.
        source: paper, section.
        comparisons: all must hold.
        published: the value that the source gives; None where it gives none or it was not at hand.
        note: in what the measurement here differs from the paper's.
    """

    name: str
    text: str
    source: str
    comparisons: tuple[Comparison, ...]
    published: str | None = None
    note: str = ""


OURS = {"test": "mean"}  # of adaptive tessellation

CLAIMS = (
    Claim(
        "rc13_reuse",
        "a geometry shader that evaluates a surface once and reuses it for its samples is faster than without",
        "Concheiro 2013, chapter 2 (GST)",
        (Comparison(Pick("gst", {"reuse": "row"}), Pick("gst", {"reuse": "none"}), least=1.0),),
    ),
    Claim(
        "rc13_divergence",
        "adaptive tessellation makes fewer triangles and is yet slower than non-adaptive, since its threads diverge",
        "Concheiro 2013, chapter 3 (DABT)",
        (
            Comparison(Pick("dabt", without=OURS), Pick("vst"), "fewer triangles", least=1.0),
            Comparison(Pick("dabt", without=OURS), Pick("vst"), most=1.0),
        ),
        note="a CPU's lanes stand for a GPU's threads: that it is slower is measured, that divergence is why is not",
    ),
    Claim(
        "rc13_semi_adaptive",
        "semi-adaptive tessellation wins back the speed that adaptive tessellation loses",
        "Concheiro 2013, chapter 4",
        (Comparison(Pick("semi_adaptive", without=OURS), Pick("dabt", without=OURS), least=1.0),),
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
    Claim(
        "gmr05_rate",
        "refinement patterns draw as fast as a static vertex buffer of the refined mesh",
        "Boubekeur & Schlick 2005, section 5, figure 7",
        (Comparison(Pick("pattern"), Pick("static_vbo"), "frames faster", least=0.9),),
        published="3.81 against 3.97 frames per second with 128 segments",
    ),
    Claim(
        "rc13_stair",
        "basis functions by the stair strategy, sums of products, are evaluated faster than by the recursion",
        "Concheiro 2013, section 6.5",
        (
            Comparison(
                Pick("uniform_nurbs", {"basis": "stair"}),
                Pick("uniform_nurbs", {"basis": "cox_de_boor"}),
                least=1.0,
                stage="basis",
            ),
        ),
        note="of the stage that evaluates them; the recursion is its cells in loops, each function by itself, since "
        "OpenCL has no recursion",
    ),
)
