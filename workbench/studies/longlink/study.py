"""A seven-joint arm with long links: circle points, then joint zeros and offsets from points of a ball.

Liu, Song, Li, Pan, Yu, “Multi-Parameter Based Calibration of Long-Link Flexible Manipulators”, bring the mean
error down to a fourteenth and lay it to long, flexible links. Question: which part of the error, before and
after, needs flexibility, and which measurement would show it?
"""

from __future__ import annotations

from pathlib import Path

from workbench import (
    Figure,
    Shown,
    Study,
    StudyRun,
    Table,
    as_package,
    load_robot,
    run_study,
    stored,
    tell,
    with_compliance,
    write_fit,
    zeros_and_offsets,
)

if not __package__:  # run as a script: the chapters lie beside it
    __package__ = as_package(__file__)

from .arm import SIGMA, STATION
from .bending import what_bends
from .calibration import axial_numbers, circle_numbers, identified, measured, miss_numbers, stages
from .detection import what_shows
from .faults import what_leaves
from .figures import twelve_figure
from .printed import AFTER, FITTED, NUMBERS
from .tables import two_tables

FILES = {
    "Campaign, two loads": "campaign/campaign.toml",
    "Campaign, circles": "circles/campaign.toml",
    "Campaign, 13 points": "thirteen/campaign.toml",
    "Model": "model.toml",
}


def study(run: StudyRun) -> Study:
    """What the tables say, what bends, what leaves the printed error, calibration, what would show load."""
    folder, seed, quick, progress = run.folder, run.seed, run.quick, run.say
    assumed = load_robot("longlink")
    progress("comparing the two printed tables")
    geometry = two_tables(seed, 20_000 if quick else 200_000)
    progress(f"asking what bends, and what would leave {AFTER:.2f} mm")
    bending = what_bends(assumed, seed, 200 if quick else 1000)
    faults = what_leaves(assumed, seed, 4 if quick else 12)

    progress(f"turning one joint at a time, then identifying d and θ from {FITTED} points")
    robot = stored(folder / "robot.toml", with_compliance(assumed, faults.numbers["share"]))
    data = measured(folder, robot, seed)
    found = identified(data, robot, seed, 20 if quick else 60)
    fits = stages(data, robot, found)
    write_fit(folder / "model.toml", fits["all_40"])
    miss = {name: zeros_and_offsets.error_lengths(fit, data.judged) for name, fit in fits.items()}
    numbers = NUMBERS | circle_numbers(data, found) | axial_numbers(found, fits["rigid"]) | miss_numbers(miss)
    items: dict[str, Table | Figure] = {"twelve": twelve_figure(miss, numbers["noise_mean_mm"])}

    progress("asking what data would show flexibility")
    showing = what_shows(folder, robot, seed, 3 if quick else 10)
    for chapter in (geometry, bending, faults, showing):
        numbers |= chapter.numbers
        items |= chapter.items

    before, after = (zeros_and_offsets.error_of(fits[name], data.judged) for name in ("designed", "known"))
    judged = data.judged.points[:, 0] - STATION[1][0]
    shown = Shown(data.judged.poses.q[0], judged, {"as designed": before, "calibrated": after}, noise=SIGMA)
    return tell(Path(__file__).with_name("story.md"), robot, numbers, items, shown, "twelve", FILES)


if __name__ == "__main__":
    run_study(study)
