"""Work on all cores: the same results in the same order, errors passed on, and no forks of forks."""

import os

import pytest

from workbench.diagnosis.weighing import side_by_side as module
from workbench.diagnosis.weighing.side_by_side import begun, side_by_side
from workbench.files.faults import Fault, InputError


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    monkeypatch.setattr(module, "cores", lambda: 2)


def test_results_come_in_order_from_other_processes():
    here = os.getpid()
    found = side_by_side(lambda item: (item**2, os.getpid()), range(5))
    assert [square for square, _ in found] == [0, 1, 4, 9, 16]
    assert here not in {process for _, process in found}
    assert side_by_side(lambda item: os.getpid(), [1]) == [here]  # one alone is worth no process


def test_what_is_begun_goes_on_while_something_else_is_done():
    with begun(lambda item: (item, os.getpid()), range(3)) as done:
        here = os.getpid()
        found = done()
    assert [item for item, _ in found] == [0, 1, 2]
    assert here not in {process for _, process in found}
    with begun(lambda item: item, range(3)):
        pass  # nobody asks: what has not begun does not begin


def test_one_core_does_it_here(monkeypatch):
    monkeypatch.setattr(module, "cores", lambda: 1)
    assert side_by_side(lambda item: os.getpid(), range(3)) == [os.getpid()] * 3


def test_a_fork_forks_no_more():
    def work(item):
        return os.getpid(), side_by_side(lambda _: os.getpid(), range(2))

    for own, inner in side_by_side(work, range(2)):
        assert inner == [own, own]


def test_an_error_is_that_of_the_work():
    def work(item):
        raise InputError(Fault("campaign.toml", f"item {item} is wrong"))

    with pytest.raises(InputError, match="item 0 is wrong"):
        side_by_side(work, range(2))
    assert side_by_side(lambda item: item, range(2)) == [0, 1]
