"""A Stäubli RX170: yield and gear error of joint 2, and a spiral corrected offline.

Olabi et al. (2012) measure each joint's stiffness by itself, sweep joint 2, take the load's part off and find
a gear error of two cycles per turn of the reducer's input. Correcting both, on joint 2 alone, they bring a
spiral's R_a down to a sixth. Questions: could the sweep alone have told yield from gear? And what makes the
height from peak to valley that both corrections leave?
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from os import cpu_count
from pathlib import Path

from workbench import (
    Campaign,
    Draws,
    Figure,
    Fit,
    Judged,
    Robot,
    Study,
    StudyRun,
    Table,
    account_items,
    as_package,
    by_joint,
    checked,
    clear_numbers,
    clear_poses,
    clear_table,
    compensate_file,
    counterpart,
    judge,
    load_robot,
    record,
    redrawn,
    restated,
    run_study,
    separate,
    stored,
    sweep,
    tell,
    tornado,
    write_campaign,
    write_path,
)

if not __package__:  # run as a script: the chapters lie beside it
    __package__ = as_package(__file__)

from . import figures
from .accounts import ITEMS, accounts, draws
from .hidden import hidden
from .measuring import LOCAL, SWEEPS, all_at_once, measured, stiffness, stood_in
from .printed import NUMBERS, POSES, SPIRAL_TURNS, TABLE_1
from .said import OF_DRAWS, OF_ODDS, OF_RUN, odds
from .spiral import Spirals, draw_spirals, printed_numbers, spiral_numbers
from .superposed import ELBOW_UP

FILES = {
    "Sweep": "campaign/campaign.toml",
    "Stiffness model": "model_stiffness.toml",
    "Gear model": "model.toml",
    "All joints": "model_all.toml",
    "Spiral, VAL3": "spiral.pjx",
}

STORY = Path(__file__).with_name("story.md")


def study(run: StudyRun) -> Study:
    """Stiffness axis by axis, the sweep, what it separates, the spiral."""
    folder, seed, quick, progress = run.folder, run.seed, run.quick, run.say
    robot = load_robot("rx170")
    progress("judging six accounts of Table II")
    judged = judge(accounts(), ITEMS, run.draws(1500, 300), run, chunk=150)
    drawn = draws(run)
    truth, share = hidden(folder, robot, seed)
    progress("loading each joint by itself")
    local = [stiffness(robot, truth, name, 2 if quick else 6, seed) for name in LOCAL]
    together, spread = all_at_once(robot, truth, 12 if quick else 30, seed)
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
    believed = models(folder, known, truth, gears)
    spirals = draw_spirals(truth, robot, believed, turns, run.workers or cpu_count() or 1, progress)
    write_path(folder / "spiral.csv", spirals.path)
    compensate_file(folder / "spiral.csv", folder / "model.toml", "val3", folder, start=ELBOW_UP)

    clear = clear_poses(robot, stood_in(seed, spirals.slow.q))
    numbers = {
        **NUMBERS,
        "turns": float(turns),
        **figures.stiffness_numbers(local, share),
        **figures.sweep_numbers(apart),
        **spiral_numbers(spirals, seed),
        **printed_numbers(robot, spirals),
        **by_joint("g", together / 1e6),
        **by_joint("g", together / (share * TABLE_1) - 1, "_off"),
        **by_joint("g", 1.96 * spread, "_half"),
        **drawn.by_name(),
        **judged.numbers(),
        **clear_numbers(clear),
    }
    items = shown(judged, drawn) | spiral_shown(spirals, numbers)
    items |= {
        "clear": clear_table(clear),
        "measured": counterpart("rx170", run),
        "stiffness": figures.stiffness_figure(local, share),
        **figures.sweep_figures(apart, "joint 2"),
        "orders": figures.line_table(apart, "joint 2"),
    }
    stands = checked(OF_RUN, numbers) | checked(OF_DRAWS, numbers, drawn)
    stands |= checked(OF_ODDS, numbers, redrawn(judged, odds))
    told = tell(STORY, robot, numbers, items, spirals.shown, "odds", FILES, stands)
    return replace(told, sealed={"campaign/campaign.toml": {"effects": as_told(truth, "joint_2")}})


def shown(judged: Judged, drawn: Draws) -> dict[str, Table | Figure]:
    """The accounts of Table II, and what carries the height that is left."""
    return {
        **account_items(judged),
        "tornado": tornado(drawn, "ra_base", "tornado", "Ra of the last run, counted from the base, mm"),
    }


def spiral_shown(spirals: Spirals, by_name: Mapping[str, float]) -> dict[str, Table | Figure]:
    """The spiral at both speeds."""
    return {
        "slow": figures.along_figure("slow", spirals, by_name),
        "fast": figures.along_figure("fast", spirals, by_name),
        "heights": figures.ra_rz_figure(by_name),
    }


def as_told(truth: Robot, joint: str) -> list[str]:
    """What a joint really does, a line each."""
    return [
        f"{effect.cause} {effect.order or ''} {effect.values}"
        for effect in truth.effects
        if effect.joint == joint
    ]


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
