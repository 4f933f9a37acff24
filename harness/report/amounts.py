"""Numbers for people: four significant digits, thousands separated, a unit that fits."""

from __future__ import annotations

import math
from typing import Any

_STEPS = {
    "s": ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs"), (1e-9, "ns")),
    "B": ((1e9, "GB"), (1e6, "MB"), (1e3, "kB"), (1.0, "B")),
    "B/s": ((1e9, "GB/s"), (1e6, "MB/s"), (1e3, "kB/s"), (1.0, "B/s")),
    "flop/s": ((1e9, "Gflop/s"), (1e6, "Mflop/s"), (1.0, "flop/s")),
}


def rounded(value: float, digits: int = 4) -> str:
    """`value` in `digits` significant digits, without an exponent between a ten-thousandth and a thousand million."""
    if not math.isfinite(value):
        return str(value)
    if value == 0:
        return "0"
    exponent = math.floor(math.log10(abs(value)))
    if -5 < exponent < 9:
        places = max(digits - 1 - exponent, 0)
        text = f"{round(value, digits - 1 - exponent):,.{places}f}"
        return text.rstrip("0").rstrip(".") if places else text
    mantissa, power = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa.rstrip('0').rstrip('.')}e{int(power)}"


def amount(value: Any, unit: str = "", digits: int = 4) -> str:
    """A table's value in words: seconds and bytes in a readable unit, counts whole, None as a dash."""
    if value is None or value == "":
        return "–"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return " × ".join(amount(item) for item in value)
    if not isinstance(value, int | float):
        return str(value)
    for scale, name in _STEPS.get(unit, ()):
        if abs(value) >= scale:
            return f"{rounded(value / scale, digits)} {name}"
    if unit in _STEPS:
        return f"{rounded(value, digits)} {unit}"
    return f"{value:,}" if isinstance(value, int) else rounded(value, digits)
