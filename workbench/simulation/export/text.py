"""How numbers and headers are written."""

from __future__ import annotations

from collections.abc import Iterable

from ...robot.kinematics import Array


def number(value: float) -> str:
    """As many digits as bring the same float64 back."""
    return repr(float(value) + 0.0).removesuffix(".0")  # + 0.0: no -0


def numbers(values: Iterable[float] | Array) -> str:
    """Several, a space between."""
    return " ".join(number(value) for value in values)


def xml_comment(lines: list[str]) -> str:
    """Lines as an XML comment, which must not hold two hyphens in a row."""
    return "<!--\n" + "\n".join(f"  {line.replace('--', '- -')}" for line in lines) + "\n-->"


def commented(lines: list[str]) -> str:
    """Lines each behind a #."""
    return "".join(f"# {line}".rstrip() + "\n" for line in lines)
