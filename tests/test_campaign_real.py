"""Campaigns: the measured ones load, and what instruments export comes in through a mapping."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from campaign_example import faults, write_example

from workbench.campaign import join, load_campaign

DATA = Path(__file__).parents[1].parent / "shared" / "data"
NO_DATA = f"no measured data at {DATA.parent.name}/{DATA.name} beside the project"
REAL = {
    "irb120-faro": (500, 2991, 6),
    "iiwa7-torque": (304, 912, 3),
    "iiwa7-payload0": (198, 594, 3),
    "ma1400-left": (208, 208, 1),
    "ma1400-right": (212, 212, 1),
    "ur5-tracker": (1000, 1000, 1),
    "ur5-tracker-test": (20, 20, 1),
    "ur10-ipa": (1393, 4179, 3),
    "ur10-ipa-test": (1380, 4140, 3),
}


@pytest.mark.skipif(not DATA.is_dir(), reason=NO_DATA)
@pytest.mark.parametrize("name", REAL)
def test_real_campaigns_load(name: str) -> None:
    campaign = load_campaign(DATA / name / "campaign.toml")
    assert (campaign.n_poses, campaign.n_points, len(campaign.targets)) == REAL[name]
    assert campaign.warnings == ()
    assert np.isfinite(campaign.poses.q).all()


@pytest.mark.skipif(not DATA.is_dir(), reason=NO_DATA)
def test_real_campaigns_of_one_robot_join() -> None:
    both = join([load_campaign(DATA / name / "campaign.toml") for name in ("iiwa7-torque", "iiwa7-payload0")])
    assert [target.name for target in both.targets][::3] == ["P0 (iiwa7-torque)", "P0 (iiwa7-payload0)"]
    assert both.setup_names == ("iiwa7-torque/torque", "iiwa7-payload0/load0")
    assert both.poses.ids[0] == "iiwa7-torque/0"
    assert both.six_dof


@pytest.mark.skipif(not DATA.is_dir(), reason=NO_DATA)
def test_foreign_files_load_through_a_mapping(tmp_path: Path) -> None:
    """A visit has three reflectors; there is no pose column, so here the reflectors are the poses."""
    toml = f"""schema = 1
robot = "robot/tiny.toml"
[poses]
file = "poses.csv"
[points]
file = "{(DATA / "foreign" / "kit_anfahrt_pose1.txt").as_posix()}"
header = false
columns = {{ pose_id = 1, x_mm = 2, y_mm = 3, z_mm = 4 }}
[targets.R]
"""
    poses = "pose_id,q1_deg,q2_rad,q3_mm\n" + "".join(f"{i},{i},0,0\n" for i in range(1, 4))
    campaign = load_campaign(write_example(tmp_path, toml, poses))
    assert campaign.shots.tolist() == [[10]] * 3
    np.testing.assert_allclose(campaign.points[0, 0], [2.2966, -2.4162, -0.4427], atol=2e-4)
    squares, freedom = campaign.shot_scatter
    assert freedom == 81
    assert 1e-5 < np.sqrt(squares / freedom) < 1e-3

    spatial = DATA / "foreign" / "kit_spatialanalyzer_head.txt"
    columns = "columns = { pose_id = 1, target = 2, x_mm = 4, y_mm = 5, z_mm = 6 }"
    toml = toml.replace("kit_anfahrt_pose1.txt", spatial.name).replace("[targets.R]", "[targets.FreeDrive]")
    toml = toml.split("columns")[0] + 'comment = "//"\n' + columns + "\n" + toml.split("}\n")[-1]
    poses = "pose_id,q1_deg,q2_rad,q3_mm\nPose1StatioinaerTrajektorie,0,0,0\n"
    campaign = load_campaign(write_example(tmp_path, toml, poses))
    assert campaign.shots.tolist() == [[200]]
    assert np.sqrt(campaign.shot_scatter[0] / campaign.shot_scatter[1]) < 5e-5

    told = faults(write_example(tmp_path, toml.replace('comment = "//"\n', ""), poses))
    assert any("line 1" in fault and "has 1 columns, not 7" in fault for fault in told)
    told = faults(write_example(tmp_path, toml.replace("pose_id = 1, ", ""), poses))
    assert any(
        "no column pose_id; say which it is: columns = { pose_id = 1, ... }" in fault for fault in told
    )
    told = faults(
        write_example(tmp_path, toml.replace("header = false", 'header = false\nseparator = " "'), poses)
    )
    assert any("columns are separated by ','; say separator = \",\"" in fault for fault in told)
