"""KUKA KR 500: stiffness of its own for every cell of the workspace.

“Variable Parameters Stiffness Identification and Modeling for Positional Compensation of Industrial Robots”
identifies constant parameters, then parameters per cell, and finds that small cells predict the bend under
50 kg better: so "the joint stiffness varies indeed". Question: of the accounts of what it prints, which
reproduce it, and what does a gain from cells show?
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from workbench import (
    Figure,
    Judged,
    Outcome,
    Shown,
    Study,
    StudyRun,
    Table,
    as_package,
    calibrated,
    calibrated_table,
    checked,
    clear_numbers,
    clear_poses,
    clear_table,
    counterpart,
    diagnose,
    draw_many,
    judge,
    redrawn,
    run_study,
    stated_table,
    stored,
    tell,
    write_campaign,
)

if not __package__:  # run as a script: the chapters lie beside it
    __package__ = as_package(__file__)

from . import gains, named, odds, shown
from .accounts import KINDS, WEIGHED, accounts, items
from .claims import OF_ACCOUNTS, OF_DRAWS, OF_RUN, again, told
from .printed import NUMBERS
from .seen import identifiable

AT_THEIR_BEST = ("bracket", "varying", "constant")
TRUTHS = ("constant", "soft", "varying", "structure", "bracket")  # robots that differ in how they yield

STAGES = {"raw": "uncompensated", "constant": "constant stiffness", "128": "128 cells"}


def study(run: StudyRun) -> Study:
    """Accounts of the print judged, what cells gain in each, and what a diagnosis says of their robots."""
    seed = run.seed
    run.say("accounts: the paper's protocol, with all that it does not give drawn")
    judged = judge(accounts(), items(), run.draws(150, 100), run, chunk=5, nearer=run.draws(60, 30))
    weighed = calibrated(judged, WEIGHED)
    run.say("what cells gain in robots that differ in one thing")
    draws = gains.reached(draw_many(gains.gained, gains.ASSUMED, run.draws(70, 12), run, "gains"))
    run.say("accounts at their best, in Drake")
    best = [shown.best(judged, name, seed) for name in AT_THEIR_BEST]
    run.say("diagnosing: soft zones by size and records, and the robot of each account")
    curve = named.curve(run)
    outcomes, sealed = diagnosed(judged, run)

    first = best[0]
    seen, singular = identifiable()
    n = NUMBERS | judged.numbers(without=False) | draws.by_name() | singular
    n |= told(judged, weighed, draws, curve)
    clear = clear_poses(first.world.grid.robot, shown.stood_in(best if not run.quick else best[:1]))
    n |= clear_numbers(clear)
    n["drake_um"] = 1e6 * max(one.difference for one in best)
    items_: dict[str, Table | Figure] = {
        "load known": odds.standings_table(judged, True),
        "moment left out": odds.standings_table(judged, False),
        "odds": calibrated_table(weighed, judged),
        "stated": stated_table(weighed),
        "ranges": odds.ranges_table(judged),
        "gains": gains.gains_figure(draws),
        "carried": gains.carried(
            draws, "gain_bracket", "carried", "what 128 cells gain where the bracket shifts, %", 100.0
        ),
        "points": shown.points_figure(best[0]),
        "errors": shown.errors_table(best),
        "equations": shown.equations_table(best),
        "table 1": shown.cells_table(best[0]),
        "scatter": shown.scatter_table(best),
        "seen": seen,
        "clear": clear_table(clear),
        "measured": counterpart("kr500", run),
        "verdicts": named.verdicts_table(outcomes),
        "named": named.curve_figure(curve),
    }
    half = len(first.moved)
    place = first.world.check.rigid.points(first.world.check.stated_targets, first.world.check.on)[:half, 0]
    stages = {words: first.tried.true[key] for key, words in STAGES.items()}
    scene = Shown(first.world.check.q[0], place, stages, noise=first.world.values["sigma"])
    files = {"Campaign": "campaign/campaign.toml"}
    story = Path(__file__).with_name("story.md")
    claims = checked(OF_RUN, n) | checked(OF_DRAWS, n, draws)
    claims |= checked(OF_ACCOUNTS, n, redrawn(judged, again))
    page = tell(story, first.world.grid.robot, n, items_, scene, "gains", files, claims)
    return replace(page, sealed=sealed)


def diagnosed(judged: Judged, run: StudyRun) -> tuple[dict[str, Outcome], dict[str, object]]:
    """What a diagnosis says of the robots of some accounts at their best; the campaign of the soft zone is
    written, with its robot as it was told, and what is hidden in it by its place."""
    outcomes: dict[str, Outcome] = {}
    sealed: dict[str, object] = {}
    for name in TRUTHS if not run.quick else TRUTHS[:2]:
        words, _, law, _ = KINDS[name]
        world, _ = shown.nearest_world(judged, name, run.seed)
        data = named.campaign(world, law, "2", run.seed)
        outcomes[words] = diagnose(data, seed=run.seed)
        if name == "soft":
            told_as = replace(data, robot=stored(run.folder / "told" / "kr500.toml", data.robot))
            write_campaign(run.folder / "campaign", told_as, comments=["simulated in Drake"])
            sealed["campaign/campaign.toml"] = shown.hidden(world)
    return outcomes, sealed


if __name__ == "__main__":
    run_study(study)
