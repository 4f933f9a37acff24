"""The command line: `lodbench COMMAND`; errors are one line on standard error and exit code 2."""

from __future__ import annotations

import errno
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import typer

from lodbench.harness import complete, interrupt
from lodbench.harness.terminal import hint, say, say_in_any_encoding, say_json, say_rows

app = typer.Typer(
    name="lodbench",
    help="The level-of-detail systems of the GPU literature as OpenCL kernels, measured against what people would "
    "use instead.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)

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


class Stopped(Exception):
    """The command ends here with this exit code; the text says what is kept and how to go on."""

    def __init__(self, code: int, text: str) -> None:
        super().__init__(text)
        self.code = code


@contextmanager
def records_kept(folder: Path) -> Iterator[None]:
    """Ctrl-C and a full disk end with one line that says where the records are."""
    try:
        yield
    except KeyboardInterrupt:
        raise Stopped(
            130, f"interrupted; what was measured is kept: go on with --resume --out {folder}"
        ) from None
    except OSError as error:
        if error.errno not in (errno.ENOSPC, errno.EDQUOT):
            raise
        raise Stopped(
            2, f"disk full; what was measured is kept: make room, then --resume --out {folder}"
        ) from None


def _version(asked: bool) -> None:
    if asked:
        from importlib.metadata import version

        say(f"lodbench {version('lodbench')}")
        raise typer.Exit


@app.callback()
def _common(
    debug: Annotated[bool, typer.Option("--debug", help="Show a traceback on errors.")] = False,
    version: Annotated[
        bool,
        typer.Option(
            "--version", "-V", callback=_version, is_eager=True, help="Say which version this is."
        ),
    ] = False,
) -> None:
    pass


@app.command()
def doctor(json_output: JsonOption = False) -> None:
    """Say what is wrong with OpenCL on this machine, and the exact line that mends it.

    Example: lodbench doctor
    """
    from lodbench.harness import doctor as examine

    raise typer.Exit(examine.main(json_output))


lists = typer.Typer(help="What there is: systems, datasets, tables, devices.", no_args_is_help=True)
app.add_typer(lists, name="list")


def _listing(rows: list[dict[str, Any]], json_output: bool, keep: str | None) -> None:
    import re

    if keep:
        pattern = _pattern(keep)
        rows = [row for row in rows if re.search(pattern, " ".join(map(str, row.values())))]
    if json_output:
        say_json(rows)
    elif rows:
        say_rows([{"key": key, "label": key} for key in rows[0]], rows)
    else:
        hint(f"nothing there{f' that {keep} matches' if keep else ''}")


def _pattern(text: str) -> Any:
    import re

    try:
        return re.compile(text)
    except re.error as error:
        raise ValueError(f"filter: expected a regular expression, got {text!r}: {error}") from None


@lists.command("systems")
def list_systems(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]",
            autocompletion=complete.systems,
            help="One of them, with its parameters.",
        ),
    ] = None,
    json_output: JsonOption = False,
    keep: FilterOption = None,
) -> None:
    """Systems and baselines, with their cases; or one system's parameters.

    Example: lodbench list systems --filter cluster
    """
    from lodbench.harness.registry import registry, system
    from lodbench.kernels.parameters import described

    if name is not None:
        _listing(described(type(next(iter(system(name).cases.values())))), json_output, keep)
        return
    found = registry()
    rows = [
        {
            "system": s.name,
            "family": s.family,
            "runs on": s.runs_on,
            "takes": ", ".join(kind.__name__ for kind in s.takes),
            "verbs": ", ".join(s.verbs),
            "cases": ", ".join(s.cases),
            "source": s.source,
        }
        for s in found.systems.values()
    ]
    rows += [
        {"system": name, "family": "", "runs on": "", "takes": "", "verbs": "", "cases": "",
         "source": f"cannot be used here: {reason}"}
        for name, reason in found.missing.items()
    ]  # fmt: skip
    _listing(rows, json_output, keep)


@lists.command("tables")
def list_tables(json_output: JsonOption = False, keep: FilterOption = None) -> None:
    """Tables and figures that `reproduce` makes.

    Example: lodbench list tables
    """
    from lodbench.harness.tables import tables

    rows = [{"table": t.id, "title": t.title, "source": t.source} for t in tables().values()]
    _listing(rows, json_output, keep)


@lists.command("devices")
def list_devices(json_output: JsonOption = False, keep: FilterOption = None) -> None:
    """OpenCL devices, by the index and the names that --device takes.

    Example: lodbench list devices
    """
    from lodbench.kernels import driver

    found = driver.list_devices()
    if not found:
        driver.choose_device("")  # raises what is in the way
    rows = [{"index": i, "platform": p, "device": d} for i, p, d, _ in found]
    _listing(rows, json_output, keep)


@lists.command("datasets")
def list_datasets(json_output: JsonOption = False, keep: FilterOption = None) -> None:
    """Surfaces by name, generated and read.

    Example: lodbench list datasets --filter torus
    """
    from lodbench.harness.cli_datasets import dataset_rows

    _listing(dataset_rows(), json_output, keep)


def _register() -> None:
    """Import the files that add their commands to `app`, in the order of the help."""
    for part in ("mesh", "image", "measure", "records", "datasets"):
        import_module(f"lodbench.harness.cli_{part}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code and raises nothing but `SystemExit`."""
    say_in_any_encoding()
    _register()
    words = list(sys.argv[1:] if arguments is None else arguments)
    debug = "--debug" in words
    words = [word for word in words if word != "--debug"]
    try:
        code = int(app(words, standalone_mode=False, prog_name="lodbench") or 0)
        # typer itself turns Ctrl-C into an exit code
        return interrupted(debug) if code == interrupt.CODE else code
    except KeyboardInterrupt:
        return interrupted(debug)
    except Stopped as stopped:
        return _end(stopped.code, str(stopped), debug)
    except BrokenPipeError:
        sys.stderr.close()  # nobody reads the output any more: nothing left to say
        return 1
    except Exception as error:
        return _end(2, _text(error), debug)


def _text(error: Exception) -> str:
    if hasattr(error, "format_message"):  # the command line's own errors
        return f"{error.format_message()} (see --help)"  # type: ignore[attr-defined]
    if isinstance(error, OSError) and error.filename is not None:
        return f"{error.filename}: {error.strerror}"
    text = str(error) or type(error).__name__
    from lodbench.kernels.device import DeviceError, Unsupported

    known = ValueError, TypeError, OSError, ImportError, DeviceError, Unsupported
    if not isinstance(error, known):
        text = f"{type(error).__name__}: {text} (a fault in lodbench; --debug shows where)"
    return "; ".join(line.strip() for line in text.splitlines() if line.strip())


def interrupted(debug: bool = False) -> int:
    """Say that Ctrl-C ended the command; the exit code."""
    return _end(interrupt.CODE, "interrupted", debug)


def _end(code: int, text: str, debug: bool) -> int:
    if code == interrupt.CODE:
        interrupt.over()
    if debug:
        traceback.print_exc()
    say(f"{'stopped' if code == 130 else 'error'}: {text}", err=True)
    return code
