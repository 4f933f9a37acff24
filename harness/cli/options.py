"""Options and arguments that several commands share: what each means, and what the tab key offers for it."""

from __future__ import annotations

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
