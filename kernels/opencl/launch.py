"""Kernels bound to their arguments by the names that their source gives them."""

from __future__ import annotations

import math
import struct
from collections.abc import KeysView, Mapping
from functools import cache
from typing import Any, Protocol

import numpy as np

from lodbench.kernels.opencl import caches
from lodbench.kernels.opencl.driver import DeviceError
from lodbench.kernels.opencl.image import Image
from lodbench.kernels.opencl.memory import Buffer
from lodbench.kernels.opencl.source import Parameter, kernel_parameters
from lodbench.kernels.opencl.timeline import Timeline


class Owner(Protocol):
    """What a launch asks of the device that it belongs to."""

    cl: Any  # pyopencl
    local_size: int
    is_pocl: bool

    @property
    def queue(self) -> Any:
        """Where commands go."""
        ...

    def loads(self) -> None:
        """A kernel is about to run for the first time."""
        ...


@cache
def _range(scalar: np.dtype) -> tuple[int, int] | None:
    """Least and largest value of an integer type; None of another one."""
    if scalar.kind not in "iu":
        return None
    info = np.iinfo(scalar)
    return info.min, info.max


class Launch:
    """One kernel with its arguments set, ready to be enqueued any number of times."""

    def __init__(
        self,
        device: Owner,
        name: str,
        kernel: tuple[Any, dict[int, bytes]],
        parameters: Mapping[str, tuple[int, Parameter]],
        stage: str,
        items: int | tuple[int, int],
        local: tuple[int, ...],
        arguments: Mapping[str, Any],
        loaded: set[Any],
        spare: list[Any],
    ) -> None:
        self.stage = stage
        self._device = device
        self._name, (self._kernel, self._set), self._spare = name, kernel, spare
        self._position = parameters
        self._held: dict[str, Any] = {}  # buffers stay alive as long as the launch
        # what `set_arg` comes to for a value, once it has spent 60 times as long on finding out that it is one
        self._set_value = getattr(self._kernel, "_set_arg_buf", self._kernel.set_arg)
        self._local = local
        self._loaded = loaded  # of the program: names and group sizes that have run
        self._key = (name, local)
        self.items = items
        if missing := self._position.keys() - arguments.keys():
            raise TypeError(f"{name}: expected arguments {sorted(missing)}, got none of them")
        self.set(**arguments)

    def __del__(self) -> None:
        self._spare.append((self._kernel, self._set))

    @property
    def parameters(self) -> KeysView[str]:
        """Names of the kernel's parameters."""
        return KeysView(self._position)

    @property
    def items(self) -> tuple[int, ...]:
        """Work-items asked for; the launch is padded to whole work-groups."""
        return self._items

    @items.setter
    def items(self, items: int | tuple[int, ...]) -> None:
        self._items = (items,) if isinstance(items, int | np.integer) else tuple(items)
        self._global = tuple(
            max(-(-int(n) // size), 1) * size
            for n, size in zip(self._items, self._local, strict=True)
        )

    @property
    def groups(self) -> int:
        """Work-groups of the padded launch."""
        return math.prod(self._global) // math.prod(self._local)

    def set(self, **arguments: Any) -> None:
        """Set arguments by name: a `Buffer` for a pointer, a number or a short tuple for a value."""
        for name, value in arguments.items():
            if name not in self._position:
                expected = ", ".join(self._position)
                raise TypeError(f"{self._name}: expected one of {expected}, got {name}")
            index, parameter = self._position[name]
            if type(value) is Buffer and value.dtype.char in parameter.types:
                self._kernel.set_arg(index, value.memory)
            elif parameter.space:
                self._kernel.set_arg(index, self._argument(parameter, value))
            elif self._set.get(index) != (packed := self._argument(parameter, value)):
                self._set_value(index, packed)
                self._set[index] = packed
        self._held |= arguments

    def _argument(self, parameter: Parameter, value: Any) -> Any:
        if parameter.space == "local":
            return self._device.cl.LocalMemory(int(value))
        if parameter.space:
            if not isinstance(value, Buffer):
                where = f"{self._name}: {parameter.name}"
                raise TypeError(f"{where}: expected a Buffer, got {type(value).__name__}")
            if (parameter.space == "image") != isinstance(value, Image):
                expected = "an Image" if parameter.space == "image" else "a Buffer"
                raise TypeError(
                    f"{self._name}: {parameter.name}: expected {expected}, got {value.name}"
                )
            if value.dtype.char not in parameter.likes:
                raise TypeError(
                    f"{self._name}: {parameter.name}: expected {parameter.scalar}, "
                    f"got {value.name} of {value.dtype}"
                )
            return value.memory
        try:
            layout = parameter.layout
            return layout.pack(value) if parameter.lanes == 1 else layout.pack(*value)
        except (struct.error, OverflowError, TypeError):
            return self._converted(parameter, value).tobytes()

    def _converted(self, parameter: Parameter, value: Any) -> Any:
        """A value that is not yet what its bytes are made of, as numpy converts it."""
        if parameter.lanes == 1:
            bounds = _range(parameter.scalar)
            if bounds is not None and not bounds[0] <= int(value) <= bounds[1]:
                least, most = bounds
                raise ValueError(
                    f"{self._name}: {parameter.name}: expected {least} to {most}, got {value}"
                )
            return parameter.scalar.type(value)
        lanes = 4 if parameter.lanes == 3 else parameter.lanes
        vector = np.zeros(lanes, parameter.scalar)
        vector[: parameter.lanes] = value
        return vector

    def __call__(self, timeline: Timeline) -> Any:
        """Enqueue; never waits. Returns the event, which `timeline` also keeps under the launch's stage."""
        return self._enqueue(timeline, self._global, None)

    def group(self, timeline: Timeline, index: int) -> Any:
        """Enqueue one work-group of a launch in one dimension and no other, to time it alone."""
        (size,) = self._local
        return self._enqueue(timeline, self._local, (index * size,))

    def _enqueue(self, timeline: Timeline, items: tuple[int, ...], first: Any) -> Any:
        cl = self._device.cl
        if self._key not in self._loaded:
            self._loaded.add(self._key)
            self._device.loads()
        event = cl.enqueue_nd_range_kernel(
            self._device.queue, self._kernel, items, self._local, first
        )
        timeline.add(self.stage, event)
        return event


class Program:
    """A built program: its kernels become launches."""

    def __init__(self, device: Owner, program: Any, source: str) -> None:
        self._device = device
        self._program = program
        self.kernels = kernel_parameters(source)
        self._positions = {
            name: {p.name: (i, p) for i, p in enumerate(parameters)}
            for name, parameters in self.kernels.items()
        }
        # pyopencl takes 0.2 ms for each new kernel object: those of launches that are gone serve again, with the bytes
        # of the values that they have
        self._spare: dict[str, list[Any]] = {name: [] for name in self.kernels}
        self._loaded: set[Any] = set()

    def launch(
        self,
        kernel: str,
        items: int | tuple[int, int],
        *,
        stage: str,
        local: int | tuple[int, ...] | None = None,
        **arguments: Any,
    ) -> Launch:
        """A kernel bound to its arguments, given by the names that its source gives them.

        Args:
            kernel: the kernel's name.
            items: work-items, 1-D or 2-D; padded to whole work-groups, so the kernel checks its bounds.
            stage: the stage that its seconds count towards.
            local: work-group size; None takes the device's fixed one. Kernels with barriers give theirs.
            **arguments: a `Buffer` per pointer, bytes per `__local` pointer, a number or tuple per value.

        Raises:
            TypeError: an argument missing, unknown or of another dtype than the kernel's parameter.
            ValueError: a value out of its integer type's range.
        """
        if kernel not in self.kernels:
            raise ValueError(f"kernel: expected one of {', '.join(self.kernels)}, got {kernel}")
        dimensions = 1 if isinstance(items, int | np.integer) else len(items)
        if local is None:
            local = (self._device.local_size,) + (1,) * (dimensions - 1)
        sizes = (local,) if isinstance(local, int) else tuple(local)
        spare = self._spare[kernel]
        made = spare.pop() if spare else self._made(kernel)
        return Launch(
            self._device, kernel, made, self._positions[kernel], stage, items, sizes, arguments,
            self._loaded, spare,
        )  # fmt: skip

    def _made(self, kernel: str) -> tuple[Any, dict[int, bytes]]:
        try:
            return self._device.cl.Kernel(self._program, kernel), {}
        except self._device.cl.Error as error:
            why = caches.damaged() if self._device.is_pocl else str(error)
            raise DeviceError(
                f"{kernel}: expected a kernel that was built, got none: {why}"
            ) from None
