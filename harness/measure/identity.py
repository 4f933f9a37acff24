"""What makes two measurements of a group the same: on resume one that is there is not made again."""

from __future__ import annotations

from typing import Any

from lodbench.harness.measure.timing import NARROW
from lodbench.harness.plan.group import Group


def config_of(
    table: str, group: Group, slug: str, samples: int | None, precision: float, seed: int
) -> dict[str, Any]:
    """All that decides what is measured, for the hash: `slug` is the device's, the rest a `Session`'s arguments."""
    return {
        "table": table, "device": slug, "samples": samples, "seed": seed,
        **({} if precision == NARROW else {"precision": precision}),
        **group.config(),
    }  # fmt: skip
