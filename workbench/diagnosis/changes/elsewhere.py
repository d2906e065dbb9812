"""In words: what is not the robot and is not as it was."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ..telling.headline import listed
from .covered import hardly
from .found import Apart, TargetMoved, TargetsMoved
from .system import System
from .words import with_std

OTHER_NOISE = 1.2  # ratio of two noises from which they are said to differ
CHANCE = 1e-4  # probability of as much by chance below which they do


def beside_the_robot(system: System, beside: Sequence[Apart]) -> list[str]:
    """What is not the robot and is not as it was. How closely a model that does not fit goes through postures
    of one campaign alone is neither."""
    out, first = [], beside[0]
    for k, one in enumerate(beside[1:], 1):
        at = f" ({one.label})" if len(beside) > 2 else ""
        out += [f"{text}{at}" for text in _elsewhere(one.moves)]
        if not (system.misfit and (hardly(system, 0, [k]) or hardly(system, k, [0]))):
            out += [f"{text}{at}" for text in _scatters(one, first)]
    return out


def _elsewhere(targets: TargetsMoved) -> Iterator[str]:
    """Which targets sit elsewhere on the robot, and why that may be."""
    if targets.restated:
        yield f"{_these(targets, targets.restated)}, {as_stated(targets.restated)}"
    for one in targets.together:
        own = [target for target in targets.each if target.target in one.targets]
        others = [target.target for target in targets.each if not target.moved and target not in own]
        still = f" (not {listed(others)})" if others else ""
        if one.joint is None:
            who = f"the targets on the {one.link}, as one body,"
            yield f"{_sit(own, who)}{still}: {_why(own)}"
        else:
            yield (
                f"the targets on the {one.link} turned together about {one.joint} by "
                f"{with_std(one.turn_mrad, one.turn_std_mrad)} mrad{still}: its zero moved, or what carries "
                "them; if they sit where they did, state them with `fixed = true` to tell"
            )
    if targets.alone:
        some = len(targets.alone) < len(targets.each)
        yield f"{_these(targets, targets.alone)}: {_why(targets.alone, some)}"


def as_stated(moved: Sequence[TargetMoved]) -> str:
    """That targets moved as the campaigns state it, and to how much where the data tell."""
    off = max((target.off_stated_mm for target in moved if not target.as_stated), default=0.0)
    return f"as stated to {off:.2g} mm" if off else "as stated"


def _why(moved: Sequence[TargetMoved], some: bool = False) -> str:
    """Why targets may sit elsewhere: all that there are, or only some of them."""
    several = len(moved) > 1
    what = "tool or reflectors were"
    if some:
        what = "their reflectors were" if several else "its reflector or nest was"
    warmer = f", or {'are' if several or not some else 'is'} warmer"
    return f"{what} mounted anew{warmer if all(target.may_be_warm for target in moved) else ''}"


def _these(targets: TargetsMoved, moved: Sequence[TargetMoved]) -> str:
    """That some targets sit elsewhere, by their names where others do not."""
    if len(moved) == len(targets.each):
        return _sit(moved)
    still = [target.target for target in targets.each if not target.moved]
    also = f" (not {listed(still)})" if still else ""
    return f"{_sit(moved, listed([target.target for target in moved]))}{also}"


def _sit(moved: Sequence[TargetMoved], who: str = "the targets") -> str:
    """That targets sit elsewhere, and by how much the farthest of them."""
    by = max(moved, key=lambda target: float(np.linalg.norm(target.by_mm)))
    size, std = float(np.linalg.norm(by.by_mm)), float(np.linalg.norm(by.std_mm))
    verb = "sits" if len(moved) == 1 else "sit"
    return f"{who} {verb} elsewhere by {with_std(size, std)} mm"


def _scatters(one: Apart, first: Apart) -> Iterator[str]:
    """Whether the points scatter otherwise than at the first campaign, and whose that is: the instrument's
    where its noise as known says so too."""
    known, now = one.sigma_mm / first.sigma_mm, one.scatter
    if now.p_value > CHANCE or max(now.times, 1 / now.times) < OTHER_NOISE:
        return
    before = with_std(first.scatter.sigma_mm, first.scatter.std_mm)
    text = f"the points scatter {with_std(now.sigma_mm, now.std_mm)} instead of {before} mm per axis"
    if max(now.times / known, known / now.times) < OTHER_NOISE and one.source != "residual":
        shown = one.source != first.source
        says = "repeats or distances between targets show" if shown else "the instrument's noise says"
        yield f"{text}, as {says}"
    elif now.times > 1:
        yield f"{text}: the robot repeats worse, or the instrument measures worse than its noise says"
    else:
        yield f"{text}: the robot repeats better, or the instrument measures better than its noise says"
