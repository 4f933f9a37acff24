"""How good the results of a group are: against its input, and against the subject that it names as reference."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.measure import focused, nested, quality
from lodbench.harness.measure.trial import Trial
from lodbench.harness.plan.group import Group
from lodbench.kernels.opencl import Unsupported


class Judge:
    """Puts a result mesh's `quality` into its trial's facts; what was found of the same bytes is kept."""

    def __init__(self) -> None:
        self._found: dict[str, dict[str, Any]] = {}

    def forget(self) -> None:
        """Another input follows."""
        self._found.clear()

    def __call__(
        self, group: Group, surface: TriangleMesh, name: str, trials: Mapping[str, Trial], seed: int
    ) -> None:
        """Judge the result of `name`, as the group asks for; one that cannot be compared fails.

        Args:
            group: says against what.
            surface: the input as triangles.
            name: of a trial that kept its mesh.
            trials: the group's, by label.
            seed: of the samples of the distance to the input.
        """
        trial, facts = trials[name], {}
        assert trial.mesh is not None
        if group.quality:
            facts |= self._to_input(surface, trial.mesh, seed)
            if group.focus is not None and "rms_error" in facts:
                facts |= focused.measure(surface, trial.mesh, group.focus, seed)
        reference = trials[group.reference].mesh if group.reference else None
        if reference is not None and group.reference != name:
            try:
                facts |= (
                    quality.distance_from(reference, trial.mesh, surface.diagonal)
                    if group.nearest
                    else nested.difference(surface, trial.mesh, reference)
                )
            except (ValueError, Unsupported) as error:
                trial.fail(error)
        if group.same:
            facts["digest"] = _digest(trial.mesh.positions, trial.mesh.triangles)
            if trial.raster is not None:
                facts["picture"] = _digest(trial.raster.image())
        trial.facts["quality"] = facts or None

    def _to_input(self, surface: TriangleMesh, mesh: TriangleMesh, seed: int) -> dict[str, Any]:
        """Topology, and error against the input where libigl is installed; once per distinct mesh and seed."""
        bits = f"{_digest(mesh.positions, mesh.triangles)} {seed}"
        if bits not in self._found:
            try:
                found = quality.measure(surface, mesh, seed)
            except Unsupported:  # no libigl: the error columns stay empty
                found = quality.topology(mesh)
            self._found[bits] = dict(found)
        return self._found[bits]


def _digest(*arrays: NDArray[Any]) -> str:
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()
