"""Odds of accounts calibrated on worlds of their own: as right as they say, however few the draws."""

from __future__ import annotations

import numpy as np
import pytest

from workbench.studies.accounts import Account, Item, Judged, Round
from workbench.studies.calibration import Calibrated, calibrated, calibrated_table, stated_table

NUMBERS = 12
MIDDLES = {"near": 0.0, "far": 0.7, "apart": 3.0}


def judged(draws: int, middles: dict[str, float], heavy: bool = False) -> Judged:
    """Accounts that differ in the middle of what they print; heavy: with tails."""
    rng = np.random.default_rng(draws)
    made = {}
    for name, middle in middles.items():
        shape = (draws, NUMBERS)
        made[name] = middle + (rng.standard_t(3, size=shape) if heavy else rng.normal(size=shape))
    rounds = {name: Round(np.zeros((draws, 0)), rows, np.zeros(draws)) for name, rows in made.items()}
    accounts = [Account(name, name, {}, lambda v, r: {}) for name in middles]
    items = [Item(f"i{k}", f"i{k}", [0.0], 0.1, "nowhere") for k in range(NUMBERS)]
    return Judged(accounts, items, rounds, rounds, 0)


def all_items(one: Judged) -> list[str]:
    return [item.name for item in one.items]


def right_when_sure(found: Calibrated, temper: float) -> float:
    """Share of right ones among those stated with more than nine tenths."""
    *_, sure = found.stated(temper)
    return sure[3]


def test_many_draws_need_no_temper() -> None:
    found = calibrated(one := judged(4000, MIDDLES), all_items(one))
    assert found.temper == pytest.approx(1.0, abs=0.1)
    assert found.probabilities["near"] > 0.9
    assert found.probabilities["apart"] < 1e-6


@pytest.mark.parametrize("heavy", [False, True])
def test_few_draws_are_too_sure_and_calibrated_ones_are_not(heavy: bool) -> None:
    found = calibrated(one := judged(40, {"near": 0.0, "far": 0.25, "beside": -0.25}, heavy), all_items(one))
    assert found.temper > 1.5
    assert right_when_sure(found, 1.0) < 0.85
    calmer = found.stated(found.temper)
    stated = sum(count for _, high, count, _ in calmer if high > 0.9)
    assert stated <= sum(count for _, high, count, _ in found.stated(1.0) if high > 0.9) / 2
    assert max(found.probabilities.values()) < max(found.before.values())


def test_calibrated_probabilities_are_as_right_as_they_say() -> None:
    found = calibrated(one := judged(600, {"near": 0.0, "far": 0.3}, heavy=True), all_items(one))
    for low, high, count, right in found.stated(found.temper):
        if count > 60:
            assert low - 0.1 < right < high + 0.1


def test_groups_against_each_other() -> None:
    found = calibrated(one := judged(400, MIDDLES), all_items(one))
    assert found.against(["near", "far"], ["apart"]) > 0.999
    assert found.told(["near", "far"], ["apart"]) > 0.99
    assert found.against(["near"], ["far"]) == pytest.approx(1 - found.against(["far"], ["near"]))


def test_tables_say_what_was_right() -> None:
    found = calibrated(one := judged(100, MIDDLES), all_items(one)[:4])
    assert [row[0] for row in calibrated_table(found, one).rows] == list(MIDDLES)
    assert len(found.worlds) == 150
    assert sum(count for *_, count, _ in found.stated(1.0)) == 150
    assert len(stated_table(found).rows) == 5


def test_an_account_that_prints_nothing_is_not_judged() -> None:
    one = judged(40, MIDDLES)
    one.first["far"].predicted[5:] = np.nan
    with pytest.raises(ValueError, match="too few to judge by"):
        calibrated(one, all_items(one))
