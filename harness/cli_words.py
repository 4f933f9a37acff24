"""The words of `run` and `reproduce`: what each means, and what the tab key offers for it."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from lodbench.harness import complete

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


def parameters(settings: list[str] | None) -> dict[str, Any]:
    """Values by name, of NAME=VALUE words.

    Raises:
        ValueError: a word without the sign.
    """
    from lodbench.harness import sweep

    found: dict[str, Any] = {}
    for setting in settings or []:
        name, equals, value = setting.partition("=")
        if not equals:
            raise ValueError(f"set: expected NAME=VALUE, got {setting!r}")
        found[name.strip()] = sweep.literal(value)
    return found


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
