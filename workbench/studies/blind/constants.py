"""What each constant of the diagnosis moves: the same cases, judged again with one constant changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from ...diagnosis.priors import PRIORS, varied
from ...diagnosis.run import diagnose
from ..case_study import Record
from .cases import Case, draw_case
from .score import judged

SIZES = (
    "cause",
    "any_shape",
    "line",
    "free",
    "largest",
    "form",
    "kin",
    "yields",
    "shadow",
    "noise_dof",
    "wrong_sign",
    "other_side",
    "pushes_back",
    "rarer",
    "present",
    "companions",
    "itself",
    "nearly",
    "joint_yields",
    "tilt_yields",
)
SHARES = ("unstated", "named", "listed", "absent", "faintest_rival")
ERRORS: dict[str, Callable[[Record], bool]] = {
    "truth not among what is reported": lambda said: said["reported"] is False,
    "first name wrong": lambda said: said["first_right"] is False,
    "a wrong name": lambda said: said["wrong_name"],
    "not named": lambda said: bool(said["first_right"]) and said["found"][0]["status"] != "named",
    "something beside the truth": lambda said: said["reported"] is not None and not said["only_right"],
    "unknown structure not told": lambda said: said["hidden_unknown"] and not said["unknown"],
    "alarm without a cause": lambda said: bool(said["false_alarm"]),
}


@dataclass(frozen=True)
class Moved:
    """Errors among the cases, by kind, with one constant at a value (its name empty: as it is)."""

    constant: str
    value: float
    errors: dict[str, int]


def moved(keys: Sequence[str], seed: int) -> Iterator[Moved]:
    """Errors with every constant as it is, then with each three times larger and smaller; probabilities by
    their odds. keys: of the blind study's cases."""
    with TemporaryDirectory() as folder:
        cases = [draw_case(key, seed, Path(folder) / str(i)) for i, key in enumerate(keys)]
        yield Moved("", float("nan"), _errors(cases))
        for name in SIZES + SHARES:
            for change in (3.0, 1 / 3.0):
                value = changed(name, change)
                with varied(**{name: value}):
                    yield Moved(name, value, _errors(cases))


def changed(name: str, factor: float) -> float:
    """A constant so many times larger; a probability by its odds."""
    value = float(getattr(PRIORS, name))
    if name not in SHARES:
        return value * factor
    odds = value / (1 - value) * factor
    return odds / (1 + odds)


def _errors(cases: Sequence[Case]) -> dict[str, int]:
    said = [_said(case) for case in cases]
    return {name: sum(map(wrong, said)) for name, wrong in ERRORS.items()}


def _said(case: Case) -> Record:
    return {
        **judged(case, diagnose(case.campaign, case.judge)),
        "hidden_unknown": case.unknown_mm is not None,
    }
