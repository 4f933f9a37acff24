"""What a record must say of a device."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class DeviceFacts:
    """What a record must say of the device it ran on."""

    name: str
    platform: str
    driver: str
    version: str
    kind: str
    compute_units: int
    memory_bytes: int
    largest_allocation_bytes: int
    local_bytes: int
    extensions: tuple[str, ...]
    one_core: bool
    prelude: bool
    compiles_for: str = ""  # the processor that PoCL was told of; "": the one that it found
