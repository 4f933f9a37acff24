"""What is asked of a user's displacement before a compiler sees it."""

from __future__ import annotations

from lodbench.kernels.function_text import check_text

SIGNATURE = "float displace(float3 position, float3 normal, float2 uv, float time)"


def check_function(text: str) -> str:
    """`text` itself.

    Raises:
        ValueError: see `check_text`.
    """
    return check_text("function", text, SIGNATURE)
