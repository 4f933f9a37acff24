"""A Dask cluster as a sweep sees it: workers that may measure, jobs pinned to one of them, and what came of these."""

from __future__ import annotations

import importlib
import logging
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

RESOURCE = "lodbench"
START = f"dask worker ADDRESS --nthreads 1 --resources {RESOURCE}=1"
POLL_S = 0.5
CONNECT_S = 10.0


class Lost(Exception):
    """The job's worker is gone."""


class Cluster:
    """The client of a scheduler; only workers with the resource are used, and one job at a time takes it."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._distributed = importlib.import_module("distributed")
        self._sent: dict[str, Any] = {}

    def workers(self) -> dict[str, str]:
        """Address -> host of the workers that may be used now."""
        try:
            found = self._client.scheduler_info(n_workers=-1)
        except TypeError:  # before 2025 it told of all
            found = self._client.scheduler_info()
        return {
            address: worker["host"]
            for address, worker in found["workers"].items()
            if worker.get("resources", {}).get(RESOURCE)
        }

    def submit(self, address: str, function: Any, *arguments: Any) -> Any:
        """Have this worker call it; a future, which may be an argument of another."""
        return self._client.submit(
            function, *arguments, pure=False, retries=0, workers=[address], allow_other_workers=False,
            resources={RESOURCE: 1},
        )  # fmt: skip

    def done(self, futures: Iterable[Any]) -> Iterator[tuple[Any, Any]]:
        """Wait a moment for one to be done; those that are, with what they gave, or a `Lost`.

        Raises:
            ValueError: one ended in an error.
        """
        waited = list(futures)
        if not waited:
            time.sleep(POLL_S)
            return
        try:
            done = self._distributed.wait(
                waited, timeout=POLL_S, return_when="FIRST_COMPLETED"
            ).done
        except (TimeoutError, self._distributed.TimeoutError):
            return
        for future in done:
            if future.status == "finished":
                yield future, future.result()
                continue
            error = future.exception(timeout=CONNECT_S) if future.status == "error" else Lost()
            if not isinstance(error, Lost | self._distributed.KilledWorker):
                said = " ".join(str(error).split())
                raise ValueError(
                    f"dask: a worker ended in {type(error).__name__}: {said}"
                ) from error
            yield future, Lost()

    def cancel(self, futures: Iterable[Any]) -> None:
        """Forget these."""
        self._client.cancel(list(futures))

    def send(self, path: Path, content: str) -> Any:
        """A file's name and bytes, on their way to all workers, once per `content`."""
        if content not in self._sent:
            (self._sent[content],) = self._client.scatter(
                [(path.name, path.read_bytes())], broadcast=True
            )
        return self._sent[content]

    def send_anew(self) -> None:
        """A worker is gone, and what it held with it."""
        self._sent.clear()


@contextmanager
def connected(address: str) -> Iterator[Cluster]:
    """The cluster whose scheduler is at this address.

    Raises:
        ImportError: dask.distributed is not installed.
        ValueError: nobody answers there.
    """
    try:
        distributed = importlib.import_module("distributed")
    except ImportError:
        raise ImportError(
            'dask: needs dask.distributed, this environment has none: pip install "lodbench[dask]"'
        ) from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        client = distributed.Client(address, timeout=CONNECT_S)
    except (OSError, ValueError, TimeoutError):
        raise ValueError(
            f"dask: expected a scheduler's address such as tcp://host:8786, got no answer at {address}"
        ) from None
    with client:
        yield Cluster(client)
