"""What a worker of a Dask cluster does for a sweep: says what its devices are, and measures one group at a time."""

from __future__ import annotations

import hashlib
import tempfile
import threading
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from lodbench.datasets_gen import catalogue
from lodbench.harness.measure import limits
from lodbench.harness.measure.run import Session
from lodbench.harness.plan.group import Group
from lodbench.harness.record.environment import environment
from lodbench.harness.record.record import plain, read_rows
from lodbench.harness.record.samples import SAMPLES
from lodbench.kernels.opencl import Device, DeviceError, Unsupported

_measuring = threading.Lock()  # threads of one worker take turns, however many it was given
_devices: dict[str | None, Device] = {}
_files: dict[str, Path] = {}  # by content


def _device(name: str | None) -> Device:
    if name not in _devices:
        _devices[name] = Device.open(name)
    return _devices[name]


def describe(names: Sequence[str | None]) -> list[dict[str, Any] | str]:
    """The environment of each of these devices, or why it cannot be opened."""
    found: list[dict[str, Any] | str] = []
    with _measuring:
        for name in names:
            try:
                found.append(plain(environment(_device(name), {}, 0)))
            except (DeviceError, Unsupported) as error:
                found.append(str(error))
    return found


def rates(name: str | None) -> dict[str, Any]:
    """The device's measured limits, as the row of a record."""
    with _measuring:
        return plain(vars(limits.measure(_device(name))))


def measure(
    name: str | None,
    table: str,
    group: Group,
    arguments: Mapping[str, Any],
    file: tuple[str, bytes] | None = None,
) -> tuple[list[dict[str, Any]], bool]:
    """A group's rows, and whether there was time for all of it.

    Args:
        name: of the device.
        table: the group's.
        group: what is measured.
        arguments: of a `Session`, but device and folder.
        file: where the dataset is a file of somebody's own: its name and its bytes.
    """
    with _measuring, tempfile.TemporaryDirectory(prefix="lodbench-group-") as folder:
        if file is not None:
            _adopt(group.dataset, *file)
        session = Session(_device(name), Path(folder), **arguments)
        try:
            left_out = session.measure([(table, group)], quiet=True)
        finally:
            session.close()
        return read_rows(Path(folder) / SAMPLES), not left_out


def _adopt(dataset: str, name: str, data: bytes) -> None:
    """Have the catalogue know a file's bytes under the name that the sweep has for them."""
    content = hashlib.sha256(data).hexdigest()
    if content not in _files:
        folder = Path(tempfile.mkdtemp(prefix="lodbench-file-"))
        (folder / name).write_bytes(data)
        _files[content] = folder / name
    found = catalogue.adopt(_files[content]).name
    if found != dataset.removesuffix("_sorted"):
        raise ValueError(
            f"dataset: expected {dataset} for the file {name}, got {found} on a worker"
        )
