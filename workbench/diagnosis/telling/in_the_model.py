"""What the robot's own model has of a cause already: a model.toml that an earlier diagnosis wrote."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...campaign.problem import Problem
from ...effects import called
from ...effects.base import UNKNOWN, Effect
from ...effects.place import Where
from ...effects.records import is_mounted
from ...identification.fit import Fit
from ...identification.model import Model
from ...robot.kinematics import Array
from .headline import by_cause

UNDONE = 0.5  # of what the model's share does to the points is left at most: it was taken back


def has(final: Fit, effect: Effect) -> Array:
    """(p,) what the model has of this effect, in the same form and place; zero where it has none."""
    there = [values for other, values in final.model.known if other == effect]
    return np.sum([np.zeros(len(effect.params)), *there], axis=0)


@dataclass(frozen=True)
class InModel:
    """A finding's sentence, with what the model has of its cause at its place; taken_back: what was found
    undoes most of that."""

    sentence: str
    taken_back: bool = False


def beside_the_model(final: Fit, effects: Sequence[Effect], told: str) -> InModel:
    """A finding's sentence where the model has something of its cause at its place; as it is where not.

    effects: the finding's. told: its sentence, of the model's part and the found one together where they are
    of one form (`has`): its numbers count from the nominal robot on then.
    """
    had = [(e, values) for e, values in final.model.known if e.key == effects[0].key]
    if not had:
        return InModel(told)
    models = " ".join(filter(None, (effect.sentence(values) for effect, values in had))).removesuffix(".")
    before, after = _moves(final, effects[0].key)
    moves = f"The model's part moves the targets by {before:.3f} mm RMS, both together by {after:.3f} mm."
    if after < UNDONE * before:
        return InModel(
            f"No longer as the model has it (“{models}”): what was found takes that back. {moves} Look "
            "whether it was mended or replaced.",
            True,
        )
    one = any(effect == other for effect in effects for other, _ in had)
    counted = "That counts from the nominal robot on, of which the model" if one else "The model"
    return InModel(f"{told} {counted} has a part already (“{models}”); what was found comes on top. {moves}")


def _moves(final: Fit, key: tuple[str, Where]) -> tuple[float, float]:
    """RMS motion of the measured points [mm] by what the model has of a cause at its place, and by that and
    what was found together."""
    found = Model(final.model.problem).start(final.state.R, final.state.t, final.state.targets)
    state = replace(found, geometry=final.state.geometry)
    acting = [(effect, values) for effect, values in final.model.acting(final.state) if effect.key != key]
    known = [(effect, values) for effect, values in final.model.known if effect.key == key]

    def points(model: Model) -> Array:
        return model.predict(state)

    without = points(Model(final.model.problem, (), tuple(acting)))
    seen = final.model.problem.seen
    moved = (
        points(Model(final.model.problem, (), (*acting, *known))) - without,
        final.model.predict(final.state) - without,
    )
    before, after = (1e3 * float(np.sqrt(np.mean(np.sum(m[seen] ** 2, axis=-1)))) for m in moved)
    return before, after


def what_the_model_has(problem: Problem, known: Sequence[tuple[Effect, Array]]) -> str:
    """What an extended model has of effects, and which of them are of loads that the campaign does not have;
    nothing of a nominal robot."""
    named = by_cause(effect for effect, _ in known if effect.cause != UNKNOWN)
    nameless = dict.fromkeys(effect.label for effect, _ in known if effect.cause == UNKNOWN)
    loads = dict.fromkeys(
        f"{called(item.cause)} in {item.payload}"
        for item in problem.robot.effects
        if not is_mounted(item, problem)
    )
    said = [", ".join([*named, *nameless])] if known else []
    said += [f"not used, of another load than is carried here: {', '.join(loads)}"] if loads else []
    return "; ".join(said)
