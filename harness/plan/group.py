"""What is measured together: subjects that take turns on one dataset, named and checked before anything runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from lodbench.datasets_gen import catalogue
from lodbench.harness.plan import registry
from lodbench.harness.plan.focus import Focus
from lodbench.harness.record.record import plain
from lodbench.kernels.opencl import Device, Unsupported
from lodbench.kernels.stages.camera import TABLE_SIZE
from lodbench.kernels.stages.paths import CameraPath


@dataclass(frozen=True)
class Context:
    """What a subject's params may depend on: the input, and the subjects prepared before it in its group."""

    device: Device
    surface: Any
    counters: Mapping[str, Mapping[str, int | float]]  # by label
    params: Mapping[str, Any]  # by label

    def counter(self, label: str, name: str) -> Any:
        """A counter of a subject prepared before.

        Raises:
            Unsupported: that subject has none, because it failed or found nothing.
        """
        if name not in self.counters.get(label, {}):
            raise Unsupported(f"needs {name} of {label}, which has none")
        return self.counters[label][name]


Overrides = Mapping[str, Any] | Callable[[Context], Mapping[str, Any]]


@dataclass(frozen=True)
class Draw:
    """Raster and shading of the surface that a subject leaves on the device, seen whole by the default camera.

    `size` is in pixels. With `apart` the samples are taken without drawing, as if it were not asked for, and whole
    frames after all of them, in turns of their own; else a sample is a whole frame.
    """

    size: tuple[int, int] = TABLE_SIZE
    apart: bool = False


@dataclass(frozen=True)
class Subject:
    """A system with parameters: a case's name (None: the first) and the fields to replace in it.

    `device`: words of the name of the one that it runs on; "": the run's.
    """

    system: str
    params: Overrides = field(default_factory=dict)
    label: str = ""
    case: str | None = None
    one_core: bool = False
    draw: Draw | None = None
    device: str = ""

    @property
    def name(self) -> str:
        """The label, or the system's name: unique within a group."""
        return self.label or self.system


@dataclass(frozen=True)
class Group:
    """Subjects that are compared: they take turns on one dataset.

    `facts` are the row's own words for it (segments, cells ...); `quality` measures each result mesh against the
    input; `weight` is its share of the whole run's time, for the time left; `standin_ok`: where a scan is not in the
    data folder, its generated stand-in takes its place, under its own name; `zoom`: every frame of every subject is
    seen this much larger than the view that shows the whole; `once`: each subject's first frame is its one sample,
    for set-up that takes seconds on the host and has nothing to warm; `seed`: of the samples that errors are taken
    from, where it is not the run's; `path`: what is drawn apart is seen from along it, every frame recorded;
    `reference`: label of a refinement against which the others are compared, at the same parameters of the same
    pattern, or, with `nearest`, by how far its vertices are from them; `focus`: where `quality` is measured once more,
    apart from the rest; `same`: digests of the bytes of results and pictures are kept, to be compared; `warm`: each
    sample follows at once on frames of the same subject that are not timed, two milliseconds of them and one at least,
    once no thread of others computes: the caches hold what it left there and its cores are awake, as in a loop;
    `exact`: what is measured of each subject against exact values, by the names of `harness.measure.exact`, which may
    run frames of its own at the end.
    """

    dataset: str
    subjects: tuple[Subject, ...]
    facts: Mapping[str, Any] = field(default_factory=dict)
    quality: bool = False
    weight: float = 1.0
    standin_ok: bool = False
    zoom: float | None = None
    once: bool = False
    seed: int | None = None
    path: CameraPath | None = None
    reference: str | None = None
    nearest: bool = False
    focus: Focus | None = None
    same: bool = False
    warm: bool = False
    exact: tuple[str, ...] = ()

    @property
    def judged(self) -> bool:
        """Is the result mesh of each subject compared with something?"""
        return self.quality or self.same or self.reference is not None

    @property
    def name(self) -> str:
        """The dataset and the facts in one line."""
        return " ".join([self.dataset, *(f"{key}={value}" for key, value in self.facts.items())])

    def config(self) -> dict[str, Any]:
        """All that decides what is measured, for the hash."""
        dataset = self.found()
        return {
            "dataset": dataset.name,
            **({"content": dataset.content} if dataset.content else {}),
            "facts": plain(self.facts),
            "quality": self.quality,
            **({"zoom": self.zoom} if self.zoom else {}),
            **({"once": True} if self.once else {}),
            **({} if self.seed is None else {"seed": self.seed}),
            **({} if self.path is None else {"path": plain(self.path)}),
            **({} if self.reference is None else {"reference": self.reference}),
            **({"nearest": True} if self.nearest else {}),
            **({} if self.focus is None else {"focus": plain(self.focus)}),
            **({"same": True} if self.same else {}),
            **({"warm": True} if self.warm else {}),
            **({"exact": list(self.exact)} if self.exact else {}),
            "subjects": [
                {
                    "label": subject.name,
                    "system": subject.system,
                    "case": subject.case,
                    "one_core": subject.one_core,
                    "params": subject.params.__qualname__  # type: ignore[union-attr]
                    if callable(subject.params)
                    else plain(subject.params),
                    **({"draw": plain(subject.draw)} if subject.draw else {}),
                    **({"device": subject.device} if subject.device else {}),
                }
                for subject in self.subjects
            ],
        }

    def found(self) -> catalogue.Dataset:
        """The catalogue's entry, without making its surface.

        Raises:
            ValueError: an unknown name, or a scan that is not there and has no stand-in.
        """
        try:
            return catalogue.find(self.dataset)
        except ValueError:
            if not self.standin_ok:
                raise
            return catalogue.find(f"{self.dataset}_standin")

    def validate(self) -> None:
        """Refuse unknown names and bad parameters before anything is measured.

        Raises:
            ValueError: an unknown dataset, system, case or field, a value out of range, a label used twice or, as the
                reference, by nobody.
        """
        self.found()
        labels = [subject.name for subject in self.subjects]
        if len(set(labels)) != len(labels):
            raise ValueError(f"subjects: expected different labels, got {labels}")
        if self.reference is not None and self.reference not in labels:
            raise ValueError(f"reference: expected one of {labels}, got {self.reference!r}")
        for subject in self.subjects:
            if subject.system in registry.registry().missing:
                continue  # recorded as skipped
            owner = registry.system(subject.system)
            known = {} if callable(subject.params) else subject.params
            registry.parameters(owner, subject.case, known)
