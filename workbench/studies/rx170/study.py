"""A Stäubli RX170: yield and gear error of joint 2, and a spiral corrected offline.

Olabi et al. (2012) measure each joint's stiffness by itself, sweep joint 2, take the load's part off and find
a gear error of two cycles per turn of the reducer's input. Correcting both, on joint 2 alone, they bring a
spiral's R_a down to a sixth. Questions: could the sweep alone have told yield from gear? And what makes the
height from peak to valley that both corrections leave?
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from workbench import (
    Campaign,
    Figure,
    Fit,
    Robot,
    Study,
    StudyRun,
    Table,
    as_package,
    compensate_file,
    load_robot,
    record,
    restated,
    run_study,
    separate,
    stored,
    sweep,
    tell,
    write_campaign,
    write_path,
)

if not __package__:  # run as a script: the chapters lie beside it
    __package__ = as_package(__file__)

from . import figures
from .hidden import hidden
from .measuring import LOCAL, SWEEPS, measured, stiffness
from .printed import NUMBERS, POSES, SPIRAL_TURNS
from .spiral import ELBOW_UP, draw_spirals, printed_numbers, spiral_numbers


def study(run: StudyRun) -> Study:
    """Stiffness axis by axis, the sweep, what it separates, the spiral."""
    folder, seed, quick, progress = run.folder, run.seed, run.quick, run.say
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
    for name in SWEEPS:
        progress(f"sweeping {name}, and looking for its gear")
        count = 1001 if quick and name != "joint_2" else POSES
        swept[name] = measured(truth, blind, name, count, seed)
        gears[name] = sweep.gear_of(swept[name], name)
    write_campaign(folder / "campaign", swept["joint_2"], comments=["joint 2 swept, simulated in Drake"])
    apart = separate(robot, swept["joint_2"], gears["joint_2"], "joint_2")

    progress("drawing the spiral in closed loop")
    turns = 1 if quick else SPIRAL_TURNS
    spirals = draw_spirals(truth, robot, models(folder, known, truth, gears), turns, progress)
    write_path(folder / "spiral.csv", spirals.path)
    compensate_file(folder / "spiral.csv", folder / "model.toml", "val3", folder, start=ELBOW_UP)

    numbers = {
        **NUMBERS,
        "turns": float(turns),
        **figures.stiffness_numbers(local, share),
        **figures.sweep_numbers(apart),
        **spiral_numbers(spirals, seed),
        **printed_numbers(robot, spirals),
    }
    items: dict[str, Table | Figure] = {
        "stiffness": figures.stiffness_figure(local, share),
        **figures.sweep_figures(apart, "joint 2"),
        "orders": figures.line_table(apart, "joint 2"),
        "slow": figures.along_figure("slow", spirals, numbers),
        "fast": figures.along_figure("fast", spirals, numbers),
        "heights": figures.ra_rz_figure(numbers),
    }
    files = {
        "Sweep": "campaign/campaign.toml",
        "Stiffness model": "model_stiffness.toml",
        "Gear model": "model.toml",
        "All joints": "model_all.toml",
        "Spiral, VAL3": "spiral.pjx",
    }
    return tell(Path(__file__).with_name("story.md"), robot, numbers, items, spirals.shown, "heights", files)


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
    run_study(study)
