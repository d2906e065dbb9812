"""Campaigns: loaded into arrays, with a word on whatever is left out or looks doubtful."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from campaign_example import POINTS, POSES, TOML, faults, write_example

from workbench.campaign import Campaign, Target, load_campaign
from workbench.campaign.flange_load import external_forces
from workbench.files.faults import InputError


def warnings(campaign: Campaign) -> list[str]:
    return [line.replace(f"{campaign.path.parent}/", "") for line in campaign.warnings]


def test_loads_in_si(tmp_path: Path) -> None:
    campaign = load_campaign(write_example(tmp_path))
    assert campaign.title == "Tiny"
    assert campaign.robot.name == "tiny"
    assert campaign.poses.ids == ("a", "b", "c")
    np.testing.assert_allclose(campaign.poses.q[1], [np.deg2rad(-20), 0.25, 0.2])
    assert campaign.targets == (Target("T1", (0.1, 0.0, 0.05)), Target("T2", None, "link_2"))
    np.testing.assert_allclose(campaign.points[0, 0], [1.0, 2.0, 3.0])
    assert campaign.shots.tolist() == [[1, 1], [1, 0], [1, 0]]
    assert np.isnan(campaign.points[1, 1]).all()
    assert (campaign.n_poses, campaign.n_points, campaign.seen.sum()) == (3, 4, 4)
    assert campaign.payload_names == ("", "heavy")
    assert campaign.load_mass.tolist() == [0.0, 250.0]
    np.testing.assert_allclose(campaign.load_com, [[0, 0, 0], [0.15, 0, 0.01]])
    assert campaign.poses.payload.tolist() == [0, 0, 0]
    assert campaign.setup_names == ("",)
    assert campaign.poses.wrench.tolist() == [[0.0] * 6] * 3
    optional = ("side", "time", "temperature", "torque", "readback")
    assert [getattr(campaign.poses, name) for name in optional] == [None] * 5
    assert campaign.sigma is campaign.noise_sigma is None
    assert campaign.shot_scatter == (0.0, 0)
    names = ["campaign.toml", "poses.csv", "points.csv"]
    assert list(campaign.files)[:3] == [f"{tmp_path.name}/{name}" for name in names]
    assert list(campaign.files)[3:] == ["robot/tiny.toml", "robot/tiny.urdf"]
    assert warnings(campaign) == ["campaign.toml: payload 'heavy' is at no measured pose"]


def test_a_folder_is_its_campaign(tmp_path: Path) -> None:
    folder = tmp_path / "measured"
    folder.mkdir()
    path = write_example(folder)
    assert load_campaign(folder).path == path
    with pytest.raises(InputError, match="is a folder, not a file"):
        load_campaign(tmp_path)


def test_forces_as_load_cells_show_them(tmp_path: Path) -> None:
    """kilograms-force were "not used": moments alone then pulled at the arm."""
    poses = (
        "pose_id,q1_deg,q2_deg,q3_m,fx_kgf,fy_daN,fz_lbf,mx_Nmm\n"
        "a,10,20,0.1,100,-2,1,500\n"
        "b,10,20,0.2,0,0,0,0\n"
        "c,10,20,0.3,0,0,0,0\n"
    )
    campaign = load_campaign(write_example(tmp_path, poses=poses))
    np.testing.assert_allclose(campaign.poses.wrench[0], [980.665, -20, 4.4482216152605, 0.5, 0, 0])
    assert external_forces(campaign) == "in 1 of 3 poses, up to 980.9 N and 0.5 N·m at the flange's origin"


def test_optional_columns(tmp_path: Path) -> None:
    poses = (
        "pose_id,q1_deg,q2_deg,q3_m,payload,fz_N,mx_Nm,dir1,dir3,t_s,temp_degC,"
        "tau1_Nm,tau2_Nm,tau3_N,setup,r1_deg,r2_rad,r3_mm\n"
        "a,10,20,0.1,heavy,-5,6,1,-1,0,21,1,2,3,second,10.1,0.35,100.1\n"
        "b,10,20,0.2,,0,0,0,1,60,,,,,first,,,\n"
        "c,10,20,0.3,heavy,0,0,-1,0,61.5,22,1,2,3,second,10,0.3,100\n"
    )
    toml = TOML.replace('on = "link_2"\n', "")  # a 6-D measurement is of one body
    toml += "[noise]\nsigma_mm = 0.03\npose = true\n[tool]\nmass_kg = 60\ncom_mm = [1, 2, 3]\n"
    campaign = load_campaign(write_example(tmp_path, toml, poses))
    assert campaign.poses.payload.tolist() == [1, 0, 1]
    np.testing.assert_allclose(campaign.poses.wrench[0], [0, 0, -5, 6, 0, 0])
    assert campaign.poses.side is not None
    assert campaign.poses.side.tolist() == [[1, 0, -1], [0, 0, 1], [-1, 0, 0]]
    assert campaign.poses.time is not None
    assert campaign.poses.time.tolist() == [0, 60, 61.5]
    assert campaign.poses.temperature is not None
    assert np.isnan(campaign.poses.temperature).tolist() == [False, True, False]
    assert campaign.poses.torque is not None
    assert campaign.poses.torque[2].tolist() == [1, 2, 3]
    assert campaign.poses.readback is not None
    np.testing.assert_allclose(campaign.poses.readback[0], [np.deg2rad(10.1), 0.35, 0.1001])
    assert campaign.setup_names == ("second", "first")
    assert campaign.poses.setup.tolist() == [0, 1, 0]
    assert campaign.noise_sigma == pytest.approx(3e-5)
    assert campaign.six_dof
    assert campaign.tool_mass == 60.0
    np.testing.assert_allclose(campaign.tool_com, [1e-3, 2e-3, 3e-3])


def test_shots_are_averaged_and_their_scatter_pooled(tmp_path: Path) -> None:
    points = (
        "pose_id,target,x_mm,y_mm,z_mm,sx_mm,sy_mm,sz_mm\n"
        "a,T1,10,20,30,0.1,0.1,0.1\nb,T1,1,1,1,1,1,1\na,T1,12,20,30,0.1,0.2,0.1\n"
        "c,T1,1,2,3,1,1,1\nc,T1,1,2,3,1,1,1\nc,T1,1,2,6,1,1,1\n"
    )
    campaign = load_campaign(write_example(tmp_path, points=points))
    assert campaign.shots.tolist() == [[2], [1], [3]]
    np.testing.assert_allclose(campaign.points[:, 0], [[0.011, 0.02, 0.03], [1e-3] * 3, [1e-3, 2e-3, 4e-3]])
    squares, freedom = campaign.shot_scatter
    assert freedom == 3 * (1 + 2)
    assert squares == pytest.approx(2e-6 + 6e-6)
    assert campaign.sigma is not None
    np.testing.assert_allclose(campaign.sigma[0, 0] * 1e3, [0.02**0.5 / 2, 0.05**0.5 / 2, 0.02**0.5 / 2])
    np.testing.assert_allclose(campaign.sigma[2, 0] * 1e3, [3**-0.5] * 3)


def test_blank_sigma_falls_back_on_the_noise_stated_for_all(tmp_path: Path) -> None:
    points = "pose_id,target,x_mm,y_mm,z_mm,sx_mm,sy_mm,sz_mm\na,T1,10,20,30,,,\nb,T1,1,1,1,1,1,1\n"
    campaign = load_campaign(write_example(tmp_path, TOML + "[noise]\nsigma_mm = 0.5\n", points=points))
    assert campaign.sigma is not None
    np.testing.assert_allclose(campaign.sigma[:, 0, 0], [5e-4, 1e-3])
    told = faults(write_example(tmp_path, points=points))
    assert told[0].startswith("points.csv line 2: sx_mm is empty; give it for every point, or state [noise]")


def test_an_uncertainty_of_nothing_is_none(tmp_path: Path) -> None:
    """As trackers write it of a single shot: one word for all lines, and [noise] mends it."""
    points = "pose_id,target,x_mm,y_mm,z_mm,sx_mm,sy_mm,sz_mm\na,T1,1,2,3,.5,0,.5\nb,T1,1,2,3,0,0,0\n"
    (told,) = faults(write_example(tmp_path, points=points))
    assert told.startswith(
        "points.csv line 2: sx_mm, sy_mm, sz_mm: an uncertainty of 0 (2 of 2 lines) is none"
    )
    campaign = load_campaign(write_example(tmp_path, TOML + "[noise]\nsigma_mm = 0.1\n", points=points))
    assert campaign.sigma is not None
    np.testing.assert_allclose(campaign.sigma[:, 0], [[5e-4, 1e-4, 5e-4], [1e-4, 1e-4, 1e-4]])


def test_names_are_advised_as_toml_has_them(tmp_path: Path) -> None:
    name = "TMC 30-B #5320"
    points = f"pose_id,target,x_mm,y_mm,z_mm\na,{name},1,2,3\nb,{name},1,2,3\n"
    path = write_example(tmp_path, points=points)
    (said,) = [line for line in warnings(load_campaign(path)) if "not declared" in line]
    advice = said.rpartition("declare ")[2]
    assert advice == f'[targets."{name}"]'
    path.write_text(TOML + f"{advice}\nxyz_mm = [1, 2, 3]\n")
    assert Target(name, (1e-3, 2e-3, 3e-3)) in load_campaign(path).targets
    path.write_text(TOML + f'{advice}\non = "nowhere"\n')
    assert any(f'targets."{name}".on: ' in told for told in faults(path))


def test_targets_that_nobody_declared_are_told_together(tmp_path: Path) -> None:
    points = "pose_id,target,x_mm,y_mm,z_mm\n" + "".join(f"a,SMR{i},{i},2,3\n" for i in (1, 2, 3))
    (said,) = [
        line for line in warnings(load_campaign(write_example(tmp_path, points=points))) if "declared" in line
    ]
    assert said == (
        "points.csv line 2: targets 'SMR1', 'SMR2', 'SMR3' are not declared: taken on the flange, their "
        "places unknown; declare [targets.SMR1] and so on"
    )


def test_what_is_left_out_is_told(tmp_path: Path) -> None:
    points = "pose_id,target,x_mm,y_mm,z_mm\nc,T1,1000,2,3\nz,T1,1,2,3\nz,T1,1,2,3\na,t1,4,5,6\n"
    campaign = load_campaign(write_example(tmp_path, points=points))
    assert campaign.poses.ids == ("a", "c")
    assert campaign.targets == (Target("T1", (0.1, 0.0, 0.05)), Target("t1"))
    assert campaign.shots.tolist() == [[0, 1], [1, 0]]
    assert warnings(campaign) == [
        "points.csv: target 'T2' was never measured, left out",
        "points.csv line 5: target 't1' is not declared: taken on the flange, its place unknown; "
        "did you mean 'T1'?",
        "points.csv: 2 points of 1 pose ('z') unknown to poses.csv, left out",
        "poses.csv: 1 pose ('b') without points, left out",
        "campaign.toml: payload 'heavy' is at no measured pose",
    ]


def test_doubtful_sizes_are_warnings(tmp_path: Path) -> None:
    poses = "pose_id,q1_rad,q2_deg,q3_mm,temp_degC,remark\na,150,0,100,300,\nb,0,150,600,20,\nc,0,0,0,20,x\n"
    points = "pose_id,target,x_mm,y_mm,z_mm\na,T1,1,2,3\nb,T2,0,0,0\n"
    campaign = load_campaign(write_example(tmp_path, poses=poses, points=points))
    assert warnings(campaign)[:6] == [
        "poses.csv line 2: q1_rad turns 24 times; are these degrees?",
        "poses.csv line 3: q2_deg beyond the limits of joint_2 (at 1 of 3 poses)",
        "poses.csv line 3: q3_mm beyond the limits of rail (at 1 of 3 poses)",
        "points.csv: all points within 3.0 mm of the origin; are these metres?",
        "points.csv line 3: point at exactly 0 0 0 (1 such lines); not seen? leave it out",
        "poses.csv: temp_degC is outside -30 .. 65 degC; is the unit right?",
    ]
    assert "poses.csv: column 'remark' is not used" in warnings(campaign)


@pytest.mark.parametrize(
    ("times", "said"),
    [
        ((0, 60, 120), None),
        ((0, 1e7, 2e7), "poses.csv: by t_s the campaign lasts 231 days; are these seconds?"),
        (
            (0, 120, 60),
            "poses.csv line 4: t_s is earlier than in the line before (1 such lines); is it one clock?",
        ),
    ],
)
def test_doubtful_times_are_warnings(tmp_path: Path, times: tuple[float, ...], said: str | None) -> None:
    rows = "".join(f"{name},0,0,100,{t:.0f}\n" for name, t in zip("abc", times, strict=True))
    points = "pose_id,target,x_mm,y_mm,z_mm\na,T1,1000,2,3\nb,T2,900,0,0\nc,T1,800,5,1\n"
    campaign = load_campaign(
        write_example(tmp_path, poses=f"pose_id,q1_deg,q2_deg,q3_mm,t_s\n{rows}", points=points)
    )
    assert [line for line in warnings(campaign) if "t_s" in line] == ([said] if said else [])


def test_numbers_as_names_stay_texts(tmp_path: Path) -> None:
    toml = TOML.replace("targets.T1", "targets.1").replace("targets.T2", 'targets."2.0"')
    points = "pose_id,target,x_mm,y_mm,z_mm\n 1,1,1000,2,3\n1 , 2.0,1,2,3\n1.0,1,1,2,3\n"
    poses = "pose_id,q1_deg,q2_deg,q3_mm\n1,10,0.5,100\n1.0,-20,0.25,200\n"
    campaign = load_campaign(write_example(tmp_path, toml, poses, points))
    assert campaign.poses.ids == ("1", "1.0")
    assert [target.name for target in campaign.targets] == ["1", "2.0"]
    assert campaign.shots.tolist() == [[1, 1], [1, 0]]


def test_single_target_needs_no_column(tmp_path: Path) -> None:
    toml = TOML.replace('[targets.T2]\non = "link_2"\n', "").replace(
        'file = "points.csv"',
        'file = "points.csv"\nheader = false\ncolumns = { pose_id = 1, x_mm = 2, y_mm = 3, z_mm = 4 }',
    )
    campaign = load_campaign(write_example(tmp_path, toml, points="a, 2296.49, -2416.25, -442.56\n"))
    assert campaign.targets == (Target("T1", (0.1, 0.0, 0.05)),)
    assert "points.csv: no column target, so all points are of 'T1'" in warnings(campaign)


def test_targets_on_base_flange_and_links(tmp_path: Path) -> None:
    for on, is_on in (
        ("tool0", "flange"),
        ("flange", "flange"),
        ("world_mount", "base"),
        ("link_3", "link_3"),
    ):
        campaign = load_campaign(write_example(tmp_path, TOML.replace('on = "link_2"', f'on = "{on}"')))
        assert campaign.targets[1].on == is_on
    (told,) = faults(write_example(tmp_path, TOML.replace('on = "link_2"', 'on = "link2"')))
    assert told == "campaign.toml line 11: targets.T2.on: tiny has no link 'link2'; did you mean 'link_2'?"


def test_a_large_campaign_loads(tmp_path: Path) -> None:
    poses = "".join(f"{i},{i % 90},0.{i % 9},{i % 500}\n" for i in range(33_334))
    points = "".join(f"{i // 3},T{i % 3},{i % 2000}.25,-{i % 999}.5,{i % 77}\n" for i in range(100_000))
    path = write_example(tmp_path, poses=POSES[:28] + poses, points=POINTS[:30] + points)
    campaign = load_campaign(path)
    assert (campaign.n_poses, campaign.n_points) == (33_334, 100_000)
