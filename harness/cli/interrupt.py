"""Ctrl-C, from the first line of the command to the last: exit code 130 and one line, whatever swallows the exception.

SIGTERM ends it in the same way, with 143, so that what was begun is put away. Python raises KeyboardInterrupt wherever
the main thread is. Packages that catch everything while they are imported (trimesh and matplotlib do) lose it, and so
does whatever runs while an object is freed. So an interrupt during an import waits for its end, and one that came to
nothing is raised again until the command says that it has ended.
"""

from __future__ import annotations

import atexit
import os
import signal
import sys
from types import FrameType
from typing import Any

WORDS = {130: "interrupted", 143: "terminated"}  # by 128 + SIGINT, SIGTERM, as shells have them
AGAIN_S = 0.05
_PATIENCE = 3  # so many times Ctrl-C, and the process ends where it is

_running = (
    False  # between the imports and the end of the command, when there is something to unwind
)
_pressed = 0
_signal = int(signal.SIGINT)  # the last that came


def install() -> None:
    """Take Ctrl-C and SIGTERM over from Python; where one is ignored, as after `nohup`, it stays ignored."""
    if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, _interrupted)
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        return
    signal.signal(signal.SIGINT, _interrupted)
    atexit.register(_done)  # the first one registered runs last
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, _again)
        sys.unraisablehook = _unraisable


def _unraisable(what: Any) -> None:
    """An interrupt that a finaliser cannot hand on comes again, so nothing is said of it."""
    if not isinstance(what.exc_value, KeyboardInterrupt):
        sys.__unraisablehook__(what)


def _done() -> None:
    """All is over but Python's own end: the exit code stands."""
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is _interrupted:
            signal.signal(number, signal.SIG_IGN)


def code() -> int:
    """What the command ends with."""
    return 128 + _signal


def running(whether: bool) -> None:
    """Outside the command itself there is nothing to unwind: Ctrl-C ends the process at once."""
    global _running
    _running = whether


def pending() -> bool:
    """Did an interrupt come that nobody has heard yet?"""
    return _pressed > 0


def over() -> None:
    """The interrupt has been heard: it is not raised again."""
    global _pressed
    _pressed = 0
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, 0)


def _interrupted(number: int, frame: FrameType | None) -> None:
    global _pressed, _signal
    _pressed, _signal = _pressed + 1, number
    if not _running or _pressed >= _PATIENCE:
        _leave()
    _again(number, frame)


def _again(number: int, frame: FrameType | None) -> None:
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, AGAIN_S)
    if not _running:
        _leave()
    if not _unwinding() and not _importing(frame):
        raise KeyboardInterrupt


def _unwinding() -> bool:
    """Is an interrupt being dealt with, in a `finally`, an `except` or the end of a `with`?"""
    error = sys.exc_info()[1]
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__context__
    return error is not None


def _importing(frame: FrameType | None) -> bool:
    while frame is not None and not frame.f_code.co_filename.startswith("<frozen importlib"):
        frame = frame.f_back
    return frame is not None


def _leave() -> None:
    caches = sys.modules.get("lodbench.kernels.opencl.caches")
    if caches is not None:
        caches.mark.end()  # what ends here did not die of a damaged kernel
    os.write(2, f"stopped: {WORDS[code()]}\n".encode())
    os._exit(code())
