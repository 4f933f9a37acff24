"""Where a frame's device time goes, stage by stage, and the least that each could take."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lodbench.harness.measure.limits import Limits
from lodbench.harness.record.record import SubjectRecord
from lodbench.harness.report.amounts import amount
from lodbench.harness.report.charts.bars import lines_of, subjects_of
from lodbench.harness.report.charts.chart_data import (
    INK,
    ON_COLOUR,
    PAGE,
    STAGES,
    Chart,
    ChartData,
    legend,
)
from lodbench.kernels.system import Traffic


def stages(chart_data: ChartData) -> Chart | None:
    """Where a frame's device time goes: the share of each stage, with the sum beside it."""
    cases = {
        name: several
        for name, part in subjects_of(chart_data).items()
        if (several := [subject for _, subject in part if len(subject.stages) > 1])
    }
    if not cases:
        return None
    lines = lines_of(cases)
    drawn: list[SubjectRecord] = lines.drawn
    canvas, axes = lines.axes([subject.label for subject in drawn])
    names = list(dict.fromkeys(stage for subject in drawn for stage in subject.stages))
    medians = np.array(
        [[np.median(s.stage_s(n)) if n in s.stages else 0.0 for n in names] for s in drawn]
    )
    sums = medians.sum(axis=1, keepdims=True)
    shares = 100 * np.divide(medians, sums, out=np.zeros_like(medians), where=sums > 0)
    ends = np.cumsum(shares, axis=1)
    for i, name in enumerate(names):
        some = shares[:, i] > 0
        axes.barh(
            np.array(lines.heights)[some], shares[some, i], left=(ends - shares)[some, i],
            height=0.72, label=name, lw=0.6, edgecolor=PAGE, color=STAGES[i % len(STAGES)],
            hatch=("", "//")[i // len(STAGES) % 2],
        )  # fmt: skip
        for at, end, share in zip(lines.heights, ends[:, i], shares[:, i], strict=True):
            if share > max(9, 1.5 * len(name)):
                axes.text(
                    end - share / 2, at, name, color=ON_COLOUR, ha="center", va="center_baseline",
                    size=7,
                )  # fmt: skip
    least = 100 * _least_shares(chart_data.limits, drawn, names, sums)
    starts = ends - shares
    at, stage = np.nonzero(least > 0)
    heights = np.array(lines.heights)[at] + 0.25
    left = starts[at, stage]
    axes.hlines(heights, left, np.minimum(left + least[at, stage], 101), color=INK, lw=1.6)
    for at, subject in zip(lines.heights, drawn, strict=True):
        total = amount(float(np.median(subject.stage_s())), "s")
        axes.annotate(total, (101, at), va="center", annotation_clip=False)
    axes.set_xlim(0, 100)
    lines.grid(axes)
    axes.set_xlabel("share of the frame's stage time, %")
    legend(canvas, [axes])
    caption = "Time by stage, medians; their sum stands to the right."
    if least.any():
        caption += (
            " The line in a stage is the least that the bytes it must move, or the operations it must do, take at "
            "the rates measured in the same run."
        )
    return Chart(canvas, caption + lines.more)


def _least_shares(
    limits: Limits | None, drawn: Sequence[SubjectRecord], names: Sequence[str], sums: Any
) -> Any:
    """Least time of each stage over the whole's, (subjects, stages); 0 where it is not known."""
    least = np.zeros((len(drawn), len(names)))
    for row, subject in enumerate(drawn):
        for stage, traffic in subject.traffic.items():
            if limits is not None and stage in subject.stages:
                least[row, names.index(stage)] = limits.least_s(Traffic(**traffic))
    return np.divide(least, sums, out=np.zeros_like(least), where=sums > 0)
