"""Processor time and peak memory of `diagnose --json` and `compensate` by number of poses: prints a table."""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.campaign import Campaign, write_campaign
from workbench.campaign.planned import planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.effects.records import parse_effect, stated_effects
from workbench.identification.model import Model
from workbench.robot.description import load_robot
from workbench.robot.rigid_plant import arrays
from workbench.simulation.virtual_campaign import random_geometry

HERE = [sys.executable, "-m", "workbench"]
PATH = "t_s,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n"
BLOCK = 50_000  # poses that are made at a time
HIDDEN = "backlash:joint=joint_2,half_width=1e-4"
SIGMA = 3e-5  # m


def measured(call: list[str], folder: Path) -> tuple[int, float, float]:
    """Exit status, seconds of processor time and peak memory [MB] of a command in a process of its own."""
    with (folder / "said").open("w") as said:
        process = subprocess.Popen(call, stdout=subprocess.DEVNULL, stderr=said)
        _, status, used = os.wait4(process.pid, 0)
    return os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def blocks(poses: int) -> Iterator[Campaign]:
    """A campaign of a KR 500 with a backlash, in blocks; by the batch arithmetic, faster than in Drake."""
    robot, rng = load_robot("kr500"), np.random.default_rng([1, 11])
    bent = random_geometry(arrays(robot), rng)
    for start in range(0, poses, BLOCK):
        count = min(BLOCK, poses - start)
        ids = tuple(str(start + row) for row in range(1, count + 1))
        q = random_poses(robot, count, rng)
        plan = planned(robot, q, direction=rng.choice([-1.0, 1.0], size=q.shape)).with_poses(ids=ids)
        job = problem_of(plan)
        effect, values = parse_effect(HIDDEN, job)
        model = Model(job, (effect,), stated_effects(job))
        state = model.start(np.eye(3)[None], np.array([[3.0, 1.0, -1.0]]), job.stated_targets[None])
        points = model.predict(replace(state, geometry=job.arm.geometry + bent, values=(values,)))
        noise = rng.normal(scale=SIGMA, size=points.shape)
        shots = np.ones(points.shape[:2], np.int64)
        yield replace(plan, points=points + noise, shots=shots, noise_sigma=SIGMA)


def diagnosed(poses: int, folder: Path) -> tuple[int, float, float]:
    for number, block in enumerate(blocks(poses)):
        write_campaign(folder / "block", block)
        if number == 0:
            shutil.copytree(folder / "block", folder / "made")
            continue
        for name in ("poses.csv", "points.csv"):
            _, _, rows = (folder / "block" / name).read_text().partition("\n")
            with (folder / "made" / name).open("a") as whole:
                whole.write(rows)
    return measured([*HERE, "diagnose", str(folder / "made/campaign.toml"), "--json"], folder)


def compensated(points: int, folder: Path) -> tuple[int, float, float]:
    t = np.arange(points) * 0.012
    q = [10 * np.sin(0.1 * (i + 1) * t) + (0, -60, 60, 0, 40, 0)[i] for i in range(6)]
    with (folder / "path.csv").open("w") as file:
        file.write(PATH)
        np.savetxt(file, np.column_stack([t, *q]), fmt="%.6f", delimiter=",")
    call = [*HERE, "compensate", str(folder / "path.csv"), "--model", "kr500", "--format", "csv"]
    return measured([*call, "--out", str(folder / "out.csv")], folder)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", choices=("diagnose", "compensate"))
    parser.add_argument("numbers", type=int, nargs="+")
    arguments = parser.parse_args()
    of = {"diagnose": diagnosed, "compensate": compensated}[arguments.what]
    for number in arguments.numbers:
        with tempfile.TemporaryDirectory() as name:
            status, seconds, memory = of(number, Path(name))
            each = 1e3 * seconds / number
            row = f"| {arguments.what} | {number} | {seconds:.1f} s | {each:.2f} ms | {memory:.0f} MB |"
            print(row if status == 0 else f"{row} exit {status}", flush=True)
            if status:
                print((Path(name) / "said").read_text()[-500:])


if __name__ == "__main__":
    main()
