"""One wrong number in every campaign: prints whether it is found, and what it changes in the diagnosis.

`python tests/robustness/wild.py ../shared/data/* [--poses 80] [--only zeros ...]`. Each campaign is diagnosed
as it is, with something spoilt, and with just that left out: a spoilt one that is cleaned rightly is the one
with it left out. `--simulated` adds campaigns out of Drake with something hidden in the robot.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from diagnosis_cases import found, measured, named, with_points

from workbench.campaign import Campaign, load_campaign
from workbench.diagnosis.prepared import prepare
from workbench.diagnosis.result import Diagnosis
from workbench.files.faults import InputError

HEAD = """| campaign | poses | wrong | faults | causes as without | as left out | held out | left out |
|---|---|---|---|---|---|---|---|"""
SHARE = 0.4  # of the way through the campaign
SIMULATED = {  # robot, load [kg], what is hidden
    "kr500, gear": ("kr500", 250.0, "gear_eccentricity:joint=joint_2,variant=1,amplitude=4e-4,phase=0.4"),
    "kr500, clean": ("kr500", 250.0, ""),
    "ur5, compliance": ("ur5", 5.0, "joint_compliance:joint=shoulder_lift_joint,compliance=3e-5"),
    "cylindrical, gear ratio": ("cylindrical", 20.0, "gear_ratio:joint=joint_1,relative=2e-4"),
    "irb120, backlash": ("irb120", 3.0, "backlash:joint=joint_2,half_width=1e-4"),
    "iiwa7, link mass": ("iiwa7", 7.0, "link_mass:link=link_4,mass=2.0"),
}


def simulated(name: str) -> Campaign:
    robot, load, hidden = SIMULATED[name]
    return measured(robot, (hidden,) if hidden else (), poses=40, loads=(load,))


Points = np.ndarray


def _first_moving(c: Campaign) -> tuple[int, int]:
    """A seen point of a target on the tool, in the middle of the campaign."""
    target = next(i for i, one in enumerate(c.targets) if one.on != "base")
    seen = np.flatnonzero(np.isfinite(c.points[:, target]).all(axis=1))
    return int(seen[int(SHARE * len(seen))]), target


def far(by: float) -> Callable[[Campaign], tuple[Points, Points]]:
    def change(c: Campaign) -> tuple[Points, Points]:
        z, without = c.points.copy(), c.points.copy()
        where = _first_moving(c)
        z[where] += [0.0, by, 0.0]
        without[where] = np.nan
        return z, without

    return change


def whole_pose(c: Campaign) -> tuple[Points, Points]:
    z, without = c.points.copy(), c.points.copy()
    n, _ = _first_moving(c)
    z[n] += [0.3, 0.0, 0.0]
    without[n] = np.nan
    return z, without


def exchanged(c: Campaign) -> tuple[Points, Points]:
    """The readings of two poses far from each other."""
    z, without = c.points.copy(), c.points.copy()
    n, target = _first_moving(c)
    other = int(np.nanargmax(np.linalg.norm(z[:, target] - z[n, target], axis=1)))
    moving = [i for i, one in enumerate(c.targets) if one.on != "base"]
    for one, source in ((n, other), (other, n)):
        z[one, moving] = c.points[source, moving]
        without[one, moving] = np.nan
    return z, without


def zeros(c: Campaign) -> tuple[Points, Points]:
    """A whole target where there are others beside it on the tool, else every tenth pose."""
    z, without = c.points.copy(), c.points.copy()
    _, target = _first_moving(c)
    several = sum(one.on != "base" for one in c.targets) > 1 and not c.six_dof
    rows = slice(None) if several else slice(3, None, 10)
    seen = np.isfinite(z[rows, target])
    z[rows, target] = np.where(seen, 0.0, np.nan)
    without[rows, target] = np.nan
    return z, without


SPOILT: dict[str, Callable[[Campaign], tuple[Points, Points]]] = {
    "a-point-300-m-off": far(300.0),
    "a-point-300-mm-off": far(0.3),
    "a-pose-300-mm-off": whole_pose,
    "two-poses-exchanged": exchanged,
    "zeros": zeros,
}


def diagnosed(c: Campaign, known: dict[bytes, Diagnosis | str]) -> tuple[int, Diagnosis | str]:
    """Number of data faults, and the diagnosis; what is the same when it was cleaned is diagnosed once."""
    try:
        prepared = prepare([c])
        left = prepared.problem.campaign
        key = left.points.tobytes() + repr((left.poses.ids, left.poses.setup.tolist())).encode()
        known[key] = known.get(key) or found(c)
        return len(prepared.faults), known[key]
    except InputError as error:
        return 0, f"refused: {str(error).splitlines()[0][:150]}"


def as_before(after: Diagnosis | str, before: Diagnosis | str) -> str:
    if isinstance(after, str) or isinstance(before, str):
        return after if isinstance(after, str) else "answered"
    if named(after) == named(before):
        return "yes" if after.verdict == before.verdict else f"{before.verdict} → {after.verdict}"
    changed = dict(named(before).items() ^ named(after).items())
    return "; ".join(
        f"{cause} {where}: {named(before).get((cause, where), '-')} → {named(after).get((cause, where), '-')}"
        for cause, where in changed
    )


def error(one: Diagnosis | str) -> str:
    return "-" if isinstance(one, str) else f"{one.stages[-1].heldout_rms_mm:.5f}"


def thinned(c: Campaign, poses: int) -> Campaign:
    step = max(1, round(len(c.poses.q) / poses))
    return c if step == 1 else c.some(np.arange(0, len(c.poses.q), step))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="*")
    parser.add_argument("--poses", type=int, default=80)
    parser.add_argument("--only", nargs="*", choices=SPOILT, default=list(SPOILT))
    parser.add_argument("--simulated", action="store_true")
    arguments = parser.parse_args()
    folders = [folder for folder in arguments.folders if (folder / "campaign.toml").exists()]
    sources: dict[str, Callable[[], Campaign]] = {
        f.name: lambda f=f: thinned(load_campaign(f / "campaign.toml"), arguments.poses) for f in folders
    }
    if arguments.simulated:
        sources |= {name: lambda name=name: simulated(name) for name in SIMULATED}
    print(HEAD, flush=True)
    for name, source in sources.items():
        c = source()
        start, known = time.monotonic(), dict[bytes, Diagnosis | str]()
        had, before = diagnosed(c, known)
        print(f"{name}: {time.monotonic() - start:.0f} s", file=sys.stderr)
        for what in arguments.only:
            spoilt, without = SPOILT[what](c)
            faults, after = diagnosed(with_points(c, spoilt), known)
            _, missing = diagnosed(with_points(c, without), known)
            faults -= had
            same = as_before(after, before), as_before(after, missing)
            errors = f"{error(before)} → {error(after)} | {error(missing)}"
            print(
                f"| {name} | {c.n_poses} | {what} | {faults} | {same[0]} | {same[1]} | {errors} |", flush=True
            )


if __name__ == "__main__":
    main()
