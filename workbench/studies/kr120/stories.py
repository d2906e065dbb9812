"""The accounts of Table I: what may have made it, each with its free values.

All share what nobody knows of the measurement: the plan, the gears, the noise, the gas, and what “CI” means.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from workbench import Account, Array, Item, gas_spring

from .assumed import ARCMIN, OWN, common
from .plans import ANGLES, JOINT, PairPlan, compliances, plan, robot, spring
from .printed import HALF_1, ROUNDED_1, ROUNDED_HALF_1, SIX, TABLE_1
from .world import World, estimated, soft_zone

Values = Mapping[str, float]
Tell = Callable[[World, Values, PairPlan, np.random.Generator], World]
LEVEL_STEP = 0.3, 3.0  # of a gear's compliance


def sizes(half: Array) -> Array:
    """(2,) of half widths (11,) as Table I lists them: the geometric mean of joint 2's, and joint 3's."""
    return np.array([np.exp(np.log(half[SIX]).mean()), half[7]])


STATED = np.hypot(ROUNDED_1, HALF_1)
"""[rad/(N·m)] rounding, and the stated interval read as one σ: the reading that is kindest to every
account."""

ITEMS = (
    Item("joint_2", "the six k2", TABLE_1[SIX], STATED[SIX], "Table I", ratio=True),
    Item("intervals", "intervals", sizes(HALF_1), ROUNDED_HALF_1, "Table I, CI", ratio=True),
)
"""The compliances of the other joints are met by every account, by the choice of gears; their intervals hang
on levers of the tool that are not printed."""


def machine(v: Values) -> World:
    """The machine that all accounts start from."""
    return World(compliances(robot()), charge=v["charge"], sigma=1e-6 * v["noise"])


def levelled(tell: Tell, v: Values, where: PairPlan, seed: int) -> World:
    """The account's machine, with gears such that it would print, without noise, Table I's k1 and k3 to k6
    and the mean of its k2: how stiff the gears are says nothing for or against an account."""
    world = machine(v)
    printed = mean_of_six(TABLE_1)
    told = replace(tell(world, v, where, np.random.default_rng(seed)), sigma=0.0)
    found = mean_of_six(estimated(where, told, np.random.default_rng(0)).k)
    world = replace(world, k=world.k * np.clip(printed / found, *LEVEL_STEP))
    return tell(world, v, where, np.random.default_rng(seed))


def mean_of_six(k: Array) -> Array:
    """(6,) of compliances (11,) as Table I lists them: joint 2's as the mean of six."""
    return np.concatenate([k[:1], [k[SIX].mean()], k[7:]])


def predicted(tell: Tell, values: Values, rng: np.random.Generator) -> dict[str, Array]:
    """What the paper would have printed of a machine."""
    where = plan(int(values["plan"]))
    world = levelled(tell, values, where, int(rng.integers(2**32)))
    found = estimated(where, world, rng)
    noise = np.sqrt(2) * 1e-6 * values["noise"] if values["known"] > 0.5 else found.residual
    half = (1.96 if values["reading"] > 0.5 else 1.0) * noise * found.cofactor
    return {
        "joint_2": found.k[SIX],
        "intervals": sizes(half),
    }


def as_modelled(world: World, v: Values, where: PairPlan, rng: np.random.Generator) -> World:
    """The gas spring does what a gas spring of its size does; its bending of K2 is added by eq. (7)."""
    return replace(world, group_k2=_with_spring(world, where, v["charge"]))


def any_spring(world: World, v: Values, where: PairPlan, rng: np.random.Generator) -> World:
    """A gas spring as strong as it takes, its bias torque left out: no arm could hold it."""
    return replace(world, group_k2=_with_spring(world, where, v["strength"], v["length"]))


def noisier(world: World, v: Values, where: PairPlan, rng: np.random.Generator) -> World:
    """Readings scatter more than a tracker's: markers put on again, an arm that is not at rest."""
    return replace(world, sigma=1e-6 * v["scatter"])


