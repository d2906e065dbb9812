"""Time and peak memory of `diagnose --json` and `compensate` by the number of poses: prints a table."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

HERE = [sys.executable, "-m", "workbench"]
PATH = "t_s,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg\n"


def measured(call: list[str], folder: Path) -> tuple[int, float, float]:
    """Exit status, seconds and peak memory [MB] of a command in a process of its own."""
    start = time.monotonic()
    with (folder / "said").open("w") as said:
        process = subprocess.Popen(call, stdout=subprocess.DEVNULL, stderr=said)
        _, status, used = os.wait4(process.pid, 0)
    return os.waitstatus_to_exitcode(status), time.monotonic() - start, used.ru_maxrss / 1024


def diagnosed(poses: int, folder: Path) -> tuple[int, float, float]:
    made = [*HERE, "simulate", "kr500", "--random", str(poses), "--seed", "1", "--out", str(folder / "made")]
    subprocess.run([*made, "--effect", "backlash:joint=joint_2,half_width=1e-4", "--approach"],
                   check=True, stdout=subprocess.DEVNULL)  # fmt: skip
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
