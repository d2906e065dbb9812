"""Thousands of spoilt inputs: each is refused in words or answered; none fails, hangs or shows its insides.

`make fuzz` tries ten times as many and writes docs/robustness.md; `python tests/robustness/fuzz.py --case N`
does one of them again.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from cases import LONG, QUICK, seeds  # noqa: E402
from runner import run  # noqa: E402

CASES, CHUNKS, DIAGNOSED = 2000, 8, 12
WHOLE = {1083}  # is diagnosed to its end, which takes longer than its whole chunk: done with the last


@pytest.fixture(scope="module")
def sound(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    return seeds(tmp_path_factory.mktemp("sound"))


@pytest.mark.parametrize(
    "chunk", [pytest.param(n, marks=pytest.mark.slow) if n > 3 else n for n in range(CHUNKS)]
)
def test_spoilt_input_is_refused_in_words(tmp_path: Path, sound: dict[str, str], chunk: int) -> None:
    numbers = {*range(chunk, CASES, CHUNKS)} - WHOLE | (WHOLE if chunk == CHUNKS - 1 else set())
    ended = [run(number, sound, QUICK, tmp_path / "case") for number in sorted(numbers)]
    assert [(one.number, one.wrong, one.said) for one in ended if one.wrong] == []
    assert {one.status for one in ended} == {"0", "2"}


def test_spoilt_campaigns_are_diagnosed_or_refused(tmp_path: Path, sound: dict[str, str]) -> None:
    ended = [run(number, sound, LONG, tmp_path / "case") for number in range(DIAGNOSED)]
    assert [(one.number, one.wrong, one.said) for one in ended if one.wrong] == []
