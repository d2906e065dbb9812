"""The whole loop on a simulated KR 500: measure, diagnose, settle what stays open by the follow-ups that are
offered, extend the model, correct a path, prove it.

Hidden in the robot: a harmonic-drive error in joint 4 (with a second harmonic), a gas compensator that has
lost a tenth of its charge, a joint 3 that yields a quarter more than the model says, backlash in joint 5, and
an ordinary robot's errors of geometry. The campaigns are what a laser tracker would see of Drake's loaded
robot; nothing else reaches the diagnosis. In the first the robot carries its tool alone, and what yields
where stays open.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench import (
    Array,
    Campaign,
    Diagnosis,
    Finding,
    Outcome,
    Revealed,
    Truth,
    Verified,
    Where,
    compensate_file,
    diagnose,
    follow_up,
    load_campaign,
    load_robot,
    loaded,
    moved_base,
    numbers,
    own_base,
    parse_effect,
    path_shapes,
    planned,
    problem_of,
    random_geometry,
    random_poses,
    record,
    rotation_about,
    short_verdict,
    simulate,
    verify_file,
    what_decides,
    write_campaign,
    write_fit,
    write_model,
    write_outcome,
    write_path,
)

Progress = Callable[[str], None]

HIDDEN = (
    "gear_kinematic_error:joint=joint_4,order={order},amplitude=2.2e-4,phase=0.6",
    "gear_kinematic_error:joint=joint_4,order={double},amplitude=4.4e-5,phase=1.1",
    "gravity_compensator:variant=charge,relative=-0.10",
    "joint_compliance:joint=joint_3,relative=0.25",
    "backlash:joint=joint_5,half_width=6e-5",
)
PAYLOADS = {"heavy": (250.0, (0.0, 0.0, 0.15))}
TORQUE_NOISE = 0.03  # of a joint's largest torque, as motor currents have it
FOLLOW_UPS, MOST_POSES = 2, 100  # at most, and of so many poses each
TOOL = (60.0, (0.0, 0.0, 0.08))


@dataclass(frozen=True)
class Rig:
    """What is measured, without anyone knowing. truth: of the robot; frame: R (1, 3, 3), t (1, 3) [m] of the
    base in the instrument's frame; seed: of the noise."""

    truth: Truth
    frame: tuple[Array, Array]
    seed: int

    def measure(self, plan: Campaign, day: int, torque: bool) -> Campaign:
        """The plan's poses, as the tracker saw them that day; torque: with what the drives exerted."""
        sigma = TORQUE_NOISE if torque else None
        return simulate(
            plan, self.truth, seed=self.seed + 1000 * day, instrument=self.frame, torque_sigma=sigma
        )


@dataclass(frozen=True)
class Summary:
    """What the demo found and where it lies. first: what the first campaign left open; measured_then:
    the follow-up that it offered."""

    first: Outcome
    outcome: Outcome
    measured_then: str
    proof: Verified
    folder: Path

    @property
    def text(self) -> str:
        verdict = short_verdict(self.outcome.diagnosis, self.folder)
        before = f"First campaign: {self.first.diagnosis.headline}\n{self.measured_then}"
        return f"{before}\n\n{verdict}\n\n{self.proof.text}\n\nopen {self.folder}/index.html"

    def to_json(self) -> dict[str, Any]:
        return {
            "first": self.first.diagnosis.to_json(),
            "diagnosis": self.outcome.diagnosis.to_json(),
            "proof": self.proof.to_json(),
        }


