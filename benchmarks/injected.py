"""Known faults in measured campaigns: python benchmarks/injected.py FOLDER [SEED [POSES [NAME ...]]]

FOLDER holds campaigns (NAME/campaign.toml) that are read in place. Of each, some poses drawn at random are
diagnosed as they are, and with one fault more: a joint that went elsewhere than it was told, by so much as a
ratio, a run-out, a gear's line, a bump, a coupling of the wrist or a yield under Drake's gravity makes it, or
by a function of another joint, which has no name. Noise, structure and all else are as measured; what was put
in is known, each in a form that the program does not have.
Writes `benchmarks/results/injected.json`: of faults that show (beyond the model that is found without them,
its numbers fitted anew, by half of what that leaves or more) whether they are named, among the causes, or
neither; and what is named that is neither among the causes as it is nor was put in.
"""

import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from blind import git
from halves import named, said
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from workbench import Array, Campaign, Fit, Outcome, diagnose, load_campaign, problem_of
from workbench import fit as fit_model
from workbench.files.faults import InputError

RESULTS = Path(__file__).resolve().parent / "results/injected.json"
KINDS = ("ratio", "run_out", "line", "bump", "coupling", "yield", "of_another")
NAMES = {
    "ratio": ("gear_ratio", "joint_map", "hose_torque"),
    "run_out": ("gear_eccentricity", "joint_map"),
    "line": ("gear_kinematic_error", "joint_map"),
    "bump": ("joint_map",),
    "coupling": ("wrist_coupling",),
    "yield": ("joint_compliance", "lost_motion"),
    "of_another": (),
}
SHOWS = 0.5  # of the error that a diagnosis leaves


def gravity(campaign: Campaign) -> Array:
    """(N, n) torques [N·m, N] with which the weights of the URDF's links pull on the joints."""
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(campaign.robot.urdf))
    if plant.GetFrameByName(campaign.robot.base).body().index() != plant.world_body().index():
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(campaign.robot.base))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    joints = [plant.GetJointByName(name) for name in campaign.robot.joint_names]
    place = [joint.position_start() for joint in joints]
    velocity = [joint.velocity_start() for joint in joints]
    out = np.zeros_like(campaign.poses.q)
    for torque, pose in zip(out, campaign.poses.q, strict=True):
        q = np.zeros(plant.num_positions())
        q[place] = pose
        plant.SetPositions(context, q)
        torque[:] = plant.CalcGravityGeneralizedForces(context)[velocity]
    return out


def fault(kind: str, campaign: Campaign, rng: np.random.Generator) -> tuple[Array, int, str]:
    """How far the joints (N, n) [rad] go elsewhere; in which; and the place that a name of it has."""
    q, names = campaign.poses.q, campaign.robot.joint_names
    n = q.shape[1]
    j = int(rng.integers(n - 2, n)) if kind == "coupling" else int(rng.integers(min(n, 4)))
    size = rng.uniform(2e-4, 8e-4)
    x, other = q[:, j] - np.median(q[:, j]), j
    if kind == "ratio":
        way = x + 0.05 * x**2
    elif kind == "run_out":
        way = np.cos(q[:, j] + rng.uniform(0, 6)) + 0.1 * np.cos(3 * q[:, j])
    elif kind == "line":
        phase = rng.uniform(15, 110) * q[:, j]
        way = np.sin(phase) + 0.15 * np.sin(2 * phase + 1)
    elif kind == "bump":
        way = np.exp(-((x / 0.3) ** 2))
    elif kind == "coupling":
        other = j - 1
        way = q[:, other] + 0.05 * np.sin(3 * q[:, other])
    elif kind == "yield":
        torque = gravity(campaign)
        j = other = int(np.argmax(np.ptp(torque, axis=0) * rng.uniform(0.5, 1.0, n)))
        way = torque[:, j] * np.abs(torque[:, j] / max(np.abs(torque[:, j]).max(), 1e-9)) ** -0.1
    else:
        other = int(rng.choice([k for k in range(min(n, 4)) if k != j]))
        way = np.sin(1.7 * q[:, other] + 1)
    spread = float(np.std(way))
    out = np.zeros_like(q)
    if spread > 1e-9:
        out[:, j] = size * (way - way.mean()) / spread
    return out, j, names[j] if other == j else f"{names[j]}, {names[other]}"


