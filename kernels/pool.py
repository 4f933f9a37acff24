"""A device's memory within its limit: freed buffers are kept for the next of their size, up to a bound."""

from __future__ import annotations

from typing import Any

from lodbench.kernels import driver
from lodbench.kernels.driver import Unsupported

# of the limit: a device that shares the host's memory must not keep all that is not in use; but where a call's own
# buffers pass the bound, each call pays for their pages anew, twice its time
HELD_SHARE = 1 / 4


class Pool:
    """Gives memory out and takes it back.

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
        free = self.limit - self.used_bytes
        if size > free or size > self.largest:
            limit = "free" if size > free else "the largest allocation"
            raise Unsupported(
                f"{name}: needs {size:,} bytes of device memory, "
                f"device has {min(free, self.largest):,} ({limit})"
            )
        driver.check_process()
        try:
            memory = self._pool.allocate(size)
        except self._cl.Error as error:
            raise Unsupported(
                f"{name}: needs {size:,} bytes of device memory, device refused: {error}"
            ) from None
        self.used_bytes += size
        return memory

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
