"""Accounts judged by printed items, where the odds can be computed by hand; draws, tornado, claims."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from workbench import (
    Account,
    Claim,
    Item,
    Judged,
    Prior,
    StudyRun,
    checked,
    draw_many,
    judge,
    redrawn,
    tornado,
)
from workbench.simulation import processes
from workbench.studies.account_tables import accounts_table, needs_table, odds_figure, odds_table
from workbench.studies.accounts import Standing
from workbench.studies.evidence import evidence

PRINTED = np.array([0.5, -0.3])
SD = 0.1
PAIR = Item("pair", "a pair", PRINTED, SD, "Table 1")
SUM = Item("gain", "a gain", 3.0, 0.3, "Table 2", ratio=True)


def spread_out(
    values: Mapping[str, float], rng: np.random.Generator, scale: float = 1.0, gain: float = 0.0
) -> dict[str, object]:
    """Two independent Gaussians about the same free middle; a gain whose logarithm is one too."""
    return {
        "pair": values.get("middle", 0.0) + scale * rng.normal(size=2),
        "gain": np.exp(gain + 0.5 * rng.normal()),
    }


NEAR = Account("near", "near", {}, partial(spread_out, gain=1.0))
WIDE = Account("wide", "wide", {}, partial(spread_out, scale=4.0, gain=2.3))
MOVED = Account(
    "moved", "moved", {"middle": Prior("middle", -3.0, 3.0)}, partial(spread_out, scale=0.2, gain=1.0)
)


@pytest.fixture(scope="module")
def judged(tmp_path_factory: pytest.TempPathFactory) -> Judged:
    run = StudyRun(tmp_path_factory.mktemp("judged"), seed=3, workers=1)
    return judge([NEAR, WIDE, MOVED], [PAIR, SUM], 2000, run, chunk=1000)


def by_hand(scale: float, gain: float) -> float:
    """log₁₀ of the density at the print: normal for the pair, log-normal (as compared) for the gain."""
    pair = stats.norm.logpdf(PRINTED, 0.0, np.hypot(scale, SD)).sum()
    return float(pair + stats.norm.logpdf(np.log(3.0), gain, np.hypot(0.5, 0.1))) / np.log(10)


def test_evidence_is_that_of_the_gaussians(judged: Judged) -> None:
    for name, scale, gain in (("near", 1.0, 1.0), ("wide", 4.0, 2.3)):
        found = judged.evidence[name]
        assert found.log10 == pytest.approx(by_hand(scale, gain), abs=3 * found.error)
        assert 0.0 < found.error < 0.5
    odds = 10 ** (by_hand(1.0, 1.0) - by_hand(4.0, 2.3))
    p = judged.probabilities()
    assert p["near"] / p["wide"] == pytest.approx(odds, rel=0.35)
    assert sum(p.values()) == pytest.approx(1)


def test_a_free_value_costs_its_range_and_is_found(judged: Judged) -> None:
    """Pair about one middle with a known scatter: the posterior of the middle is Gaussian."""
    sd = np.hypot(0.2, SD)
    low, middle, high = judged.needed("moved", "middle")
    assert middle == pytest.approx(PRINTED.mean(), abs=0.1)
    assert (high - low) / 2 == pytest.approx(1.645 * sd / np.sqrt(2), rel=0.3)
    assert not judged.standing("moved", "pair").reproduced  # the two lie too far apart for one middle
    apart = stats.norm.logpdf(np.ptp(PRINTED), 0, sd * np.sqrt(2))  # the only thing that the account fixes
    alone = (apart + np.log(1 / 6)) / np.log(10)  # a density of 1/6 per middle
    gain = stats.norm.logpdf(np.log(3.0), 1.0, np.hypot(0.5, 0.1)) / np.log(10)
    found = judged.evidence["moved"]
    assert found.log10 == pytest.approx(alone + gain, abs=3 * found.error)
    assert found.error < 0.3


def test_standings_are_shares_of_draws(judged: Judged) -> None:
    stands = judged.standing("near", "pair")
    far = (PRINTED**2).sum() / (1 + SD**2)
    assert stands.share == pytest.approx(stats.chi2.sf(far, 2), abs=0.03)
    assert stands.distance == pytest.approx(np.sqrt(far / 2), abs=0.05)
    assert stands.reproduced
    gone = judged.standing("wide", "gain")
    assert gone.share == pytest.approx(2 * stats.norm.cdf((np.log(3) - 2.3) / np.hypot(0.5, 0.1)), abs=0.015)
    assert not gone.reproduced


def test_an_account_is_excluded_by_odds_beyond_their_error(judged: Judged) -> None:
    behind, error = judged.odds("moved", over="near")
    assert judged.best == "near"
    assert (behind, error) == judged.odds("moved")
    assert behind == -judged.odds("near", over="moved")[0]
    assert judged.excluded("moved", 10 ** (0.9 * (-behind - error)))
    assert not judged.excluded("moved", 10 ** (1.1 * (-behind - error)))
    assert not judged.excluded("near", 2.0)


@pytest.mark.parametrize(("rarely", "said"), [(0.0, "reproduces"), (0.95, "fewer than 10 draws print it")])
def test_too_few_draws_that_print_are_no_miss(tmp_path: Path, rarely: float, said: str) -> None:
    account = Account("some", "some", {}, partial(sometimes, rarely=rarely))
    judged = judge([account], [replace(SUM, sd=1.0)], 100, StudyRun(tmp_path, workers=1))
    assert 0 < np.isfinite(judged.first["some"].predicted).sum() < 10 or rarely == 0
    [[_, alone, together]] = accounts_table(judged).rows
    assert alone.startswith(said)
    assert together.startswith(said)


def sometimes(_: Mapping[str, float], rng: np.random.Generator, rarely: float) -> dict[str, object]:
    return {"gain": np.nan if rng.random() < rarely else np.exp(1.0 + 0.5 * rng.normal())}


def test_many_numbers_and_few_draws_make_a_gaussian_likelihood(tmp_path: Path) -> None:
    item = Item("row", "a row", np.full(12, 0.3), 0.1, "Table 3")
    account = Account("row", "row", {}, row)
    found = judge([account], [item], 150, StudyRun(tmp_path, workers=1)).evidence["row"]
    by_hand = 12 * stats.norm.logpdf(0.3, 0, np.hypot(1, 0.1)) / np.log(10)
    assert found.log10 == pytest.approx(by_hand, abs=0.5)


def row(_: Mapping[str, float], rng: np.random.Generator) -> dict[str, object]:
    return {"row": rng.normal(size=12)}


def test_processes_and_a_stopped_run_change_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spawn_pool = processes.spawn_pool
    monkeypatch.setattr(processes, "spawn_pool", lambda _: spawn_pool(1))
    run = StudyRun(tmp_path, seed=1, workers=1)
    alone = judge([NEAR, MOVED], [PAIR, SUM], 40, run, chunk=20)
    again = judge(
        [broken("near"), broken("moved", MOVED)], [PAIR, SUM], 40, replace(run, resume=True), chunk=20
    )
    two = judge([NEAR], [PAIR, SUM], 40, replace(run, workers=2), chunk=20)
    np.testing.assert_array_equal(alone.last["near"].predicted, two.last["near"].predicted)
    np.testing.assert_array_equal(alone.last["moved"].predicted, again.last["moved"].predicted)
    with pytest.raises(RuntimeError, match="ZeroDivisionError"):
        judge([broken("near")], [PAIR, SUM], 40, run)


def broken(name: str, like: Account = NEAR) -> Account:
    return Account(name, name, like.priors, fails)


def fails(*_: object) -> dict[str, object]:
    raise ZeroDivisionError


def test_tables_and_figure_say_what_was_judged(judged: Judged) -> None:
    table = accounts_table(judged)
    assert table.head == ("Account", "a pair", "a gain", "All together")
    cells = {row[0]: row[1:] for row in table.rows}
    assert cells["near"][0].startswith("reproduces (")
    assert cells["wide"][1].startswith("misses by 2.")
    odds = {row[0]: row for row in odds_table(judged).rows}
    assert odds["moved"][1] == "1"
    assert odds["near"][2].startswith("0.0 ±")
    [[account, value, allowed, needed, _]] = needs_table(judged).rows
    assert needed.startswith("0.")
    assert (account, value, allowed) == ("moved", "middle", "−3 … 3")
    assert "near" in odds_figure(judged).title
    assert "more" not in odds_figure(judged).title


def test_of_accounts_within_the_error_of_the_odds_those_count_that_reproduce_the_print(
    judged: Judged, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Judged, "excluded", lambda *_: False)
    monkeypatch.setattr(Judged, "standing", lambda _, name: Standing(0.5 * (name != "wide"), 1.0))
    title = odds_figure(judged).title
    assert title.endswith("has the highest odds; 1 more that reproduces the print is within their error")


def headline(values: Mapping[str, float], seed: int) -> dict[str, float]:
    noise = np.random.default_rng(seed).normal(scale=0.1)
    return {"error": 3 * values["a"] + values["b"] + noise, "constant": 1.0}


PRIORS = {"b": Prior("the small one", 0.0, 1.0), "a": Prior("the large one", 1.0, 2.0, "mm")}


def test_a_headline_over_draws_and_what_carries_it(tmp_path: Path) -> None:
    run = StudyRun(tmp_path, seed=2, workers=1)
    draws = draw_many(headline, PRIORS, 200, run)
    low, middle, high = draws.range("error")
    assert middle == pytest.approx(5.0, abs=0.1)
    assert draws.by_name()["error_p95"] == high > middle > low
    carries = draws.carries("error")
    assert carries["a"] == pytest.approx(0.89, abs=0.05)
    assert carries["b"] == pytest.approx(0.1, abs=0.05)
    assert draws.carries("constant") == {"b": 0.0, "a": 0.0}
    assert np.subtract(*draws.ends("error", "a")) == pytest.approx(-2.0, abs=0.2)  # thirds lie 2/3 apart
    assert draws.middle == {"error": middle, "constant": 1.0}
    some = draws.only(draws.values["a"] > 1.5)
    assert (some.count, some.values["a"].min() > 1.5) == (100, True)
    assert some.range("error")[0] > low
    assert draws.carrier("constant") is None
    assert draws.only(np.arange(200) < 4).carrier("error") is None
    figure = tornado(draws, "error", "carried", "error, mm")
    assert figure.title.startswith("Error: 5.0 (")
    assert "the large one (8" in figure.title or "the large one (9" in figure.title
    assert figure.alt.index("the large one") < figure.alt.index("the small one")  # widest first


def test_a_claim_holds_in_so_many_draws(tmp_path: Path) -> None:
    draws = draw_many(headline, PRIORS, 100, StudyRun(tmp_path, workers=1))
    claims = [
        Claim("positive", "above zero", lambda n: n["error"] > 0),
        Claim("large", "above its middle", lambda n: n["error"] > 5.0),
        Claim("run", "of the run alone", lambda n: n["own"] == 7.0),
    ]
    stand = checked(claims, {"error": 6.0, "own": 7.0}, draws)
    assert stand["positive"].stands
    assert stand["run"].stands
    assert stand["large"].here
    assert not stand["large"].stands
    assert stand["large"].share == pytest.approx(0.5, abs=0.05)
    assert checked(claims, {"error": 6.0, "own": 6.0})["large"].stands  # no draws: the run itself


def test_odds_of_runs_more_scatter_as_their_error_says(judged: Judged) -> None:
    """Drawn again out of themselves: about the run's own, as wide as another run's would be."""

    def numbers(one: Judged) -> dict[str, float]:
        seen.append(one)
        return {"odds": one.odds("wide", "moved")[0], "left": float(one.excluded("wide", 100.0))}

    seen: list[Judged] = []
    found = redrawn(judged, numbers, 30)
    own, error = judged.odds("wide", "moved")
    assert found.count == 30
    assert abs(np.mean(found.numbers["odds"]) - own) < error
    assert 0.1 * error < np.std(found.numbers["odds"]) < 1.5 * error
    assert np.array_equal(found.numbers["odds"], redrawn(judged, numbers, 30).numbers["odds"])
    taken = seen[0].first["wide"].predicted[:, 0]
    every = judged.first["wide"].predicted[:, 0]
    assert set(taken[::2]) <= set(every[::2])  # judged by one half and tried on the other
    assert set(taken[1::2]) <= set(every[1::2])
    assert len(set(taken)) < 0.7 * len(every)
    claim = Claim("moved", "wide has less than moved", lambda n: n["odds"] < 0)
    assert checked([claim], {"odds": own}, found)["moved"].draws == 30


@pytest.mark.parametrize("ends", [(1.0, 1.0), (2.0, 1.0), (0.0, 1.0)])
def test_a_prior_that_is_no_range_is_refused(ends: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="no range"):
        Prior("mass", *ends, log=True)


def test_a_logarithmic_prior_has_its_middle_between() -> None:
    prior = Prior("mass", 1.0, 100.0, "kg", log=True)
    assert prior.middle == pytest.approx(10.0)
    assert prior.range == "1 … 100 kg, log-uniform"
    assert Prior("stiffness", 1e6, 2e7, "N·m/rad", log=True).range == "1 … 20 MN·m/rad, log-uniform"
    assert Prior("place", -0.2, 0.2, "m").range == "−200 … 200 mm"


def test_draws_are_led_to_a_print_far_from_their_middle(tmp_path: Path) -> None:
    """A scale that has to be large, against a print that says it is small: known by integration."""
    items = [Item("size", "size", 1.5, 0.1, "here"), Item("scale", "scale", 0.2, 0.06, "there", ratio=True)]
    account = Account("scaled", "scaled", {"scale": Prior("scale", 0.1, 100.0, log=True)}, scaled)
    judged = judge([account], items, 1000, StudyRun(tmp_path, workers=1), chunk=1000)
    found = judged.evidence["scaled"]
    logs = np.linspace(np.log(0.1), np.log(100.0), 20001)
    each = stats.norm.pdf(1.5, 0, np.hypot(np.exp(logs), 0.1)) * stats.norm.pdf(np.log(0.2), logs, 0.3)
    by_hand = np.log10(np.trapezoid(each, logs) / np.log(1000))
    assert found.log10 == pytest.approx(by_hand, abs=2 * found.error)
    assert found.error < 2
    value, sd = judged.target
    before = evidence(judged.first["scaled"].predicted, value, sd).log10
    assert abs(found.log10 - by_hand) < abs(before - by_hand) - 1  # what the rounds are for


def scaled(values: Mapping[str, float], rng: np.random.Generator) -> dict[str, object]:
    return {"size": values["scale"] * rng.normal(), "scale": values["scale"]}
