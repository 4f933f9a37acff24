"""What is asked of a user's function before a compiler sees it: none says it as well, and some do not come back."""

from __future__ import annotations

import re

_ASIDE = re.compile(r"//(?:[^\n]|\\\n)*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'", re.S)
_DEFINITION = re.compile(r"\b(\w+)\s*\([^(){};]*\)\s*\{")
_NO_CALLS = {"if", "for", "while", "switch"}


def _bodies(code: str) -> dict[str, str]:
    """Function name -> what stands between its braces, of code without comments and strings."""
    bodies: dict[str, str] = {}
    at = 0
    while found := _DEFINITION.search(code, at):
        depth, at = 1, found.end()
        while at < len(code) and depth:
            depth += {"{": 1, "}": -1}.get(code[at], 0)
            at += 1
        bodies[found[1]] = bodies.get(found[1], "") + code[found.end() : at]
    return bodies


def _called(bodies: dict[str, str]) -> dict[str, set[str]]:
    """Function name -> those of the same text that it calls, directly or not."""
    calls = {
        name: {word for word in re.findall(r"\b(\w+)\s*\(", body) if word in bodies} - _NO_CALLS
        for name, body in bodies.items()
    }
    for _ in calls:
        calls = {name: found.union(*(calls[one] for one in found)) for name, found in calls.items()}
    return calls


def check_text(argument: str, text: str, signature: str) -> str:
    """`text` itself.

    Args:
        argument: that it came by; errors name it.
        text: OpenCL C.
        signature: of the function that it must have, such as "float warp(const float t, const int axis)".

    Raises:
        ValueError: it has no such function; one that calls itself, which OpenCL C forbids and which ends some
            compilers' process; or what is no text.
    """
    if any(c == "\0" or "\ud800" <= c <= "\udfff" for c in text):
        raise ValueError(f"{argument}: expected OpenCL C, got characters that no text has")
    bodies = _bodies(_ASIDE.sub(" ", text))
    if signature.partition("(")[0].split()[-1] not in bodies:
        got = "none" if text.strip() else "no text"
        raise ValueError(f"{argument}: expected {signature}, got {got}")
    for name, called in _called(bodies).items():
        if name in called:
            raise ValueError(f"{argument}: expected no recursion, got {name}, which calls itself")
    return text