def soft(world: World, v: Values, where: PairPlan, rng: np.random.Generator) -> World:
    """Joint 2's gear is soft about zero torque."""
    return replace(world, law=soft_zone(v["width"] * ARCMIN, v["torque"]))


def friction(world: World, v: Values, where: PairPlan, rng: np.random.Generator) -> World:
    """Gears stick: the load has to overcome friction, from whichever side the joint had come."""
    rated = np.array([joint.effort for joint in robot().joints])
    if v["mixed"] > 0.5:
        side = rng.uniform(-1, 1, (where.count, 6))
    else:
        side = rng.choice([-1.0, 1.0], (ANGLES, 6))[where.group]
    return replace(world, friction=v["friction"] * rated, side=side)


def yielding(world: World, v: Values, where: PairPlan, rng: np.random.Generator) -> World:
    """Bearings tilt, links bend and the floor gives way; the estimate knows the axes alone."""
    return replace(
        world,
        bearing=1e-9 * np.array([v["bearing_1"], v["bearing_2"], v["bearing_3"]]),
        foundation=1e-9 * v["foundation"],
        bending=1e-9 * np.array([v["bending_2"], v["bending_3"]]),
    )


def elsewhere(world: World, v: Values, where: PairPlan, rng: np.random.Generator) -> World:
    """The load hangs elsewhere than told, and weighs something else."""
    hook = 1e-3 * v["off"] * rng.normal(size=3)
    return replace(world, hook=hook, weight=v["weight"])


def frames_off(world: World, v: Values, where: PairPlan, rng: np.random.Generator) -> World:
    """Markers are elsewhere than told, and the instrument's frame is turned."""
    markers, turn = 1e-3 * v["place"] * rng.normal(size=(3, 3)), np.radians(v["turn"]) * rng.normal(size=3)
    return replace(world, markers=markers, turn=turn)


def sessions(world: World, v: Values, where: PairPlan, rng: np.random.Generator) -> World:
    """One session per angle: between before and after, all of it creeps by the same amount."""
    return replace(world, drift=1e-6 * v["creep"] * rng.normal(size=(ANGLES, 3)))


def nameless(world: World, v: Values, where: PairPlan, rng: np.random.Generator) -> World:
    """Joint 2's compliance differs from angle to angle, at random, for no reason given."""
    return replace(world, group_k2=world.k[JOINT] * np.exp(v["spread"] * rng.normal(size=ANGLES)))


def accounts(pool: int) -> list[Account]:
    """All of them, the authors' own first."""
    return [
        Account(name, words, common(pool) | priors, partial(predicted, TELL[name]))
        for name, (words, priors) in OWN.items()
    ]


TELL: dict[str, Tell] = {
    "gas": as_modelled,
    "strong": any_spring,
    "noise": noisier,
    "soft": soft,
    "friction": friction,
    "yielding": yielding,
    "elsewhere": elsewhere,
    "frames": frames_off,
    "sessions": sessions,
    "nameless": nameless,
}
"""[-] account → the machine it tells of."""


def _with_spring(world: World, where: PairPlan, strength: float, length: float | None = None) -> Array:
    """(6,) compliance of joint 2 at the plan's angles with the gas spring beside its gear, eq. (7).
    length: of the gas over its stroke."""
    triangle, law = spring(where.problem)
    data = law.data
    s = triangle.stretch(where.angles)[0]
    if length is not None:
        stroke = float(s.max()) - (data.reference or 0.0)
        data = data.model_copy(update={"gas_length": length * stroke})
    added = gas_spring.added_stiffness(triangle, replace(law, data=data, charge=strength), where.angles)
    stiffness = 1 / world.k[JOINT] + added
    return np.asarray(np.where(stiffness > 0, 1 / np.where(stiffness > 0, stiffness, 1.0), np.nan))
