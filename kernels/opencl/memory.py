"""Device memory: arrays with their names, and the pool that they come from and go back to, within its limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodbench.kernels.opencl import driver
from lodbench.kernels.opencl.driver import Unsupported

# of the limit: a device that shares the host's memory must not keep all that is not in use; but where a call's own
# buffers pass the bound, each call pays for their pages anew, twice its time
HELD_SHARE = 1 / 4


def checked(
    name: str, values: ArrayLike, dtype: Any, shape: tuple[int | None, ...] | None
) -> NDArray[Any]:
    """`values` as one whole array, which has the dtype and shape (None: any, any length) asked for.

    Raises:
        TypeError, ValueError: it has another one.
    """
    if isinstance(values, np.ndarray) and values.flags.c_contiguous and values.flags.aligned:
        array = values
    else:
        array = np.require(values, requirements=("C", "A"))
    if dtype is not None and array.dtype != np.dtype(dtype):
        raise TypeError(f"{name}: expected {np.dtype(dtype)}, got {array.dtype}")
    if shape is not None and (
        array.ndim != len(shape)
        or any(
            want is not None and want != have for want, have in zip(shape, array.shape, strict=True)
        )
    ):
        wanted = tuple("n" if want is None else want for want in shape)
        raise ValueError(f"{name}: expected shape {wanted}, got {array.shape}")
    return array


def size_of(shape: tuple[int, ...], dtype: np.dtype) -> int:
    """Bytes of such an array; a driver needs one of an empty one."""
    return math.prod(shape) * dtype.itemsize or 1


@dataclass(eq=False)
class Buffer:
    """Device memory of one array, with the name, shape and dtype that a kernel's argument is checked against."""

    name: str
    shape: tuple[int, ...]
    dtype: np.dtype
    memory: Any
    _release: Callable[[int], None]
    _owner: Buffer | None = None  # of a view: who holds the memory, and gives it back
    size_bytes: int = field(init=False)

    def __post_init__(self) -> None:
        self.size_bytes = size_of(self.shape, self.dtype)

    def view(self, shape: int | tuple[int, ...], dtype: Any) -> Buffer:
        """The same memory as another type or shape; it lives as long as its last view.

        Raises:
            ValueError: more bytes than the buffer has.
        """
        shape = (
            (int(shape),) if isinstance(shape, int | np.integer) else tuple(int(n) for n in shape)
        )
        viewed = Buffer(self.name, shape, np.dtype(dtype), self.memory, self._release, self)
        if viewed.size_bytes > self.size_bytes:
            raise ValueError(
                f"{self.name}: expected a view of at most {self.size_bytes} bytes, "
                f"got {viewed.size_bytes}"
            )
        return viewed

    def release(self) -> None:
        """Give the memory back to the device's pool."""
        if self._owner is not None:
            self.memory = self._owner = None
        elif self.memory is not None:
            self.memory.release()
            self.memory = None
            self._release(self.size_bytes)

    def __del__(self) -> None:
        try:
            self.release()
        except Exception:  # the interpreter or the driver is going away; nothing is left to free
            self.memory = None


class Pool:
    """Gives memory out and takes it back: freed buffers are kept for the next of their size, up to a bound.

    Attributes:
        limit: bytes that may be in use.
        largest: bytes of one allocation.
        used_bytes: bytes in use.
    """

    def __init__(self, queue: Any, limit: int, largest: int) -> None:
        self._cl = driver.opencl()
        self._pool = self._cl.tools.MemoryPool(self._cl.tools.ImmediateAllocator(queue))
        self.limit, self.largest = limit, largest
        self.used_bytes = 0

    def take(self, name: str, size: int) -> Any:
        """`size` bytes for the buffer called `name`.

        Raises:
            Unsupported: the device, or its limit, has no room for it.
            DeviceError: see `driver.check_process`.
        """
        self.count(name, size)
        driver.check_process()
        try:
            return self._pool.allocate(size)
        except self._cl.Error as error:
            self.used_bytes -= size
            raise Unsupported(
                f"{name}: needs {size:,} bytes of device memory, device refused: {error}"
            ) from None

    def count(self, name: str, size: int) -> None:
        """Count `size` bytes as in use, whoever has them, until they are given back.

        Raises:
            Unsupported: the device, or its limit, has no room for them.
        """
        free = self.limit - self.used_bytes
        if size > free or size > self.largest:
            limit = "free" if size > free else "the largest allocation"
            raise Unsupported(
                f"{name}: needs {size:,} bytes of device memory, "
                f"device has {min(free, self.largest):,} ({limit})"
            )
        self.used_bytes += size

    def give_back(self, size: int) -> None:
        """A buffer of `size` bytes was released; what is held beyond the bound goes back to the driver."""
        self.used_bytes -= size
        if self.held_bytes > HELD_SHARE * self.limit:
            driver.check_process()
            self._pool.free_held()

    @property
    def held_bytes(self) -> int:
        """Bytes that are kept and not in use."""
        return self._pool.managed_bytes - self._pool.active_bytes
