"""The command line: `lodbench COMMAND`; errors are one line on standard error and exit code 2."""

from __future__ import annotations

import errno
import sys
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

from lodbench.harness.cli import interrupt
from lodbench.harness.cli.output import say, say_in_any_encoding

app = typer.Typer(
    name="lodbench",
    help="The level-of-detail systems of the GPU literature as OpenCL kernels, measured against what people would "
    "use instead.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
    context_settings={"help_option_names": ["-h", "--help"]},
)


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
            interrupt.code(),
            f"{interrupt.WORDS[interrupt.code()]}; what was measured is kept: go on with --resume --out {folder}",
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


def _register() -> None:
    """Import the files that add their commands to `app`, in the order of the help."""
    for part in (
        "lists",
        "mesh",
        "tessellate",
        "render",
        "image",
        "sweep",
        "reproduce",
        "records",
        "guard",
        "datasets",
    ):
        import_module(f"lodbench.harness.cli.{part}")


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
        return interrupted(debug) if code in interrupt.WORDS else code
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
    from lodbench.kernels.opencl import DeviceError, Unsupported

    known = ValueError, TypeError, OSError, ImportError, DeviceError, Unsupported
    if not isinstance(error, known):
        text = f"{type(error).__name__}: {text} (a fault in lodbench; --debug shows where)"
    return "; ".join(line.strip() for line in text.splitlines() if line.strip())


def interrupted(debug: bool = False) -> int:
    """Say that Ctrl-C or SIGTERM ended the command; the exit code."""
    return _end(interrupt.code(), interrupt.WORDS[interrupt.code()], debug)


def _end(code: int, text: str, debug: bool) -> int:
    if code in interrupt.WORDS:
        interrupt.over()
    if debug:
        traceback.print_exc()
    say(f"{'stopped' if code in interrupt.WORDS else 'error'}: {text}", err=True)
    return code
