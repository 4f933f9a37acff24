"""A device: its queue, its pool of memory and the programs built for it."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.kernels.opencl import binaries, caches, driver, facts, processor
from lodbench.kernels.opencl.driver import (
    DeviceError,
    Unsupported,
    choose_device,
    list_devices,
    opencl,
)
from lodbench.kernels.opencl.launch import Program
from lodbench.kernels.opencl.memory import Buffer, Pool, checked, size_of
from lodbench.kernels.opencl.source import PRELUDE, Text, texts_of
from lodbench.kernels.opencl.timeline import Timeline

__all__ = ["Device", "DeviceError", "Unsupported", "list_devices"]

LOCAL_SIZE = 64  # one fixed size: the driver's own choice would compile anew for every mesh size


class Device:
    """One OpenCL device with its queue, its pool of memory and the programs built for it."""

    def __init__(
        self,
        device: Any,
        *,
        memory_limit: int | None = None,
        local_size: int | None = None,
        one_core: bool = False,
        kind: str | None = None,
    ) -> None:
        cl = self.cl = opencl()
        self.handle = device
        self.context = cl.Context([device])
        properties = cl.command_queue_properties.PROFILING_ENABLE
        self._queue = cl.CommandQueue(self.context, device, properties=properties)
        self.memory_limit = int(memory_limit or device.global_mem_size)
        largest = int(device.max_mem_alloc_size)
        self._pool = Pool(self._queue, self.memory_limit, largest)
        self.local_size = min(local_size or LOCAL_SIZE, device.max_work_group_size)
        self._programs: dict[tuple[Any, ...], Program] = {}
        self.is_cpu = (kind := driver.kind_of(device, kind)) == "cpu"
        self.is_pocl = driver.is_pocl(device)
        self._flags = "-w" if self.is_pocl else "-w -D LB_KEEPS_EXACT"  # PoCL's own may be calls
        self.facts = facts.DeviceFacts(
            name=device.name.strip(),
            platform=device.platform.name.strip(),
            driver=f"{device.platform.version.strip()}; driver {device.driver_version.strip()}",
            version=device.version.strip(),
            kind=kind,
            compute_units=int(device.max_compute_units),
            memory_bytes=int(device.global_mem_size),
            largest_allocation_bytes=largest,
            local_bytes=int(device.local_mem_size),
            extensions=tuple(sorted(device.extensions.split())),
            one_core=one_core,
            prelude=driver.needs_prelude(device),
            compiles_for=processor.name_unknown(device) if self.is_pocl else "",
        )

    @classmethod
    def open(
        cls,
        name: str | None = None,
        *,
        memory_limit: int | None = None,
        local_size: int | None = None,
        one_core: bool = False,
        kind: str | None = None,
    ) -> Device:
        """The device asked for, ready to use.

        Args:
            name: words of a platform's or device's name ("pocl 3.1", "intel"), or "platform:device" by index ("0:1");
                None takes `LODBENCH_DEVICE`, else PoCL, else the first device found.
            memory_limit: bytes that may be allocated, to make running out testable; None takes the device's own.
            local_size: work-items per group where a kernel does not fix it; None takes 64.
            one_core: use a single compute unit of the device.
            kind: "gpu" tries the forms for graphics cards on any device; None takes `LODBENCH_KIND`, else what it is.

        Raises:
            DeviceError: no driver, no such device, or the device cannot be split.
        """
        handle = choose_device(name or os.environ.get("LODBENCH_DEVICE") or "")
        if one_core:
            handle = driver.one_core_of(handle)
        given = {"memory_limit": memory_limit, "local_size": local_size, "kind": kind}
        return cls(handle, one_core=one_core, **given)

    @property
    def queue(self) -> Any:
        """Where every command goes.

        Raises:
            DeviceError: this process was forked after the device was opened.
        """
        driver.check_process()
        return self._queue

    @property
    def slug(self) -> str:
        """The device's name for a folder, such as `pocl-amd-epyc`."""
        platform = (
            "pocl" if "portable" in self.facts.platform.lower() else self.facts.platform.split()[0]
        )
        name = re.sub(r"^(pthread|cpu|basic)-", "", self.facts.name.split("(")[0].strip())
        words = re.sub(r"[^a-z0-9]+", "-", f"{platform} {name}".lower()).strip("-")
        return words + ("-one-core" if self.facts.one_core else "")

    def compile(self, texts: Iterable[tuple[str, str]], options: str) -> Any:
        """The built program of (file name, text) pairs, joined in order, each with its own line numbers."""
        if self.facts.compiles_for:  # PoCL's cache of kernels goes by options, and not by this
            options = f"{options} -D COMPILED_FOR_{self.facts.compiles_for.replace('-', '_')}"
        joined = "".join(f'#line 1 "{name}"\n{text}\n' for name, text in texts)
        cl = self.cl
        try:
            with caches.loading() if self.is_pocl else nullcontext():
                return binaries.built(cl, self.context, self.handle, joined, options.split())
        except cl.Error as error:
            log = [line for line in str(error).splitlines() if "error" in line.lower()]
            files = ", ".join(name for name, _ in texts)
            raise DeviceError(
                f"build of {files} failed on {self.handle.name.strip()} with options {options!r}:\n"
                + processor.explained("\n".join(log) or str(error))
            ) from None

    def build(
        self, *files: str | Path | Text, defines: Mapping[str, int | float] | None = None
    ) -> Program:
        """The program of these kernel files, relative to `kernels/`, built once per set of defines.

        Files named on a `// Needs` line are joined in front; `common/prelude.cl` comes first where it is needed.

        Raises:
            DeviceError: the build failed; file, line and options are in the text.
            ValueError: it failed over a user's `Text`, whose argument and line are named.
        """
        options = " ".join(
            f"-D {name}={value}" + ("f" if isinstance(value, float) else "")
            for name, value in (defines or {}).items()
        )
        key = (files, options)
        if key not in self._programs:
            texts = texts_of(files, self.facts.prelude)
            theirs = [file for file in files if isinstance(file, Text)]
            left_out = {PRELUDE, *(name for text in theirs for name in text.parts)}
            source = "\n".join(text for name, text in texts.items() if name not in left_out)
            try:
                compiled = self.compile(list(texts.items()), f"{self._flags} {options}")
            except DeviceError as error:
                for text in theirs:
                    if reason := text.blamed(str(error.__context__)):
                        raise ValueError(reason) from None
                raise
            self._programs[key] = Program(self, compiled, source)
        return self._programs[key]

    def allocate(self, name: str, shape: int | tuple[int, ...], dtype: Any) -> Buffer:
        """Uninitialised memory for an array of `shape` and `dtype`.

        Raises:
            Unsupported: the device, or its limit, has no room for it.
        """
        lengths = (shape,) if isinstance(shape, int | np.integer) else shape
        shape = tuple(int(n) for n in lengths)
        dtype = np.dtype(dtype)
        memory = self._pool.take(name, size_of(shape, dtype))
        return Buffer(name, shape, dtype, memory, self._pool.give_back)

    @property
    def used_bytes(self) -> int:
        """Bytes of all living buffers."""
        return self._pool.used_bytes

    @property
    def held_bytes(self) -> int:
        """Bytes of buffers that are gone, kept for the next; a small share of the limit at most."""
        return self._pool.held_bytes

    def upload(
        self,
        name: str,
        values: ArrayLike,
        dtype: Any = None,
        shape: tuple[int | None, ...] | None = None,
        lent: bool = False,
    ) -> Buffer:
        """A buffer holding `values`, which must already have the dtype and shape (None: any length) asked for.

        Values that are `lent` must stay as they are as long as the buffer lives, and are only read: a CPU reads them
        where they lie.

        Raises:
            TypeError: another dtype. Nothing is converted here: float64 read as float32 would be garbage.
            ValueError: another shape.
            Unsupported: no room.
        """
        array = checked(name, values, dtype, shape)
        if lent and self.is_cpu and array.size:
            return self._in_place(name, array)
        buffer = self.allocate(name, array.shape, array.dtype)
        if array.size:
            self.cl.enqueue_copy(self.queue, buffer.memory, array)
        return buffer

    def _in_place(self, name: str, array: NDArray[Any]) -> Buffer:
        """The host's own memory as a buffer that is only read, counted like any other."""
        flags = self.cl.mem_flags
        driver.check_process()
        self._pool.count(name, array.nbytes)
        memory = self.cl.Buffer(self.context, flags.READ_ONLY | flags.USE_HOST_PTR, hostbuf=array)
        return Buffer(name, array.shape, array.dtype, memory, self._pool.give_back)

    def read(self, buffer: Buffer, rows: int | None = None) -> NDArray[Any]:
        """The buffer's content, or its first `rows` rows, once all that was enqueued is done."""
        return self.read_all((buffer, rows))[0]

    def read_all(self, *wanted: tuple[Buffer, int | None]) -> list[NDArray[Any]]:
        """What `read` gives of each buffer and its rows, after a single wait: waiting takes longer than copying."""
        results = [
            np.empty(buffer.shape if rows is None else (rows, *buffer.shape[1:]), buffer.dtype)
            for buffer, rows in wanted
        ]
        events = [  # kept until the wait: one that goes waits for its own copy
            self.cl.enqueue_copy(self.queue, result, buffer.memory, is_blocking=False)
            for result, (buffer, _) in zip(results, wanted, strict=True)
            if result.size
        ]
        self.wait()
        del events
        return results

    def fill(
        self,
        timeline: Timeline,
        stage: str,
        buffer: Buffer,
        value: Any,
        size_bytes: int | None = None,
    ) -> None:
        """Enqueue the driver's own fill of the whole buffer, or its first `size_bytes`, with one value."""
        if 0 in buffer.shape:
            return
        pattern = buffer.dtype.type(value)
        size = buffer.size_bytes if size_bytes is None else size_bytes
        timeline.add(
            stage, self.cl.enqueue_fill_buffer(self.queue, buffer.memory, pattern, 0, size)
        )

    def copy(self, timeline: Timeline, stage: str, source: Buffer, target: Buffer) -> None:
        """Enqueue the driver's own copy of all of `source` to the front of `target`.

        Raises:
            ValueError: `target` is smaller.
        """
        if target.size_bytes < source.size_bytes:
            raise ValueError(
                f"{target.name}: expected {source.size_bytes} bytes, got {target.size_bytes}"
            )
        if 0 in source.shape:
            return
        event = self.cl.enqueue_copy(
            self.queue, target.memory, source.memory, byte_count=source.size_bytes
        )
        timeline.add(stage, event)

    def wait(self) -> None:
        """Wait for everything enqueued.

        Raises:
            DeviceError: a command failed.
        """
        try:
            self.queue.finish()
        except self.cl.Error as error:
            raise DeviceError(f"a command failed on {self.facts.name}: {error}") from None
        caches.mark.end()

    def loads(self) -> None:
        """A kernel is about to run for the first time here: the driver loads it, and the next wait ends that."""
        if self.is_pocl:
            caches.mark.begin()
