"""What can be drawn of a table and its samples: each chart takes the rows it needs, or is left out."""

from __future__ import annotations

from collections.abc import Callable

from lodbench.harness.report.charts import bars, curves, front, scales, stages
from lodbench.harness.report.charts.chart_data import Chart, ChartData, Style, styles

__all__ = ["CHARTS", "Chart", "ChartData", "Style", "styles"]

CHARTS: dict[str, tuple[str, Callable[[ChartData], Chart | None]]] = {
    "front": ("Who is faster, who is nearer", front.pareto_front),
    "time": ("Time against size", curves.time_against_triangles),
    "error": ("Error against triangles", curves.error_against_triangles),
    "difference": ("Difference against segments", curves.difference_against_segments),
    "error-time": ("Error against time", curves.error_against_time),
    "fps": ("Frames per second", bars.frames_per_second),
    "stage-fps": ("Frames per second without drawing", bars.stages_per_second),
    "footprint": ("Footprint", bars.footprint),
    "stages": ("Stages", stages.stages),
    "cores": ("Time against cores", scales.over_cores),
    "memory": ("Memory and rate against size", scales.memory_and_rate),
    "path": ("Along the camera path", curves.along_path),
    "samples": ("Samples", bars.samples),
}
