"""The verb: a campaign or a robot in, the poses to measure next out."""

from __future__ import annotations

from collections.abc import Callable

from ...campaign import Campaign
from ...files.faults import Fault, InputError
from ...robot.description import Robot
from .accuracy import AccuracyPlan, plan_accuracy
from .knowledge import measured, unmeasured
from .tell import TellPlan, plan_tell

POOL = 1200  # candidate records
QUICK_POOL = 400
STARTS = 3  # of the exchange

Plan = AccuracyPlan | TellPlan
Progress = Callable[[str], None]


def plan(
    source: Campaign | Robot,
    poses: int = 30,
    *,
    tell: str | None = None,
    seed: int = 0,
    quick: bool = False,
    progress: Progress = lambda _: None,
) -> Plan:
    """The next poses to measure: for accuracy, or (`tell`: two causes, "A,B", each as in `--effect`) to tell
    rival causes apart. What a campaign has shown already counts. Raises InputError where there is no plan."""
    if poses < 1:
        raise InputError(Fault("--poses", f"is {poses}", "give a number of poses"))
    progress("fitting the campaign" if isinstance(source, Campaign) else "loading the robot")
    known = measured(source) if isinstance(source, Campaign) else unmeasured(source)
    pool, starts = (max(QUICK_POOL, 2 * poses), 1) if quick else (max(POOL, 4 * poses), STARTS)
    progress(f"choosing {poses} of about {pool} possible records")
    if tell is not None:
        return plan_tell(known, tell, poses, pool, starts, seed)
    return plan_accuracy(known, poses, pool, starts, seed)
