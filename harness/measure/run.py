"""Groups of subjects measured into a run's folder: in turns, recorded as it happens, each at most once."""

from __future__ import annotations

import gc
import itertools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from lodbench.datasets_gen import catalogue
from lodbench.datasets_gen.finest import finest
from lodbench.datasets_gen.surfaces import BezierPatches, NurbsModel, TriangleMesh
from lodbench.harness.measure import exact
from lodbench.harness.measure.budget import Budget
from lodbench.harness.measure.forerun import Forerunner
from lodbench.harness.measure.identity import config_of
from lodbench.harness.measure.judge import Judge
from lodbench.harness.measure.moves import Moves
from lodbench.harness.measure.progress import Progress
from lodbench.harness.measure.timing import NARROW, OtherLoad, interleave, take
from lodbench.harness.measure.trial import Trial
from lodbench.harness.plan.group import Group, Subject
from lodbench.harness.record.record import Writer, attempts, config_hash, plain
from lodbench.kernels.opencl import Device
from lodbench.kernels.render import mesh_view
from lodbench.kernels.stages.paths import CameraPath
from lodbench.kernels.system import Frame, Remembering, View

OVERRUN = 1.2  # of the time left: a group that would take more is not begun
PATH_ROUNDS = 5  # times that a camera path is measured, after one to warm


