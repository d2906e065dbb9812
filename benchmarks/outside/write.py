"""A case as files: its campaign, as `workbench` reads it, and the truth."""

import csv
import json
from pathlib import Path
from typing import Any

from draw import Case
from plan import BROUGHT_KG


def _campaign_toml(case: Case, robot: str) -> str:
    plan = case.plan
    said = ["schema = 1", f'title = "case {case.truth["case"]}"', f'robot = "{robot}"']
    said += ["[poses]", 'file = "poses.csv"', "[points]", 'file = "points.csv"']
    for target, place in enumerate(case.stated_targets_mm, 1):
        said.append(f"[targets.T{target}]")
        said += [] if case.unknown_targets else [f"xyz_mm = [{place[0]}, {place[1]}, {place[2]}]"]
    if plan.noise == "stated":
        said += ["[noise]", f"sigma_mm = {plan.stated_sigma * 1e3:.4f}"]
    for load in (plan.loading.tool, *plan.loading.payloads):
        centre = ", ".join(f"{metres * 1e3:.1f}" for metres in load.centre)
        said.append("[tool]" if load is plan.loading.tool else f"[payloads.{load.name}]")
        said += [f"mass_kg = {load.mass}", f"com_mm = [{centre}]"]
    return "\n".join(said) + "\n"


def _pose_rows(case: Case) -> list[list[Any]]:
    arm, cell, loading, columns = case.plan.arm, case.plan.cell, case.plan.loading, case.plan.columns
    units = ["m" if sliding else "rad" for sliding in arm.sliding]
    head = ["pose_id", *(f"q{joint}_{unit}" for joint, unit in enumerate(units, 1))]
    head += ["payload"] if loading.payloads else []
    head += [f"dir{joint}" for joint in range(1, arm.count + 1)] if columns["directions"] else []
    head += ["t_s"] if columns["times"] else []
    head += ["temp_degC"] if columns["temperatures"] else []
    rows: list[list[Any]] = [head]
    carried = [*(payload.name for payload in loading.payloads), ""]
    for pose, joints in enumerate(cell.joints):
        row = [pose + 1, *(f"{joint:.6f}" for joint in joints)]
        row += [carried[loading.which[pose]]] if loading.payloads else []
        row += [int(way) for way in cell.directions[pose]] if columns["directions"] else []
        row += [f"{cell.seconds[pose]:.1f}"] if columns["times"] else []
        row += [f"{cell.celsius[pose]:.2f}"] if columns["temperatures"] else []
        rows.append(row)
    return rows


def _point_rows(case: Case) -> list[list[Any]]:
    stated = case.plan.noise == "columns"
    sigma = [f"{metres * 1e3:.5f}" for metres in case.plan.sigma] if stated else []
    head = ["pose_id", "target", "x_mm", "y_mm", "z_mm"]
    rows: list[list[Any]] = [head + (["sx_mm", "sy_mm", "sz_mm"] if stated else [])]
    for pose, places in enumerate(case.points, 1):
        for target, place in enumerate(places, 1):
            rows.append([pose, f"T{target}", *(f"{metres * 1e3:.5f}" for metres in place), *sigma])
    return rows


def plain(value: Any) -> Any:
    """NumPy's arrays and numbers as JSON has them."""
    return value.tolist()


def write_case(case: Case, folder: Path) -> dict[str, Any]:
    """Writes campaign.toml, poses.csv and points.csv, and truth.json, which is also returned."""
    folder.mkdir(parents=True, exist_ok=True)
    robot = case.truth["robot"]
    where = robot if robot in BROUGHT_KG else f"../../robots/{robot}/{robot}.toml"
    (folder / "campaign.toml").write_text(_campaign_toml(case, where), encoding="utf-8")
    for name, rows in (("poses.csv", _pose_rows(case)), ("points.csv", _point_rows(case))):
        with open(folder / name, "w", newline="", encoding="utf-8") as file:
            csv.writer(file).writerows(rows)
    truth = json.dumps(case.truth, ensure_ascii=False, indent=1, default=plain)
    (folder / "truth.json").write_text(truth + "\n", encoding="utf-8")
    return json.loads(truth)
