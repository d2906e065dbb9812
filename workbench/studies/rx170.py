"""A Stäubli RX170: yield and gear error of joint 2, and a spiral corrected offline (source 003).

The paper measures each joint's stiffness by itself, sweeps joint 2 in 2001 steps, takes the load's part off
and finds a gear error of two cycles per turn of the reducer's input. Correcting both, on joint 2 alone, it
brings a spiral's R_a from 0.203 to 0.031 mm. Questions: could the sweep alone have told yield from gear?
And what makes the 0.15 mm from peak to valley that both corrections leave?
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy import stats

from workbench.arm import Array
from workbench.campaign import Campaign, Target, write_campaign
from workbench.closed_loop.draw import Drawn, draw_corrected
from workbench.closed_loop.heights import height_figure, heights, least_mean
from workbench.compensate import compensate_file
from workbench.compensate.path_causes import one_cause_each, standing_error
from workbench.fit import Fit
from workbench.path_shapes import Run, spiral, work_frame
from workbench.paths import Path as ToolPath
from workbench.paths import write_path
from workbench.poses import planned
from workbench.problem import problem
from workbench.protocols.axis_by_axis import POINTER, LocalStiffness, identify, levels, local_plan
from workbench.protocols.separation import separate
from workbench.protocols.sweep import gear_of, sweep
from workbench.records import record
from workbench.report.charts import OURS, PRINTED, Series, rows
from workbench.report.drawing import MODEL, NOISE, Figure
from workbench.report.numbers import mm
from workbench.report.story import tell
from workbench.report.study import Shown, Study, Table
from workbench.restated import restated, stored
from workbench.robot import EffectRecord, Robot, load_robot
from workbench.simulate import Truth, simulate
from workbench.studies.rx170_figures import line_table, sweep_figures, sweep_numbers

Numbers = dict[str, float]
TABLE_1 = np.array([0.204, 0.85, 0.57, 0.49, 0.12, 0.005]) * 1e6  # N·m/rad, printed
TABLE_2 = {"ra": (0.2032, 0.0459, 0.0312), "rz": (0.2882, 0.2097, 0.1502)}  # mm, printed
COMMANDS = {
    "none": "Without correction",
    "stiffness": "Stiffness correction",
    "both": "Stiffness and kinematic correction",
    "all": "All joints corrected",
    "perfect": "A perfect model",
}
# Noise per reading: tracker [m], level [rad], and tracker along the path [m].
TRACKER, LEVEL, ALONG = 3e-5, 5e-6, 1e-5

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
SLOW, FAST = 0.03, 0.3  # m/s; at 0.1 m/s² as printed, and at ten times that
PLANE = 0.75 + 0.2  # m over the floor: the maker counts Z from the height of joint 2
ELBOW_UP = np.array([0.0, 0.4, 1.8, 0.0, 0.95, 0.0])


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
    beliefs = models(folder, known, truth, gears)
    slow, fast = (spiral_at(speed, 1 if quick else 2) for speed in (SLOW, FAST))
    runs = draw_corrected(truth, robot, [slow, fast], beliefs, ELBOW_UP, workers=2, progress=progress)
    single = one_cause_each(truth, "joint_2")
    causes = {key: standing_error(one, slow, ELBOW_UP)[:, 2] for key, one in single.items()}
    # z = 0 is where the tool would run on average if joint 2 had no error: see the words
    zero = float((causes["yield_others"] + causes["gear_others"]).mean())
    write_path(folder / "spiral.csv", slow)
    compensate_file(folder / "spiral.csv", folder / "model.toml", "val3", folder, start=ELBOW_UP)

    numbers = {
        "turns": 1.0 if quick else 2.0,
        **stiffness_numbers(local, share),
        **sweep_numbers(apart),
        **spiral_numbers(runs, zero, seed),
        **cause_numbers(causes),
        **printed_numbers(robot, runs[0]),
    }
    items: dict[str, Table | Figure] = {
        "stiffness": stiffness_figure(local, share),
        **sweep_figures(apart, "joint 2"),
        "orders": line_table(apart, "joint 2"),
        "slow": along_figure("slow", SLOW, runs[0], zero, numbers),
        "fast": along_figure("fast", FAST, runs[1], zero, numbers),
        "heights": ra_rz_figure(numbers),
    }
    error = {COMMANDS[key]: e for key, e in runs[0].error.items()}
    shown = Shown(runs[0].q[len(slow) // 2], runs[0].wanted, error, noise=ALONG)
    files = {
        "Sweep": "campaign/campaign.toml",
        "Stiffness model": "model_stiffness.toml",
        "Gear model": "model.toml",
        "All joints": "model_all.toml",
        "Spiral, VAL3": "spiral.pjx",
    }
    return tell(Path(__file__).with_suffix(".md"), robot, numbers, items, shown, "heights", files)


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
    errs = {
        name: [record(e, v) for e, v in zip(f.model.effects, f.state.values, strict=True)]
        for name, f in gears.items()
    }
    return {
        "stiffness": stored(folder / "model_stiffness.toml", alone),
        "both": stored(folder / "model.toml", alone, errs["joint_2"]),
        "all": stored(folder / "model_all.toml", known, [e for each in errs.values() for e in each]),
        "perfect": truth,
    }


def spiral_at(speed: float, turns: int) -> ToolPath:
    """The paper's spiral at a speed [m/s], 1 m before the robot, hand down; 0.3 mm between samples."""
    run = Run(work_frame([1.0, 0.0, PLANE]), speed, 0.1 * speed / SLOW, 3e-4 / speed)
    return spiral(run, start=0.024, growth=0.15, angle=2 * np.pi * turns)