class Session:
    """One run: a device, a folder, and the groups measured into it.

    Args:
        device: where device subjects run; host subjects may use as many threads as it has compute units.
        folder: the run's folder, with its `run.json` written.
        samples: counted samples per subject, or None for the protocol's own number.
        precision: without such a number, sampling goes on until ratios are known to this share: see `interleave`.
        time_budget_s: counted from here on. Sampling is cut to share what is left; no group is begun that would not
            fit, by what those before it took, and one for which it runs out is given up: on resume it is measured anew.
            A call that is under way is waited for.
        seed: of bootstrap and quality sampling.
    """

    def __init__(
        self,
        device: Device,
        folder: Path,
        *,
        samples: int | None = None,
        time_budget_s: float | None = None,
        seed: int = 0,
        precision: float = NARROW,
    ) -> None:
        self.device, self.folder, self.seed = device, folder, seed
        self._samples, self._precision = samples, precision
        self._budget = Budget(math.inf if time_budget_s is None else time_budget_s)
        self._devices: dict[tuple[str, bool], Device] = {}
        self._writer = Writer(folder)
        self._ended, self._begun = attempts(folder)
        self._last = ""
        self._judge = Judge()
        self._forerunner = Forerunner()

    @property
    def _sampling(self) -> dict[str, Any]:
        return {"samples": self._samples, "narrow": self._precision}

    def close(self) -> None:
        """Close the record."""
        self._forerunner.close()
        self._writer.close()

    def note(self, kind: str, **row: Any) -> None:
        """Append a row that belongs to no group."""
        self._writer.write(kind, **row)

    def measure(self, work: Sequence[tuple[str, Group]], quiet: bool = False) -> list[str]:
        """Measure every (table id, group) that the record does not hold whole.

        Returns:
            The names of those for which the time budget did not suffice.
        """
        for _, group in work:
            group.validate()
        left_out: list[str] = []
        pending = [(table, group, self._config(table, group)) for table, group in work]
        pending = [one for one in pending if config_hash(one[2]) not in self._ended]
        undone = sum(group.weight for _, group, _ in pending)
        spent = seconds = 0.0  # weights and seconds of the groups measured here
        with Progress(sum(group.weight for _, group in work), quiet) as progress:
            progress.advance(sum(group.weight for _, group in work) - undone, kept=True)
            for table, group, config in pending:
                name = f"{table}: {group.name}"
                left, expected = self._budget.left, group.weight * seconds / (spent or 1.0)
                if left > 0 and expected <= OVERRUN * left:
                    progress.task(name)
                    start = time.perf_counter()
                    budget = Budget(left * group.weight / undone)
                    if not self._group(table, group, config, budget, progress):
                        left_out.append(name)
                    seconds += time.perf_counter() - start
                    spent += group.weight
                else:
                    left_out.append(name)
                undone -= group.weight
                progress.advance(group.weight)
        return left_out

    def _config(self, table: str, group: Group) -> dict[str, Any]:
        return config_of(table, group, self.device.slug, self._samples, self._precision, self.seed)

    def _group(
        self,
        table: str,
        group: Group,
        config: Mapping[str, Any],
        budget: Budget,
        progress: Progress,
    ) -> bool:
        """Measure one group; False where time ran out: it took fewer samples than it should, or was given up."""
        key = config_hash(config)
        progress.step("load")
        dataset = group.found()
        surface = self._surface(dataset)
        earlier = self._begun.setdefault(key, [])
        for attempt in earlier:
            self._writer.write("superseded", group=key, attempt=attempt)
        attempt = max(earlier, default=-1) + 1
        earlier[:] = [attempt]
        record = partial(self._writer.write, group=key, attempt=attempt)
        facts = {**group.facts, "dataset": dataset.name, "standin": dataset.standin}
        if dataset.content:
            facts["content"] = dataset.content
        if isinstance(surface, TriangleMesh):
            facts["triangles_in"] = surface.triangle_count
            facts["vertices_in"] = surface.vertex_count
        if isinstance(surface, BezierPatches):
            facts["patches_in"] = len(surface.points)
        if isinstance(surface, NurbsModel):
            facts["surfaces_in"] = len(surface.surfaces)
        record(
            "begin", table=table, name=group.name, dataset=dataset.name, device=self.device.slug,
            facts=facts, config=config,
        )  # fmt: skip
        trials: dict[str, Trial] = {}
        try:
            done = self._turns(group, surface, trials, record, budget, progress)
        finally:
            trials.clear()
            gc.collect()  # device buffers go back to the pool before the next group asks for its own
        if done:
            self._ended.add(key)
        return done

    def _turns(
        self,
        group: Group,
        surface: Any,
        trials: dict[str, Trial],
        record: Callable[..., None],
        budget: Budget,
        progress: Progress,
    ) -> bool:
        """Prepare, sample and check the subjects of a group that has begun; was there time for all of it?"""
        start = time.perf_counter()
        for subject in group.subjects:
            if self._budget.stops():
                return False
            progress.step(f"prepare {subject.name}")
            trial = Trial(subject, view=Frame(_zoomed(surface, group.zoom)), once=group.once)
            device = partial(self._open, subject)
            trial.enter(surface, device, trials, record, group.judged, self._forerunner)
            trials[subject.name] = trial
        running = {name: e for name, e in trials.items() if e.prepared is not None}
        frames = {name: e.frame for name, e in running.items() if not group.once}
        firsts = {name: trial.first_s for name, trial in running.items()}
        if (
            frames
            and sum(firsts.values()) > self._budget.left + (OVERRUN - 1) * self._budget.seconds
        ):
            return False  # not even one turn would fit
        gc.collect()
        progress.step("sample")
        others = OtherLoad()
        sampling = {**self._sampling, "budget": budget, "warm": group.warm}
        for sample in interleave(frames, firsts, **sampling):
            record("sample", **plain(sample))
        self._whole_frames(group, surface, trials, record, progress, budget)
        share = others.share()
        seed = self.seed if group.seed is None else group.seed
        for name, trial in trials.items():
            if (trial.mesh is not None or group.exact) and self._budget.stops():
                return False
            progress.step(f"quality of {name}")
            exact.measure(group, surface, name, trials)
            if trial.mesh is not None:
                self._judge(group, finest(surface), name, trials, seed)
            record(
                "subject", subject=name, status=trial.status, reason=trial.reason,
                **trial.facts,
            )  # fmt: skip
        record("end", others=share, seconds=round(time.perf_counter() - start, 3), cut=budget.cut)
        return not budget.cut

    def _whole_frames(
        self,
        group: Group,
        surface: Any,
        trials: Mapping[str, Trial],
        record: Callable[..., None],
        progress: Progress,
        budget: Budget,
    ) -> None:
        """Turns of those subjects that are drawn apart from their samples, so that neither disturbs the other."""
        frames = {
            name: trial.whole_frame
            for name, trial in trials.items()
            if trial.prepared is not None and trial.raster is not None
            and trial.subject.draw is not None and trial.subject.draw.apart
        }  # fmt: skip
        if not frames:
            return
        progress.step("frame")
        if group.path is not None:
            self._along(
                group.path, surface, {name: trials[name] for name in frames}, record, budget
            )
            return
        firsts = {name: take(name, frame, 0, warmup=True) for name, frame in frames.items()}
        seconds = {name: first.wall_s for name, first in firsts.items() if first is not None}
        frames = {name: frames[name] for name in seconds}
        for sample in interleave(frames, seconds, **self._sampling, budget=budget):
            if not sample.warmup:
                record("frame", **plain(sample))

    def _along(
        self,
        path: CameraPath,
        surface: Any,
        trials: Mapping[str, Trial],
        record: Callable[..., None],
        budget: Budget,
    ) -> None:
        """The whole path several times, the first to warm and to see surfaces move; at each step all in turn."""
        moves = {name: Moves() for name in trials}
        views = {
            name: path.views(*finest(surface).box, size=trial.subject.draw.size)
            for name, trial in trials.items()
            if trial.subject.draw is not None
        }
        for round_, step in itertools.product(range(1 + PATH_ROUNDS), range(path.frames)):
            if round_ > 1 and budget.stops():
                return
            for name, trial in trials.items():
                if step == 0 and isinstance(trial.prepared, Remembering):
                    trial.prepared.reset()
                trial.seen = Frame(views[name][step])
                sample = take(name, trial.whole_frame, round_ * path.frames + step, not round_)
                if sample is None or trial.prepared is None:
                    continue
                if not round_:
                    moves[name].see(trial.prepared, finest(surface).diagonal)
                    continue
                triangles = trial.prepared.counters().get("triangles")
                moved = moves[name].to(step) if round_ == 1 else {}
                record("frame", **plain(sample), step=step, triangles=triangles, **moved)

    def _surface(self, dataset: catalogue.Dataset) -> Any:
        if self._last != dataset.name:
            self._last = dataset.name
            self._judge.forget()
        surface = dataset.surface
        # systems work on positions alone: a run is about the origin of its input
        return surface.with_origin(None) if isinstance(surface, TriangleMesh) else surface

    def _open(self, subject: Subject) -> Device:
        key = subject.device or self.device.facts.name, subject.one_core
        if not subject.device and not subject.one_core:
            return self.device
        if key not in self._devices:
            self._devices[key] = Device.open(key[0], one_core=subject.one_core)
        return self._devices[key]


def _zoomed(surface: Any, zoom: float | None) -> View | None:
    """The view of the whole, magnified; None where subjects choose their own."""
    if zoom is None:
        return None
    whole = mesh_view(finest(surface))
    return replace(whole, world_to_clip=np.diag([zoom, zoom, 1, 1]) @ whole.world_to_clip)
