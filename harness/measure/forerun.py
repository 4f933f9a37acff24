"""Peers from packages are called once in a process of their own before they are measured: crashes and hangs stay there.

What came back there is then run in the measuring process, where subjects take turns under the same clock as ever; the
other waits for its next call meanwhile and computes nothing. Errors of Python's are left to the measuring process: it
meets them again.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from types import SimpleNamespace
from typing import Any

from lodbench.kernels.opencl import Device, DeviceError, Timeline
from lodbench.kernels.system import Frame, System

LIMIT_S = 300.0  # of a call, preparing included; `LODBENCH_PEER_LIMIT` in its place
START_S = 120.0


class PeerFault(DeviceError):
    """A peer crashed or hung where it was tried."""


def is_peer(system: System[Any]) -> bool:
    """Is it code from a package, of which nobody here can say that it returns?"""
    return system.runs_on == "host" and system.source.startswith("PyPI ")


class Forerunner:
    """The process in which peers are tried: begun with the first, and anew after one that crashed or hung."""

    def __init__(self) -> None:
        self._child: Any = None
        self._said: queue.Queue[Any] = queue.Queue()

    def try_out(self, system: System[Any], device: Device, surface: Any, params: Any) -> None:
        """One frame of a peer; what is no peer is not tried.

        Raises:
            PeerFault: the process ended, or the frame took too long.
        """
        if not is_peer(system):
            return
        limit_s = float(os.environ.get("LODBENCH_PEER_LIMIT") or LIMIT_S)
        work = pickle.dumps((system.name, device.facts, surface, params))
        if self._child is None and not self._begin():
            return
        child: Any = self._child
        try:
            child.stdin.write(len(work).to_bytes(8, "little") + work)
            child.stdin.flush()
            said = self._said.get(timeout=limit_s)
        except OSError:
            said = None
        except queue.Empty:
            self.close()
            raise PeerFault(
                f"{system.name} did not return within {limit_s:g} s, and was ended"
            ) from None
        if said is None:
            code = child.wait()
            self.close()
            how = f"exit code {code}"
            if code < 0:
                how = signal.Signals(-code).name
            raise PeerFault(
                f"{system.name} crashed where it was tried, in a process of its own: {how}"
            )

    def _begin(self) -> bool:
        """Start the process; False where it does not come up, and peers are measured untried."""
        self._said = queue.Queue()
        self._child = subprocess.Popen(
            [sys.executable, "-m", __name__], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )  # fmt: skip
        threading.Thread(target=_listen, args=(self._child, self._said), daemon=True).start()
        with contextlib.suppress(queue.Empty):
            if self._said.get(timeout=START_S):
                return True
        self.close()
        return False

    def close(self) -> None:
        """End the process."""
        if self._child is not None:
            self._child.kill()
            self._child.wait()
            for pipe in (self._child.stdin, self._child.stdout):
                with contextlib.suppress(OSError):
                    pipe.close()
            self._child = None


def _listen(child: Any, said: queue.Queue[Any]) -> None:
    """A true word for each line; None at the end."""
    with contextlib.suppress(ValueError, OSError):
        for line in child.stdout:
            said.put(line.strip() or b"?")
    said.put(None)


def main() -> None:
    """Say when ready, and when each call is over; until standard input ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # it ends with whoever asked
    answers = os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # what peers print is not for anybody
    from lodbench.harness.plan.registry import systems

    found = systems()
    answers.write(b"ready\n")
    while len(head := sys.stdin.buffer.read(8)) == 8:
        name, facts, surface, params = pickle.loads(
            sys.stdin.buffer.read(int.from_bytes(head, "little"))
        )
        with contextlib.suppress(Exception):
            device: Any = SimpleNamespace(facts=facts, is_cpu=facts.kind == "cpu")
            prepared = found[name].prepare(device, surface, params)
            prepared.enqueue(Frame(), Timeline())
            prepared.result()
        answers.write(b"done\n")


if __name__ == "__main__":
    main()
