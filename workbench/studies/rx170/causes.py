"""What each cause does to a path: the robot with one cause of its errors at a time, standing."""

from __future__ import annotations

from dataclasses import replace

from workbench import Array, Path, Robot, compensate, restated

YIELDING = ("joint_compliance", "lost_motion")


def one_cause_each(robot: Robot, joint: str) -> dict[str, Robot]:
    """The robot with nothing but the yield, or the gear, of a joint, or of all others: `yield_joint_2`,
    `gear_joint_2`, `yield_others`, `gear_others`."""
    others = [name for name in robot.joint_names if name != joint]
    found = {}
    for here, away, said in (([joint], others, joint), (others, [joint], "others")):
        yields = [e for e in robot.effects if e.joint in here and e.cause in YIELDING]
        gears = [e for e in robot.effects if e.joint in here and e.cause not in YIELDING]
        found[f"yield_{said}"] = replace(restated(robot, away, stiffness=None), effects=tuple(yields))
        found[f"gear_{said}"] = replace(restated(robot, stiffness=None), effects=tuple(gears))
    return found


def standing_error(robot: Robot, path: Path, start: Array) -> Array:
    """(N, 3) [m] tool minus path, uncorrected, at each sample as if the robot stood there."""
    return -compensate(robot, path, start=start, method="geometry").before[:, :3]
