"""A Stäubli RX170: yield and gear error of joint 2, and a spiral corrected offline (source 003).

The paper measures each joint's stiffness by itself, sweeps joint 2 in 2001 steps, takes the load's part off
and finds a gear error of two cycles per turn of the reducer's input. Correcting both, on joint 2 alone, it
brings a spiral's R_a from 0.203 to 0.031 mm. Questions: could the sweep alone have told yield from gear?
And what makes the 0.15 mm from peak to valley that both corrections leave?
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.campaign import Campaign, Target, write_campaign
from workbench.correction import compensate_file
from workbench.correction.paths import write_path
from workbench.effects.records import record
from workbench.identification.fit import Fit
from workbench.identification.restated import restated, stored
from workbench.measurement.axis_by_axis import POINTER, LocalStiffness, identify, levels, local_plan
from workbench.measurement.separation import separate
from workbench.measurement.sweep import gear_of, sweep
from workbench.report.story import Item, tell
from workbench.report.study import Study
from workbench.robot.description import Robot, load_robot
from workbench.robot.kinematics import Array
from workbench.robot.schema import EffectRecord
from workbench.simulation.virtual_campaign import Truth, simulate
from workbench.studies.rx170 import figures as told
from workbench.studies.rx170.spiral import ELBOW_UP, draw_spirals, printed_numbers, spiral_numbers

TABLE_1 = np.array([0.204, 0.85, 0.57, 0.49, 0.12, 0.005]) * 1e6  # N·m/rad, printed
TABLE_2 = {"ra": (0.2032, 0.0459, 0.0312), "rz": (0.2882, 0.2097, 0.1502)}  # mm, printed

# not in the paper, from here on: noise per reading of tracker [m] and level [rad]
TRACKER, LEVEL = 3e-5, 5e-6

# How each joint is loaded: pose [deg], N and N·m at the flange per N of load, largest load [N], links with
# tracker targets (none: levels). Each force runs through the axes that shall not feel it, if it can.
LOCAL = {
    "joint_1": ((0, 0, 90, 0, 0, 0), (0, 1, 0, 0, 0, 0), 500.0, ("base", "link_1")),
    "joint_2": ((0, 0, 90, 0, 0, 0), (-1, 0, 0, 0, 0, 0), 800.0, ("link_1", "link_2")),
    "joint_3": ((0, 0, 90, 0, 0, 0), (0, 0, -1, 0, 0, 0), 500.0, ()),
    "joint_4": ((0, 0, 90, 0, 90, 0), (0, 0, -1, -0.5, 0, 0), 500.0, ()),
    "joint_5": ((0, 0, 90, 0, 0, 0), (0, 0, -1, 0, 0.5, 0), 300.0, ()),
    "joint_6": ((0, 0, 90, 0, 0, 0), (0, 0, -1, -0.2, 0, 0), 50.0, ()),
}
PLACES = {  # m, of tracker targets on the links
    "base": ((0.3, 0.2, 0.1), (-0.3, 0.1, 0.3), (0.1, -0.3, 0.3)),
    "link_1": ((0.3, -0.2, 0.1), (-0.3, 0.15, 0.1), (0.0, -0.35, 0.2)),
    "link_2": ((0.1, -0.2, 0.8), (-0.1, -0.2, 0.6), (0.0, -0.3, 0.9)),
}
# Which joint is swept between which angles, the others where [deg], a target on its link [m]. The paper
# sweeps joint 2; the two others that lift the tool are swept for the row that corrects everything.
SWEPT = {
    "joint_2": ((-50, 50), (0, 0, 90, 0, 0, 0), Target("elbow", (0.0, -0.25, 0.95), "link_2")),
    "joint_3": ((50, 150), (0, 0, 0, 0, 0, 0), Target("wrist", (0.0, -0.15, 0.8), "link_3")),
    "joint_5": ((-50, 50), (0, 0, 90, 0, 0, 0), Target("bar", (0.0, 0.0, 0.5), "link_5")),
}
# The true gears: cycles per joint turn, amplitude, phase [rad]. Joint 2's fundamental swells along the stroke
# (199, 201); its third harmonic, the shaft (100), the motor (140) and run-out (1) add their own.
GEARS = {
    "joint_1": ((200, 5e-5, 0.9),),
    "joint_2": (
        *((199, 8e-6, 0.2), (200, 7e-5, 0.6), (201, 8e-6, 1.0), (400, 1.5e-5, 1.1), (600, 5e-6, 2.5)),
        *((100, 1.2e-5, 2.0), (140, 8e-6, 0.3), (1, 5e-5, 0.5)),
    ),
    "joint_3": ((200, 5e-5, 1.7), (400, 1e-5, 0.4), (1, 4e-5, 2.0)),
    "joint_4": ((96, 6e-5, 0.2),),
    "joint_5": ((88, 6e-5, 1.2),),
    "joint_6": ((72, 8e-5, 2.2),),
}


def study(folder: Path, seed: int, quick: bool, progress: Callable[[str], None]) -> Study:
    """Stiffness axis by axis, the sweep, what it separates, the spiral."""
    robot = load_robot("rx170")
    truth, share = hidden(folder, robot, seed)
    progress("loading each joint by itself")
    local = [stiffness(robot, truth, name, 2 if quick else 6, seed) for name in LOCAL]
    known = robot
    for found in local:
        known = restated(known, [found.joint], stiffness=found.value)
    blind = stored(folder / "stiffness.toml", restated(known, gear_ratio=None))

    swept: dict[str, Campaign] = {}
    gears: dict[str, Fit] = {}
    for name in SWEPT:
        progress(f"sweeping {name}, and looking for its gear")
        count = 1001 if quick and name != "joint_2" else 2001
        swept[name] = measured(truth, blind, name, count, seed)
        gears[name] = gear_of(swept[name], name)
    write_campaign(folder / "campaign", swept["joint_2"], comments=["joint 2 swept, simulated in Drake"])
    apart = separate(robot, swept["joint_2"], gears["joint_2"], "joint_2")

    progress("drawing the spiral in closed loop")
    turns = 1 if quick else 2
    spirals = draw_spirals(truth, robot, models(folder, known, truth, gears), turns, progress)
    write_path(folder / "spiral.csv", spirals.path)
    compensate_file(folder / "spiral.csv", folder / "model.toml", "val3", folder, start=ELBOW_UP)

    numbers = {
        "turns": float(turns),
        **told.stiffness_numbers(local, TABLE_1, share),
        **told.sweep_numbers(apart),
        **spiral_numbers(spirals, TABLE_2, seed),
        **printed_numbers(robot, spirals, TABLE_1[2], TABLE_2),
    }
    items: dict[str, Item] = {
        "stiffness": told.stiffness_figure(local, TABLE_1, share),
        **told.sweep_figures(apart, "joint 2"),
        "orders": told.line_table(apart, "joint 2"),
        "slow": told.along_figure("slow", spirals, numbers),
        "fast": told.along_figure("fast", spirals, numbers),
        "heights": told.ra_rz_figure(numbers, TABLE_2),
    }
    files = {
        "Sweep": "campaign/campaign.toml",
        "Stiffness model": "model_stiffness.toml",
        "Gear model": "model.toml",
        "All joints": "model_all.toml",
        "Spiral, VAL3": "spiral.pjx",
    }
    return tell(Path(__file__).with_name("story.md"), robot, numbers, items, spirals.shown, "heights", files)


def hidden(folder: Path, robot: Robot, seed: int) -> tuple[Robot, Array]:
    """The robot as it is, which no step sees, and its stiffness over Table I: (6,), 10 to 20 % off."""
    rng = np.random.default_rng([seed, 170])
    share = 1 + rng.choice([-1, 1], 6) * rng.uniform(0.1, 0.2, 6)
    effects = [
        EffectRecord(cause="joint_compliance", joint=name, values={"relative": 1 / s - 1})
        for name, s in zip(robot.joint_names, share, strict=True)
    ]
    for joint, lines in GEARS.items():
        for order, a, phase in lines:
            size = {"amplitude": a, "phase": phase}
            effects.append(
                EffectRecord(cause="gear_eccentricity", joint=joint, variant="1", values=size)
                if order == 1
                else EffectRecord(cause="gear_kinematic_error", joint=joint, order=order, values=size)
            )
    return stored(folder / "truth.toml", robot, effects), share


def stiffness(robot: Robot, truth: Robot, joint: str, rounds: int, seed: int) -> LocalStiffness:
    """One joint's stiffness: the load goes up in ten steps and down again, `rounds` times."""
    degrees, wrench, largest, links = LOCAL[joint]
    q, steps, level = np.deg2rad(degrees), largest * np.linspace(0, 1, 11), not links
    points = [Target(f"{on}_{i}", xyz, on) for on in links for i, xyz in enumerate(PLACES[on])]
    targets = levels(robot, q, joint) if level else points
    plan = local_plan(truth, q, wrench, np.tile([*steps, *steps[::-1]], rounds), targets)
    seen = simulate(
        plan,
        Truth(sigma=LEVEL * POINTER if level else TRACKER, repeatability=np.zeros(6)),
        seed=10 * seed + robot.joint_names.index(joint),
        instrument=(np.eye(3)[None], np.zeros((1, 3))) if level else None,
    )
    return identify(replace(seen, robot=robot), joint, levelled=level)


def measured(truth: Robot, believed: Robot, joint: str, count: int, seed: int) -> Campaign:
    """A joint swept on the true robot; the campaign names the robot that is believed in."""
    ends, q, target = SWEPT[joint]
    low, high = np.deg2rad(ends)
    plan = sweep(truth, joint, np.deg2rad(q), (float(low), float(high)), count, target)
    return replace(simulate(plan, Truth(sigma=TRACKER), seed=seed), robot=believed)


def models(folder: Path, known: Robot, truth: Robot, gears: Mapping[str, Fit]) -> dict[str, Robot]:
    """What each command but the first believes: joint 2 alone, as the paper does; all joints; the truth."""
    alone = restated(known, set(known.joint_names) - {"joint_2"}, stiffness=None)
    lines = {
        name: [record(e, v) for e, v in zip(found.model.effects, found.state.values, strict=True)]
        for name, found in gears.items()
    }
    return {
        "stiffness": stored(folder / "model_stiffness.toml", alone),
        "both": stored(folder / "model.toml", alone, lines["joint_2"]),
        "all": stored(folder / "model_all.toml", known, [line for gear in lines.values() for line in gear]),
        "perfect": truth,
    }


if __name__ == "__main__":
    from workbench.studies.running import main

    main(study)
