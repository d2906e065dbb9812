"""Then and now: what changed between campaigns of one robot, and what did not.

Every campaign is prepared and searched by itself, keeps its own frames, targets and noise, and is linearised
where its own robot is. Geometry and the effects that any of them shows are common to all; each number of
geometry and of the causes may differ between occasions, and competes for that with the others and with causes
that all occasions have (`sets`), so that a change is named by its probability.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ...campaign import Campaign, load_campaign
from ...campaign.other_tools import with_tools_as_loads
from ...files.faults import Fault, InputError
from ..candidates import testable
from ..prepared import Progress
from ..priors import PRIORS
from ..telling.headline import listed
from .covered import hardly, inside
from .decision import Decided, decide
from .elsewhere import beside_the_robot
from .findings import changes_of, hidden_zeros, loads_off, repeats, still_joints, tracks, unseen
from .frames import apart
from .occasions import occasions_of
from .result import Comparison
from .sensitivity import nominal_mm, unchanged, within_mm
from .system import System, relinearised
from .words import headline


def compare(
    campaigns: Sequence[Campaign | str | Path],
    progress: Progress = lambda _: None,
    known: Sequence[str] = (),
) -> Comparison:
    """What changed between campaigns of one robot, in the order of time.

    campaigns: two or more, as loaded, or the paths of their campaign.toml. progress: is told each step in
    words. known: facts of all of them beside those of `[known]`, as `--known` takes them. Raises `InputError`
    where they are not of one robot, or the data unusable.

    >>> import numpy as np
    >>> from workbench import Truth, compare, load_robot, planned, random_poses, simulate
    >>> robot = load_robot("cylindrical")
    >>> bent = np.zeros((5, 6))
    >>> bent[2, 3] = 5e-4  # the axis of joint_2 leans by half a milliradian on link_1
    >>> plans = [planned(robot, random_poses(robot, 25, np.random.default_rng(k))) for k in (1, 2)]
    >>> truths = [Truth(sigma=2e-5), Truth(sigma=2e-5, geometry=bent)]
    >>> comparison = compare([simulate(p, t, seed=k) for k, (p, t) in enumerate(zip(plans, truths))])
    >>> comparison.changed, [(c.cause, c.where.joint) for c in comparison.changes]
    (True, [('geometry', 'joint_2')])
    """
    if len(campaigns) < 2:
        raise InputError(Fault("compare", "one campaign alone", "name two or more of one robot"))
    loaded = [one if isinstance(one, Campaign) else load_campaign(one) for one in campaigns]
    loaded, tools = with_tools_as_loads(loaded)
    occasions, whole = occasions_of([one.with_known(known) for one in loaded], progress)
    progress("comparing")
    decided = decide(occasions, whole, testable(whole)[0])
    progress("writing down what was found")
    return _assembled(decided, whole.campaign.files, tools)


def _assembled(decided: Decided, inputs: Mapping[str, str], notes: Sequence[str]) -> Comparison:
    system = decided.system
    shapes = [decided.shape(m) for m in decided.members]
    final = relinearised(system, shapes, decided.solved)
    changes = tuple(changes_of(decided))
    changed = any(change.any >= PRIORS.named for change in changes)
    beside = tuple(apart(decided, final))
    bound, nominal = within_mm(decided), nominal_mm(decided)
    first = system.occasions[0].problem
    other, zeros = beside_the_robot(system, beside), hidden_zeros(decided)
    said = headline(changes, bound, other, changed, zeros, nominal, beside[-1].label)
    return Comparison(
        first.robot.name,
        first.robot.title,
        tuple(one.label for one in system.occasions),
        tuple(len(one.problem.q) for one in system.occasions),
        changed,
        said,
        _apart_in_posture(system),
        changes,
        bound,
        nominal,
        tuple(unchanged(decided)),
        tuple(unseen(decided)),
        tuple(repeats(decided, changes)),
        beside,
        tuple(tracks(decided)),
        (*notes, *_notes(decided)),
        inputs,
    )


def _apart_in_posture(system: System) -> str:
    """Campaigns of which hardly a pose is within what others covered, where the model does not fit; nothing
    where there are none."""
    alone = list[str]()
    for k, one in enumerate(system.occasions) if system.misfit else ():
        others = [i for i in range(system.count) if i != k]
        if hardly(system, k, others):
            here = inside(system, k, others)
            alone.append(f"{int(here.sum())} of the {len(here)} poses of {one.label}")
    if not alone:
        return ""
    return (
        f"Only {listed(alone)} lie within what the other campaigns covered: elsewhere only what is larger "
        "than what the model lacks there is told."
    )


def _notes(decided: Decided) -> list[str]:
    out = []
    for one in decided.system.occasions:
        out += [f"{one.label}: {note}" for note in one.prepared.notes]
        if one.prepared.faults:
            many = len(one.prepared.faults)
            out.append(f"{one.label}: {many} data fault{'s' if many > 1 else ''} left out")
    off = loads_off(decided)
    out += [f"{listed(off)}: not as stated, in all campaigns that have it: no change."] if off else []
    if decided.system.misfit:
        out.append(
            "The noise does not explain what the model leaves: a change counts only where either half of the "
            "poses shows it, and is held possible where all of them together do."
        )
        out += [
            f"{one.label}: {listed(names)} stood still there: what only a change at these would explain may "
            "as well be what the model lacks in other poses."
            for one, names in still_joints(decided.system)
        ]
    return out
