"""Options and arguments that several commands share: what each means, and what the tab key offers for it."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness.cli import complete

DeviceOption = Annotated[
    str | None,
    typer.Option(
        "--device",
        autocompletion=complete.devices,
        help="Part of a device's name, or platform:device by index.",
    ),
]
OutOption = Annotated[
    Path | None,
    typer.Option("--out", help="The run's folder; default results/<device>/<date>-<commit>."),
]
SamplesOption = Annotated[
    int | None,
    typer.Option("--samples", min=1, help="Samples per subject; default 10 or more, 3 over 2 s."),
]
PrecisionOption = Annotated[
    float | None,
    typer.Option(
        "--precision", min=0.0, max=1.0,
        help="Share to which ratios are to be known before sampling ends; default 0.05, 0: never mind.",
    ),
]  # fmt: skip
BudgetOption = Annotated[
    float | None,
    typer.Option("--time-budget", min=0.0, help="Seconds to measure for; --resume goes on."),
]
FilterOption = Annotated[
    str | None, typer.Option("--filter", help="Only what matches this regular expression.")
]
ResumeOption = Annotated[
    bool, typer.Option("--resume", help="Go on with an earlier run; what it holds whole is kept.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Machine-readable output.")]
QuietOption = Annotated[bool, typer.Option("--quiet", "-q", help="No progress.")]
SeedOption = Annotated[int, typer.Option("--seed", min=0, help="Of bootstrap and error samples.")]
RunArgument = Annotated[Path, typer.Argument(metavar="RUN", help="A run's folder.")]
ThresholdOption = Annotated[
    float, typer.Option("--threshold", min=0.0, help="A slowdown below this share is none.")
]
SystemArgument = Annotated[
    str,
    typer.Argument(help="A name from `lodbench list systems`.", autocompletion=complete.systems),
]
TablesArgument = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[TABLE]...", help="Default: all tables.", autocompletion=complete.tables
    ),
]
DatasetsOption = Annotated[
    list[str] | None,
    typer.Option(
        "--dataset", "-d", autocompletion=complete.datasets,
        help="A dataset's name or a mesh file; may be repeated.",
    ),
]  # fmt: skip
AgainstOption = Annotated[
    list[str] | None,
    typer.Option(
        "--against", "-a", autocompletion=complete.systems,
        help="Another system, in turns with it; may be repeated.",
    ),
]  # fmt: skip
CaseOption = Annotated[
    str | None,
    typer.Option("--case", autocompletion=complete.cases, help="A named parameter set."),
]
SettingsOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set", "-s", autocompletion=complete.settings,
        help="NAME=VALUE; a list is an axis: cells=[32,64].",
    ),
]  # fmt: skip
OwnOption = Annotated[
    list[str] | None,
    typer.Option(
        "--set", "-s", help="NAME=VALUE, the method's own; `lodbench list systems METHOD` names them."
    ),
]  # fmt: skip


@dataclass(frozen=True)
class Measuring:
    """How `run`, `sweep` and `reproduce` measure, where to, and what they say: the options that they share."""

    device: DeviceOption = None
    out: OutOption = None
    samples: SamplesOption = None
    precision: PrecisionOption = None
    time_budget: BudgetOption = None
    keep: FilterOption = None
    resume: ResumeOption = False
    seed: SeedOption = 0
    json_output: JsonOption = False
    quiet: QuietOption = False


def measuring(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of `Measuring` after its own; it has them as one, its last parameter, `how`."""
    own = inspect.signature(command, eval_str=True).parameters
    shared = inspect.signature(Measuring, eval_str=True).parameters

    @wraps(command)
    def with_options(**given: Any) -> None:
        how = Measuring(**{name: given.pop(name) for name in shared})
        command(**given, how=how)

    options = [*list(own.values())[:-1], *shared.values()]
    with_options.__signature__ = inspect.Signature(options)  # pyright: ignore[reportAttributeAccessIssue]
    return with_options


def method_option(offered: Callable[..., Any]) -> Any:
    """--method, of a verb; `offered` completes it."""
    return typer.Option(
        "--method", "-m", autocompletion=offered,
        help="A system with this verb; default: the first that takes the surface.",
    )  # fmt: skip


def parameters(settings: list[str] | None) -> dict[str, Any]:
    """Values by name, of NAME=VALUE words.

    Raises:
        ValueError: a word without the sign.
    """
    from lodbench.harness.plan import sweep

    found: dict[str, Any] = {}
    for setting in settings or []:
        name, equals, value = setting.partition("=")
        if not equals:
            raise ValueError(f"set: expected NAME=VALUE, got {setting!r}")
        found[name.strip()] = sweep.literal(value)
    return found


def pattern(text: str) -> Any:
    """The regular expression of a --filter.

    Raises:
        ValueError: it is none.
    """
    import re

    try:
        return re.compile(text)
    except re.error as error:
        raise ValueError(f"filter: expected a regular expression, got {text!r}: {error}") from None