def demo(folder: Path, seed: int, progress: Progress, quick: bool = False) -> Summary:
    """Runs the demo and writes everything under `folder`."""
    progress("measuring a KR 500 in Drake: its tool alone, three targets, 30 µm noise")
    poses, rig = prepared(seed, 60 if quick else 100)
    campaign = _measured(folder / "campaign", rig, poses, 0)
    first = what_decides(diagnose(campaign, None, progress, seed))
    measured_then, command, outcome = _settled(folder / "follow-up", rig, campaign, first, seed, progress)
    progress("correcting a circle and running it on the simulated robot in closed loop")
    proof = _prove(folder / "path", outcome, rig, seed, quick, progress)
    slow = proof.found.slow.trials
    before, after = slow["uncorrected"].figures.rms_mm, slow["corrected"].figures.rms_mm
    anew = proof.found.anew_rms_mm
    place = "" if anew is None else f" ({numbers.mm(anew)} mm once its base is taken anew)"
    words = (
        f"In closed loop the simulated robot draws a circle {numbers.mm(before)} mm off as it is{place}, and "
        f"{numbers.mm(after)} mm off with the commands that this model corrects (RMS)."
    )
    revealed = _revealed(rig.truth, first.diagnosis, outcome.diagnosis, (measured_then, command))
    proven = replace(outcome.diagnosis, proof=(words, "path/verify.html"), revealed=revealed)
    outcome = replace(outcome, diagnosis=proven)
    progress("writing the page, the report and the scene")
    write_outcome(first, folder / "first")
    write_outcome(outcome, folder)
    return Summary(first, outcome, f"{measured_then}\n{command}".strip(), proof, folder)


def prepared(seed: int, poses: int) -> tuple[Campaign, Rig]:
    """The poses of the first campaign, and the robot with what is hidden in it."""
    rng = np.random.default_rng([seed, 500])
    robot = load_robot("kr500")
    q = random_poses(robot, poses, rng, share=0.8)
    plan = planned(
        robot,
        q,
        payloads=PAYLOADS,
        tool=TOOL,
        direction=rng.choice([-1.0, 1.0], size=q.shape),
        title="KR 500, laser tracker",
    )
    # the tool plate was measured beforehand: the targets' places are known
    plan = replace(plan, targets=tuple(replace(target, fixed=True) for target in plan.targets))
    problem = problem_of(plan)
    order = 2 * (robot.joints[3].data.gear_ratio or 100.0)
    truth = Truth(
        geometry=random_geometry(problem.arm, rng),
        effects=tuple(parse_effect(text.format(order=order, double=2 * order), problem) for text in HIDDEN),
        sigma=3e-5,
    )
    frame = rotation_about("z", 2.2)[None], np.array([[3.2, -1.4, -0.6]])
    return plan, Rig(truth, frame, seed)


def _measured(folder: Path, rig: Rig, plan: Campaign, day: int, torque: bool = False) -> Campaign:
    """The campaign of a plan, written and read again as anyone's; torque: with those of the drives."""
    path = write_campaign(folder, rig.measure(plan, day, torque), comments=["simulated in Drake"])
    return load_campaign(path)


def _settled(
    folder: Path, rig: Rig, campaign: Campaign, first: Outcome, seed: int, progress: Progress
) -> tuple[str, str, Outcome]:
    """The follow-ups that diagnoses offer, one after the other, in words and as commands, and what all
    campaigns say together; the diagnosis as it is where it offers none."""
    outcome, campaigns, said, commands = first, [campaign], list[str](), list[str]()
    for day in range(1, 1 + FOLLOW_UPS):
        every = (way for one in outcome.diagnosis.causes for way in one.decide)
        way = next((way for way in every if way.command and (way.poses or np.inf) <= MOST_POSES), None)
        if way is None or way.command is None:
            break
        progress(f"to decide: {way.words}")
        whole = campaign if day == 1 else outcome.prepared.problem.campaign
        made = follow_up(whole, way, seed=seed, quick=True, progress=progress)
        if made.drive is None:
            said.append("The poses that were asked for cannot be driven.")
            break
        place = folder if day == 1 else folder.with_name(f"{folder.name}-{day}")
        torque = "--torque" in way.command
        campaigns.append(_measured(place, rig, made.drive.records, day, torque))
        outcome = what_decides(diagnose(campaigns, None, progress, seed))
        what = "the first campaign" if day == 1 else "both"
        more = f"{len(made.drive.own.poses)} poses more{' with the torques of the drives' * torque}"
        minutes = made.drive.total_s / 60
        said.append(f"To decide what {what} left open, {more} were planned ({minutes:.0f} min).")
        commands.append(way.command)
    return " ".join(said) or "No more poses were asked for.", "\n".join(commands), outcome