def shows(campaign: Campaign, fit: Fit) -> float:
    """RMS length [mm] of what a campaign has beyond a diagnosis' model, its numbers fitted to it anew."""
    model = replace(fit.model, problem=problem_of(campaign))
    again = fit_model(model, fit.state, fit.noise, tolerance=1e-2)
    rms = [np.sqrt(3 * np.nanmean(one.residual**2)) for one in (again, fit)]
    return 1e3 * float(np.sqrt(max(rms[0] ** 2 - rms[1] ** 2, 0.0)))


def judged(kind: str, as_it_is: Outcome, rng: np.random.Generator) -> dict[str, Any]:
    campaign = as_it_is.problem.campaign
    moved, j, place = fault(kind, campaign, rng)
    worse = campaign.with_poses(q=campaign.poses.q - moved)
    own, beyond = campaign.robot.joint_names[j], shows(worse, as_it_is.fit)
    found = diagnose(worse).diagnosis
    return {
        "kind": kind,
        "where": place,
        "shows_mm": round(beyond, 4),
        "seen": bool(beyond > SHOWS * 1e3 * np.sqrt(3 * np.nanmean(as_it_is.fit.residual**2))),
        "named": any(_is(name, NAMES[kind], own) for name in named(found)),
        "said": any(_is(name, NAMES[kind], own) for name in said(found)),
        "unknown": any(f.cause == "unknown" for f in found.causes),
        "also_named": sorted(
            name for name in named(found) - said(as_it_is.diagnosis) if not _is(name, NAMES[kind], own)
        ),
        "left_mm": round(found.stages[-1].heldout_rms_mm, 4),
    }


def _is(label: str, causes: tuple[str, ...], joint: str) -> bool:
    """Whether a label is one of some causes, in a joint."""
    cause, _, place = label.removesuffix(")").partition("(")
    return cause in causes and joint in [word.strip() for word in place.replace("|", ",").split(",")]


def main(folder: Path, seed: int = 1, poses: int = 200, *names: str) -> int:
    kept: dict[str, Any] = {"commit": git("rev-parse", "--short", "HEAD"), "seed": seed, "campaigns": {}}
    for path in sorted(folder.glob("*/campaign.toml")):
        name, rng, began = path.parent.name, np.random.default_rng(seed), time.process_time()
        if names and name not in names:
            continue
        try:
            whole = load_campaign(path)
            campaign = whole.some(np.sort(rng.permutation(len(whole.poses))[:poses]))
            as_it_is = diagnose(campaign)
            found = [judged(kind, as_it_is, rng) for kind in KINDS]
        except InputError as error:
            print(f"{name}: {error}", flush=True)
            continue
        names_before = sorted(named(as_it_is.diagnosis))
        kept["campaigns"][name] = {"named_as_it_is": names_before, "faults": found}
        print(f"{name}: {time.process_time() - began:.0f} s of CPU; as it is {names_before}")
        for one in found:
            print("  ", one, flush=True)
        RESULTS.write_text(json.dumps(kept, ensure_ascii=False, indent=1) + "\n", encoding="utf-8")
    every = [one for campaign in kept["campaigns"].values() for one in campaign["faults"] if one["seen"]]
    real = [one for one in every if NAMES[one["kind"]]]
    print(f"seen {len(real)}: named {sum(o['named'] for o in real)}, said {sum(o['said'] for o in real)}")
    nameless = [one for one in every if not NAMES[one["kind"]]]
    print(f"without a name, seen {len(nameless)}: unknown {sum(o['unknown'] for o in nameless)}")
    print(f"wrong names: {[o['also_named'] for o in every if o['also_named']]}")
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), *map(int, sys.argv[2:4]), *sys.argv[4:]))
