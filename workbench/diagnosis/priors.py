"""What is taken for granted before the data speak: the only constants that decide what is named."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Priors:
    """cause: probability that a campaign shows some effect of one cause (shared by its places). any_shape:
    times that one is likelier which has no shape of its own, as every gear, screw, encoder and bearing errs
    somehow over its range (of the own errors of joints found on measured robots all were such). line: the
    same of a gear line of unknown order. free: of a function without a name, by what it is a function of.
    unstated: of a yield for which the model has no number, at each place. rarer: weight of a form with what
    only some machines have, over that without it. scales: sizes of an effect in usual sizes, with half-Cauchy
    weights 1/(1 + s²) per s; largest: beyond which no cause bends an arm by its loads, or excuses points that
    are far off; smallest: below which nothing is that is certain to be there: else a cause that looks like it
    would take its place after all. form: share of an effect that its form and its companions miss, on a real
    machine; directions: in how many of all what they miss lies, effectively; kin, yields: times over that log
    odds are too sure between a run-out and a map of one joint, and between two causes that yield to loads;
    shadow: size of a cause by loads, over that of what loads do without a name, from which it is no part of
    that.
    noise_dof: how well a stated noise is known (its sigma to 4 %). wrong_sign: probability that a number that
    physics holds to one sign has the other; other_side: the same of what goes with the side of approach,
    which campaigns may write down the other way round; pushes_back: of a spring, which would give against
    its load. present: least size, in its scale, of an effect that brings companions; companions: most that
    these are, in their prior sizes, over the effect in its own; itself: least share that a stand-in by itself
    takes off χ² of what it takes with them; nearly: share of these sizes in causes that are nearly true to
    their form. named: probability from which a cause is named;
    by_data: the same, were no other cause less likely before the data; listed: share of the probability that
    the cause and its rivals must cover, faintest_rival: probability below which a rival is not worth a word;
    absent: probability of nothing there from which a cause is not reported.
    joint_yields, tilt_yields: usual motion of a yield [rad] at the campaign's largest load; of a link that
    bends, the latter is the tilt of the line from its root to its end."""

    cause: float = 0.03
    any_shape: float = 2.0
    line: float = 0.02
    free: float = 0.01
    unstated: float = 0.2
    rarer: float = 0.3
    scales: tuple[float, ...] = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0)
    largest: float = 10.0
    smallest: float = 1.0
    form: float = 0.03
    directions: float = 4.0
    kin: float = 3.0
    yields: float = 2.0
    shadow: float = 2.0
    noise_dof: float = 300.0
    wrong_sign: float = 0.02
    other_side: float = 0.1
    pushes_back: float = 1e-4
    present: float = 0.3
    companions: float = 3.0
    itself: float = 0.03
    nearly: float = 0.2
    named: float = 0.95
    by_data: float = 0.8
    listed: float = 0.97
    absent: float = 0.2
    faintest_rival: float = 0.01
    joint_yields: float = 2e-4
    tilt_yields: float = 5e-5


PRIORS = Priors()


@contextmanager
def varied(**values: float) -> Iterator[None]:
    """Other values for some constants meanwhile, in this process: to see what each moves."""
    before = asdict(PRIORS)
    try:
        for name, value in values.items():
            object.__setattr__(PRIORS, name, value)
        yield
    finally:
        for name in values:
            object.__setattr__(PRIORS, name, before[name])
