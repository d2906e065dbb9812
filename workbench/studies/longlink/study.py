"""A seven-joint arm with long links: circle points, then joint zeros and offsets from points of a ball.

Liu, Song, Li, Pan, Yu, “Multi-Parameter Based Calibration of Long-Link Flexible Manipulators”, bring the mean
error down to a fourteenth and lay it to long, flexible links. Question: which part of the error, before and
after, needs flexibility, and which measurement would show it?
"""

from __future__ import annotations

from dataclasses import replace
from os import cpu_count
from pathlib import Path

from workbench import (
    Draws,
    Figure,
    Judged,
    Shown,
    Study,
    StudyRun,
    Table,
    account_items,
    as_package,
    clear_numbers,
    clear_poses,
    clear_table,
    counterpart,
    judge,
    load_robot,
    run_study,
    stored,
    tell,
    tornado,
    with_compliance,
    write_fit,
    zeros_and_offsets,
)

if not __package__:  # run as a script: the chapters lie beside it
    __package__ = as_package(__file__)

from .arm import SIGMA, STATION
from .bending import what_bends
from .calibration import axial_numbers, circle_numbers, identified, measured, miss_numbers, stages, stood_in
from .circular import arm_draws, arm_numbers, arms_table
from .detection import hidden_draws, what_shows
from .driven import FAST, SLOW, driven, driven_numbers
from .figures import twelve_figure
from .printed import FITTED, NUMBERS
from .recursion import compensated, recursion_numbers, recursion_table
from .said import ODDS, stands
from .stories import ITEMS, OWN, TOLERANCE, YIELDING, accounts
from .tables import two_tables

FILES = {
    "Campaign, two loads": "campaign/campaign.toml",
    "Campaign, circles": "circles/campaign.toml",
    "Campaign, 13 points": "thirteen/campaign.toml",
    "Model": "model.toml",
}


def told(arms: Draws, judged: Judged) -> dict[str, Table | Figure]:
    """The arms that only sag, and the accounts, as tables and figures."""
    return {
        "arms": arms_table(arms),
        "carries": tornado(
            arms,
            "share_sag",
            "carries",
            "share of the error before that the fitted table makes, %",
            100,
            "Which assumption carries the share of its error that the table of a sagging arm makes",
        ),
        **account_items(judged),
    }


def study(run: StudyRun) -> Study:
    """What the tables tell, what bends, accounts of what is printed, calibration, what would show load."""
    folder, seed, quick = run.folder, run.seed, run.quick
    if quick and run.workers is None:  # what is drawn is less than starting processes for it
        run = replace(run, workers=1)
    assumed = load_robot("longlink")
    run.say("comparing the two printed tables, and arms that only sag")
    geometry = two_tables(seed, run.draws(200_000, 20_000))
    arms = arm_draws(run.draws(400, 100), run)
    bending = what_bends(assumed, seed, 200 if quick else 1000)

    run.say("holding each account against what is printed")
    judged = judge(accounts(), ITEMS, run.draws(1500, 300), run, chunk=run.draws(250, 150))
    share = YIELDING["compliance"].middle

    run.say(f"turning one joint at a time, then identifying d and θ from {FITTED} points")
    robot = stored(folder / "robot.toml", with_compliance(assumed, share))
    data = measured(folder, robot, seed)
    found = identified(data, robot, seed, run.draws(60, 20))
    fits = stages(data, robot, found)
    write_fit(folder / "model.toml", fits["all_40"])
    miss = {name: zeros_and_offsets.error_lengths(fit, data.judged) for name, fit in fits.items()}
    numbers = NUMBERS | circle_numbers(data, found) | axial_numbers(found, fits["rigid"]) | miss_numbers(miss)
    numbers |= (
        judged.numbers()
        | arm_numbers(arms)
        | {
            "share": share,
            "stiffer": 1 / share,
            "odds_out": ODDS,
            "tolerance": TOLERANCE,
            "accounts_count": float(len(OWN)),
        }
    )
    path = compensated(assumed, share)
    run.say("driving the compensated path in closed loop")
    turns = (FAST,) if quick else (SLOW, FAST)
    loop = driven(assumed, share, turns, run.workers or cpu_count() or 1, run.say)
    numbers |= recursion_numbers(path) | driven_numbers(loop)

    run.say("asking what data would show flexibility")
    hidden = hidden_draws(share, run.draws(50, 1), run)
    showing = what_shows(folder, robot, hidden, run)
    clear = clear_poses(assumed, stood_in(data, seed))
    numbers |= clear_numbers(clear)
    items: dict[str, Table | Figure] = {
        "clear": clear_table(clear),
        "measured": counterpart("longlink", run),
        **told(arms, judged),
        "twelve": twelve_figure(miss, numbers["noise_mean_mm"]),
        "recursion": recursion_table(path, loop),
    }
    for chapter in (geometry, bending, showing):
        numbers |= chapter.numbers
        items |= chapter.items
    claims = stands(numbers, judged, arms, hidden)
    before, after = (zeros_and_offsets.error_of(fits[name], data.judged) for name in ("designed", "known"))
    judging = data.judged.points[:, 0] - STATION[1][0]
    shown = Shown(data.judged.poses.q[0], judging, {"as designed": before, "calibrated": after}, noise=SIGMA)
    return tell(Path(__file__).with_name("story.md"), robot, numbers, items, shown, "carries", FILES, claims)


if __name__ == "__main__":
    run_study(study)
