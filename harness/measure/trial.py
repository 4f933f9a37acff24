"""One subject on its way through its group: prepared, run once, checked; what goes wrong is its status."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any
from weakref import WeakKeyDictionary

import psutil

from lodbench.datasets_gen.finest import finest
from lodbench.datasets_gen.surfaces import TriangleMesh
from lodbench.harness.measure.forerun import Forerunner
from lodbench.harness.measure.timing import VERY_SLOW_S, PeakMemory, take
from lodbench.harness.plan import registry
from lodbench.harness.plan.group import Context, Subject
from lodbench.kernels.opencl import Device, DeviceError, Unsupported
from lodbench.kernels.render import mesh_view
from lodbench.kernels.stages.raster import Raster
from lodbench.kernels.system import NOTHING_TO_DRAW, Frame, Prepared, System, Timeline, View, run

Record = Callable[..., None]  # (kind, **row): appends a row about this subject


@dataclass
class Trial:
    """A subject and what became of it: `facts` go into its row, `mesh` is kept where its quality is asked for.

    `view` is what a frame without drawing gets, `seen` what one with drawing gets; `once` as in `Group`.
    """

    subject: Subject
    status: str = "ok"
    reason: str = ""
    device: Device | None = None
    prepared: Prepared | None = None
    raster: Raster | None = None
    view: Frame = field(default_factory=Frame)
    seen: Frame = field(default_factory=Frame)
    once: bool = False
    first_s: float = 0.0
    facts: dict[str, Any] = field(default_factory=dict)
    mesh: TriangleMesh | None = None

    def enter(
        self,
        surface: Any,
        device: Callable[[], Device],
        before: Mapping[str, Trial],
        record: Record,
        keep_mesh: bool,
        forerunner: Forerunner | None = None,
    ) -> None:
        """Prepare, run the first frame and check it.

        Args:
            surface: the group's input.
            device: opens, or has opened, the device that the subject runs on.
            before: the group's subjects so far, which the params may depend on.
            record: takes the setup and the first sample.
            keep_mesh: keep the result for its quality.
            forerunner: where a peer is tried first.
        """
        try:
            self._prepare(surface, device, before, record, forerunner)
            memory = PeakMemory()
            first = take(self.subject.name, self.frame, 0, warmup=True)
            self.facts["peak_growth_bytes"] = memory.growth_bytes()
            if first is None:
                return
            self.first_s = first.wall_s
            warmup = not self.once and first.wall_s <= VERY_SLOW_S
            record("sample", **vars(replace(first, warmup=warmup)))
            self._check(keep_mesh)
            if self.subject.draw and self.subject.draw.apart and self.status == "ok":
                self._draw_apart(surface)
        except Exception as error:
            if not self.fail(error):
                raise

    def fail(self, error: Exception) -> bool:
        """Take note of an error that ends this subject and no other; False for one that is a fault of ours."""
        if isinstance(error, Unsupported | ImportError):
            self.status, self.reason = "skipped", str(error)
        elif isinstance(error, MemoryError):
            self.status, self.reason = "skipped", f"needs more memory than the host has: {error}"
        elif isinstance(error, DeviceError | ValueError | TypeError) or type(
            error
        ).__module__.startswith("pyopencl"):
            self.status, self.reason = "failed", f"{type(error).__name__}: {error}"
        else:
            return False
        self.prepared = None
        return True

    def frame(self) -> Timeline | None:
        """Run one frame and wait; None when that failed, and the subject is out."""
        if self.subject.draw is None or self.subject.draw.apart:
            return self._run(self.view, None)
        return self._run(self.seen, self.raster)

    def whole_frame(self) -> Timeline | None:
        """Run one frame with raster and shading where samples are taken without; None when that failed.

        A frame that leaves nothing to draw has no time, and the subject's samples stand.
        """
        return self._run(self.seen, self.raster)

    def _run(self, frame: Frame, raster: Raster | None) -> Timeline | None:
        assert self.device is not None and self.prepared is not None
        try:
            return run(self.device, self.prepared, frame, raster)
        except Exception as error:
            apart = self.subject.draw is not None and self.subject.draw.apart
            if raster is not None and apart and isinstance(error, Unsupported):
                self.facts["frame_reason"] = str(error)
                return None
            if not self.fail(error):
                raise
            return None

    def _open_raster(self, surface: Any) -> None:
        """The raster of what `prepared` leaves, and the view.

        Raises:
            Unsupported: it leaves no surface on the device, or the device has no room for the raster.
        """
        draw, prepared = self.subject.draw, self.prepared
        assert draw is not None and prepared is not None and self.device is not None
        if not prepared.output:
            raise Unsupported(NOTHING_TO_DRAW)
        self.raster = Raster(self.device, prepared.output, *draw.size)
        self.seen = self.view if self.view.view else Frame(_whole(surface, draw.size))

    def _draw_apart(self, surface: Any) -> None:
        """Make ready for whole frames; without one its time stays unknown, and the subject goes on."""
        try:
            self._open_raster(surface)
        except Unsupported as error:
            self.facts["frame_reason"] = str(error)

    def _prepare(
        self,
        surface: Any,
        device: Callable[[], Device],
        before: Mapping[str, Trial],
        record: Record,
        forerunner: Forerunner | None,
    ) -> None:
        subject = self.subject
        missing = registry.registry().missing.get(subject.system)
        if missing is not None:
            raise Unsupported(missing)
        owner: System[Any] = registry.system(subject.system)
        if not isinstance(surface, owner.takes):
            kinds = " or ".join(kind.__name__ for kind in owner.takes)
            raise Unsupported(f"needs {kinds}, dataset is {type(surface).__name__}")
        if owner.runs_on == "gl":
            from lodbench.harness.baselines.gl.driver import driver_name

            self.facts["driver"] = driver_name()
        self.device = device()
        if subject.device:
            self.facts["driver"] = self.device.facts.driver
        overrides = subject.params
        if callable(overrides):
            counters = {name: trial.facts.get("counters", {}) for name, trial in before.items()}
            params = {name: trial.facts.get("params") for name, trial in before.items()}
            overrides = overrides(Context(self.device, surface, counters, params))
        params = registry.parameters(owner, subject.case, overrides)
        self.facts["params"] = params
        if forerunner is not None:
            forerunner.try_out(owner, self.device, surface, params)
        process = psutil.Process()
        memory, start = process.memory_info().rss, time.perf_counter()
        self.prepared = owner.prepare(self.device, surface, params)
        seconds = time.perf_counter() - start
        if subject.draw and not subject.draw.apart:
            self._open_raster(surface)
        setup = self.prepared.setup
        record(
            "setup", subject=subject.name, system=owner.name, params=params,
            phases={**setup.stage_s, "prepare": seconds}, from_cache=setup.from_cache,
            memory_growth_bytes=process.memory_info().rss - memory,
        )  # fmt: skip

    def _check(self, keep_mesh: bool) -> None:
        prepared, facts = self.prepared, self.facts
        assert prepared is not None
        check = prepared.check()
        facts["check"] = check
        if not check.passed:
            self.status = "failed"
            self.reason = (
                f"check: {check.what} is {check.value:.4g}, tolerance {check.tolerance:.4g}"
            )
        facts["counters"] = dict(prepared.counters())
        facts["footprint"] = prepared.footprint()
        facts["traffic"] = dict(prepared.traffic())
        if keep_mesh:
            start = time.perf_counter()
            meshes = prepared.result()
            facts["read_back_s"] = time.perf_counter() - start
            self.mesh = meshes[0] if meshes else None


_views: WeakKeyDictionary[Any, dict[tuple[int, int], View]] = WeakKeyDictionary()


def _whole(surface: Any, size: tuple[int, int]) -> View:
    """The view of all of a surface, which every subject of a group is drawn from; kept no longer than the surface."""
    known = _views.setdefault(surface, {})
    if size not in known:
        known[size] = mesh_view(finest(surface), size=size)
    return known[size]
