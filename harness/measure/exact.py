"""How far results are from exact values, each figure beside its limit: what `Group.exact` asks for, by name.

A limit is what every subject has to keep: one that does not fails. A figure without a limit is only told.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from lodbench.harness.measure import exact_bezier, exact_nurbs, exact_views
from lodbench.harness.measure.figure import Figure, Seen
from lodbench.harness.measure.trial import Trial
from lodbench.harness.plan.group import Group


@dataclass(frozen=True)
class Quantity:
    """What is measured, for people, and how: (what there is to see) -> the figure."""

    text: str
    measure: Callable[[Seen], Figure]


QUANTITIES: Mapping[str, Quantity] = {
    "points": Quantity("points, share of the box's diagonal", exact_bezier.points),
    "normals": Quantity("normals, degrees", exact_bezier.normals),
    "cracks": Quantity("open edges at shared borders", exact_bezier.cracks),
    "open": Quantity("open edges at shared borders", exact_bezier.open_inside),
    "vertices": Quantity("vertices not within 1e-6 of the first's", exact_bezier.unlike_vertices),
    "bytes": Quantity("bytes unlike the first's", exact_bezier.unlike_bytes),
    "surface": Quantity(
        "points against SciPy's, share of the box's diagonal", exact_nurbs.off_scipy
    ),
    "stair": Quantity("stair against Cox-de Boor, float64", exact_nurbs.stair),
    "basis": Quantity("basis functions against Cox-de Boor, float32", exact_nurbs.basis),
    "unity": Quantity("sum of basis functions, off 1", exact_nurbs.unity),
    "end": Quantity("basis functions at the end parameter, off 0 and 1", exact_nurbs.end),
    **{
        name: Quantity(f"points off the {name}, share of its radius", exact_nurbs.off_conic(name))
        for name in exact_nurbs.CONICS
    },
    "tolerance": Quantity(
        "largest distance to the surface, share of the box's diagonal", exact_nurbs.distance
    ),
    "lost": Quantity("visible samples lost by culling, share", exact_views.lost),
    "seams": Quantity("open edges at shared borders", exact_views.seams),
    "holes": Quantity("pixels of background at shared borders", exact_views.holes),
}


def measure(group: Group, surface: Any, name: str, trials: Mapping[str, Trial]) -> None:
    """Put the figures of a subject that ran into its facts; it fails by the first that is over its limit.

    Args:
        group: says which.
        surface: the input.
        name: of the trial.
        trials: the group's, by label; some figures are against the first.
    """
    trial, first = trials[name], next(iter(trials.values()))
    if not group.exact or trial.prepared is None:
        return
    assert trial.device is not None
    seen = Seen(
        trial.device, trial.prepared, surface, trial.facts["params"], trial.facts["check"],
        first.prepared,
    )  # fmt: skip
    found: dict[str, Figure] = {}
    for quantity in group.exact:
        try:
            found[quantity] = QUANTITIES[quantity].measure(seen)
        except Exception as error:
            if not trial.fail(error):
                raise
            return
    trial.facts["exact"] = found
    for quantity, figure in found.items():
        if not figure.kept and trial.status == "ok":
            trial.status = "failed"
            trial.reason = f"{QUANTITIES[quantity].text}: expected at most {figure.limit:g}, got {figure.value:g}"