def _revealed(truth: Truth, first: Diagnosis, then: Diagnosis, follow_up: tuple[str, str]) -> Revealed:
    """What was hidden, beside what each diagnosis said of it; and what they named that was not there."""
    hidden: dict[tuple[str, Where], list[str]] = {}
    for effect, values in truth.effects:
        hidden.setdefault((effect.cause, effect.where.any_order), []).append(effect.sentence(values))
    rows = [(" ".join(lines), _said(first, key), _said(then, key)) for key, lines in hidden.items()]
    said = (one for one in (*first.causes, *then.causes) if not hidden.keys() & _open_between(one))
    for key in dict.fromkeys(map(_key, said)):
        if key not in hidden:
            rows.append(("Nothing of this", _said(first, key), _said(then, key)))
    return Revealed(*follow_up, "first/index.html", tuple(rows))


def _open_between(finding: Finding) -> set[tuple[str, Where]]:
    """The causes that a finding leaves open; nothing where it names one."""
    rivals = {(rival.cause, rival.where.any_order) for rival in finding.rivals}
    return set() if finding.status == "named" else {_key(finding), *rivals}


def _said(diagnosis: Diagnosis, key: tuple[str, Where]) -> str:
    """What a diagnosis said of a cause: its finding, or between what it is open."""
    for finding in diagnosis.causes:
        both = [_key(finding), *((rival.cause, rival.where.any_order) for rival in finding.rivals)]
        if key == both[0] and finding.status == "named":
            return finding.sentence
        if key in both:
            return f"Open: {', or '.join(_words(cause, where) for cause, where in dict.fromkeys(both))}."
    return "–"


def _key(finding: Finding) -> tuple[str, Where]:
    return finding.cause, finding.where.any_order


def _words(cause: str, where: Where) -> str:
    return f"{numbers.words(cause)} in {where}" if str(where) else numbers.words(cause)


def _prove(
    folder: Path,
    outcome: Outcome,
    rig: Rig,
    seed: int,
    quick: bool,
    progress: Progress,
) -> Verified:
    """Corrects a circle by the diagnosed model and runs it on the true robot."""
    folder.mkdir(parents=True, exist_ok=True)
    write_fit(folder / "model.toml", outcome.fit)
    _write_truth(folder / "truth.toml", outcome, rig)
    frame_of_work = path_shapes.work_frame([1.9, 0.3, 1.1])
    run = path_shapes.Run(frame_of_work, speed=0.05, acceleration=0.5, period=0.01)
    shape = path_shapes.circle(0.03 if quick else 0.06, run)
    write_path(folder / "circle.csv", shape)
    compensate_file(folder / "circle.csv", folder / "model.toml", "krl", folder / "circle.src")
    return verify_file(
        folder / "circle.csv",
        folder / "model.toml",
        folder / "truth.toml",
        folder,
        speeds=(0.05,),
        repeats=0 if quick else 3,
        seed=seed,
        workers=2,
        progress=progress,
    )


def _write_truth(path: Path, outcome: Outcome, rig: Rig) -> None:
    """The true robot, standing where the model has its base.

    A tracker sees where the robot is, not where its base's drawing is: what the fit put into the frame
    instead of the first joint is the same robot in other coordinates.
    """
    problem, state = outcome.problem, outcome.fit.state
    truth, (R, t) = rig.truth, rig.frame
    R_model, t_model = own_base(problem, state.geometry).seen(state.R[0], state.t[0])
    assert truth.geometry is not None
    geometry = moved_base(problem.arm, truth.geometry, R_model.T @ R[0], R_model.T @ (t[0] - t_model))
    records = [record(effect, values) for effect, values in truth.effects]
    write_model(path, loaded(problem.robot, problem.campaign), geometry, records)