def stiffness_numbers(local: Sequence[LocalStiffness], share: Array) -> Numbers:
    """Table I beside what was found."""
    numbers: Numbers = {"local_half": 1.96 * local[1].relative_std, "inside": 0.0}
    for j, (found, printed, s) in enumerate(zip(local, TABLE_1, share, strict=True), 1):
        numbers |= {f"printed_{j}": printed / 1e6, f"true_{j}": s * printed / 1e6}
        numbers |= {f"k_{j}": found.value / 1e6, f"low_{j}": found.low / 1e6, f"high_{j}": found.high / 1e6}
        numbers |= {f"off_{j}": found.value / (s * printed) - 1, f"std_{j}": found.relative_std}
        numbers |= {f"torque_{j}": found.torque, f"turn_{j}": 1e3 * found.turn}
        numbers["inside"] += float(found.low <= s * printed <= found.high)
    return numbers


def spiral_numbers(runs: Sequence[Drawn], zero: float, seed: int) -> Numbers:
    """R_a and R_z of every command at both speeds [mm]."""
    rng = np.random.default_rng([seed, 13])
    numbers: Numbers = {}
    for speed, run in zip(("slow", "fast"), runs, strict=True):
        for name, error in run.error.items():
            found = heights(run.wanted, error, zero, ALONG * rng.normal(size=len(error)))
            numbers |= {f"{key}_{name}_{speed}": value for key, value in found.items()}
    pairs = [(r, *pair) for r in ("ra", "rz") for pair in zip(COMMANDS, TABLE_2[r], strict=False)]
    ratios = [numbers[f"{r}_{name}_slow"] / printed for r, name, printed in pairs]
    return numbers | {"worst": float(np.exp(np.abs(np.log(ratios)).max()))}


def cause_numbers(causes: Mapping[str, Array]) -> Numbers:
    """Mean and span of what each cause alone does to z [mm]."""
    every = {**causes, "others": causes["yield_others"] + causes["gear_others"]}
    means = {f"{key}_mean": float(1e3 * z.mean()) for key, z in every.items()}
    means["lowered"] = -means["yield_others_mean"]
    return means | {f"{key}_pv": float(1e3 * np.ptp(z)) for key, z in every.items()}


def printed_numbers(robot: Robot, run: Drawn) -> Numbers:
    """What the printed R_a and R_z say by themselves."""
    job = problem(planned(robot, run.q[len(run.q) // 2][None], targets=()))
    lever = float(np.linalg.norm((job.rigid.p[-1, 0] - job.rigid.origin[0, 3])[:2]))  # joint 3 to tool
    span = 2 * float(stats.norm.isf(0.56 / len(run.q)))  # in σ, of as many readings as samples (Blom)
    constant = least_mean(TABLE_2["ra"][0], TABLE_2["rz"][0])
    return {
        "constant": constant,
        "constant_share": constant / TABLE_2["ra"][0],
        "torque_3_printed": 1e-3 * TABLE_2["ra"][2] / lever * TABLE_1[2],
        "torque_3_ours": float(abs(job.nominal_load.local.ravel()[job.arm.axial[2]])),
        "noise_most": 1e3 * TABLE_2["rz"][2] / span,
        "noise_ours": 1e6 * ALONG,
        "samples": float(len(run.q)),
    }


def stiffness_figure(local: Sequence[LocalStiffness], share: Array) -> Figure:
    """Identified over printed stiffness."""
    value, low, high = (np.array([getattr(f, key) for f in local]) for key in ("value", "low", "high"))
    series = {
        "printed": Series(np.ones(6), colour=PRINTED),
        "true, simulated": Series(share, colour=MODEL),
        "identified, 95 %": Series(value / TABLE_1, low / TABLE_1, high / TABLE_1, OURS),
    }
    title = "Loaded by itself, each joint shows its own stiffness"
    return rows("stiffness", title, [f"joint {j}" for j in range(1, 7)], series, "stiffness over Table I")


def along_figure(name: str, speed: float, run: Drawn, zero: float, numbers: Numbers) -> Figure:
    """z along the spiral, the paper's Fig. 13."""
    keys = ("none", "stiffness", "both")
    ra = ", ".join(mm(numbers[f"ra_{key}_{name}"]) for key in keys)
    error = {COMMANDS[key]: run.error[key] for key in keys}
    return height_figure(name, f"At {speed:g} m/s the mean of |z| is {ra} mm", run.time, error, zero)


def ra_rz_figure(numbers: Numbers) -> Figure:
    """R_a and R_z beside the printed ones."""
    which = [(r, key) for key in ("none", "stiffness", "both") for r in ("ra", "rz")]
    printed = np.array(list(TABLE_2.values())).T.ravel()
    slow, fast = ([numbers[f"{r}_{key}_{speed}"] for r, key in which] for speed in ("slow", "fast"))
    series = {
        "printed": Series(printed, colour=PRINTED),
        "ours, 0.03 m/s": Series(slow, colour=OURS),
        "ours, ten times as fast": Series(fast, colour=NOISE),
    }
    names = [f"R_{r[1]}, {COMMANDS[key].lower()}" for r, key in which]
    title = (
        f"R_a falls from {mm(slow[0])} to {mm(slow[4])} mm; printed: {mm(printed[0])} to {mm(printed[4])} mm"
    )
    return rows("heights", title, names, series, "mm", log=True)


if __name__ == "__main__":
    from workbench.studies.running import main

    main(study)
