"""Campaigns: several of one robot made one."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from campaign_example import POINTS, POSES, TOML, write_example

from workbench.campaign import join, load_campaign
from workbench.files.faults import InputError


def test_join_keeps_set_ups_and_what_differs_apart(tmp_path: Path) -> None:
    one = load_campaign(write_example(tmp_path / "one", TOML + "[noise]\nsigma_mm = 0.1\n"))
    toml = TOML.replace("[100.0, ", "[101.0, ").replace("250", "100") + "[noise]\nsigma_mm = 0.2\n"
    poses = "pose_id,q1_deg,q2_rad,q3_mm,setup,dir1,t_s,payload\nd,1,0,0,s1,1,0,heavy\ne,2,0,0,s2,1,1,\n"
    points = "pose_id,target,x_mm,y_mm,z_mm\nd,T1,1000,2,3\nd,T1,1000,2,3\ne,T2,1,2,3\n"
    two = load_campaign(write_example(tmp_path / "two", toml, poses, points))
    both = join([one, two])
    assert both.poses.ids == ("a", "b", "c", "d", "e")
    assert both.setup_names == ("one", "two/s1", "two/s2")
    assert both.poses.setup.tolist() == [0, 0, 0, 1, 2]
    assert [target.name for target in both.targets] == ["T1 (one)", "T2", "T1 (two)"]
    assert both.shots.tolist() == [[1, 1, 0], [1, 0, 0], [1, 0, 0], [0, 0, 2], [0, 1, 0]]
    np.testing.assert_array_equal(both.points[3, 2], two.points[0, 0])
    assert np.isnan(both.points).all(axis=2).tolist() == (both.shots == 0).tolist()
    assert both.payload_names == ("", "heavy (one)", "heavy (two)")
    assert both.poses.payload.tolist() == [0, 0, 0, 2, 0]
    assert both.load_mass.tolist() == [0.0, 250.0, 100.0]
    assert both.poses.side is not None
    assert both.poses.side[:, 0].tolist() == [0, 0, 0, 1, 1]
    assert both.poses.time is not None
    assert np.isnan(both.poses.time).tolist() == [True, True, True, False, False]
    assert both.poses.torque is None
    assert both.sigma is not None
    np.testing.assert_allclose(both.sigma[[0, 3, 4], [0, 2, 1], 0], [1e-4, 2e-4 / 2**0.5, 2e-4])
    assert np.isnan(both.sigma).tolist() == np.isnan(both.points).tolist()
    assert both.noise_sigma == pytest.approx(np.sqrt((4 * 1e-8 + 2 * 4e-8) / 6))
    assert both.shot_scatter == (0.0, 3)
    assert both.title == "one + two"  # both are titled "Tiny"
    assert join([one, replace(two, title="Later")]).title == "Tiny + Later"
    assert len(both.files) == 8


def test_join_of_like_campaigns_shares_targets_and_noise(tmp_path: Path) -> None:
    one = load_campaign(write_example(tmp_path / "x" / "run", TOML + "[noise]\nsigma_mm = 0.1\n"))
    two = load_campaign(
        write_example(tmp_path / "y" / "run", TOML + "[noise]\nsigma_mm = 0.1\n", POSES + "\n")
    )
    both = join([one, two])
    assert [target.name for target in both.targets] == ["T1", "T2"]
    assert (both.sigma, both.noise_sigma) == (None, 1e-4)
    assert len(set(both.poses.ids)) == 6
    assert both.setup_names == ("x/run", "y/run")
    assert both.poses.ids[0] == "x/run/a"
    assert len(both.files) == 6  # the second poses.csv differs, all else is the same
    assert join([one]) is one


def test_two_campaigns_in_one_folder_are_told_apart_by_their_files(tmp_path: Path) -> None:
    path = write_example(tmp_path / "run")
    other = path.with_name("again.toml")
    other.write_text(path.read_text())
    assert join([load_campaign(path), load_campaign(other)]).setup_names == ("run/campaign", "run/again")


def test_join_knows_which_campaigns_state_no_noise(tmp_path: Path) -> None:
    """The others keep what they state, which is the guess of theirs."""
    one = load_campaign(write_example(tmp_path / "one", TOML + "[noise]\nsigma_mm = 0.1\n"))
    two = load_campaign(write_example(tmp_path / "two"))
    both = join([one, two])
    assert (both.silent, both.noise_sigma) == (("two",), pytest.approx(1e-4))
    assert both.sigma is not None
    assert both.sigma[both.of_label("one")][both.seen[both.of_label("one")]] == pytest.approx(1e-4)
    assert np.isfinite(both.sigma[both.seen]).all()
    neither = join([replace(one, noise_sigma=None), two])
    assert (neither.silent, neither.sigma, neither.noise_sigma) == ((), None, None)


def test_join_refuses_what_cannot_be_one(tmp_path: Path) -> None:
    one = load_campaign(write_example(tmp_path / "one"))
    one_body = TOML.replace('on = "link_2"\n', "")
    other = write_example(tmp_path / "two", one_body + "[noise]\npose = true\n")
    robot = other.parent / "robot" / "tiny.toml"
    robot.write_text(robot.read_text().replace('"tiny"', '"huge"'))
    two = load_campaign(other)
    with pytest.raises(InputError) as caught:
        join([one, two, one])
    whats = [(fault.place.replace(f"{tmp_path}/", ""), fault.what.replace(f"{tmp_path}/", ""))
             for fault in caught.value.faults]  # fmt: skip
    assert whats == [
        ("two/campaign.toml", "robot 'huge', but 'tiny' in one/campaign.toml"),
        ("two/campaign.toml", "[noise] pose is true, not as in one/campaign.toml"),
        ("one/campaign.toml", "the same campaign twice"),
    ]


def test_a_urdf_that_is_written_anew_is_of_the_same_robot(tmp_path: Path) -> None:
    """As the one that goes with a plan: what it says counts."""
    one = load_campaign(write_example(tmp_path / "one"))
    other = write_example(tmp_path / "two")
    urdf = other.parent / "robot" / "tiny.urdf"
    text = urdf.read_text()
    urdf.write_text("<!-- anew -->\n" + text.replace('upper="3.2"', 'upper="3.20"').replace("  <", "<"))
    assert join([one, load_campaign(other)]).robot == one.robot
    urdf.write_text(text.replace("0 1 0", "0 -1 0"))
    with pytest.raises(InputError, match="another URDF"):
        join([one, load_campaign(other)])


def test_tools_that_differ_are_payloads(tmp_path: Path) -> None:
    """What hangs at the flange stays what it was, alone and with a payload."""
    tool = "[tool]\nmass_kg = {}\ncom_mm = [0.0, 0.0, 80.0]\n"
    poses = "pose_id,q1_deg,q2_rad,q3_mm,payload\na,10,0.5,100,heavy\nb,-20,0.25,200,\nc,30,-0.5,0,\n"
    one, two = (
        load_campaign(write_example(tmp_path / name, TOML + tool.format(mass), poses))
        for name, mass in (("one", 10.0), ("two", 30.0))
    )
    campaigns = [one, two]
    both = join(campaigns)
    assert both.payload_names == ("", "tool (one)", "heavy (one)", "tool (two)", "heavy (two)")
    assert "do not state one tool (10, 30 kg)" in both.warnings[-1]
    carried = both.tool_mass + both.load_mass[both.poses.payload]
    before = [c.tool_mass + c.load_mass[c.poses.payload] for c in campaigns]
    assert carried.tolist() == pytest.approx(np.concatenate(before).tolist())
    moment = carried[:, None] * both.load_com[both.poses.payload]
    of_each = [
        c.tool_mass * c.tool_com + (c.load_mass[:, None] * c.load_com)[c.poses.payload] for c in campaigns
    ]
    assert moment == pytest.approx(np.concatenate(of_each))
    assert join([one, replace(two, tool_mass=10.0)]).tool_mass == 10.0  # one tool stays one


def test_a_follow_up_names_loads_and_targets_as_the_join_did(tmp_path: Path) -> None:
    """A plan for several campaigns calls them "heavy (two)" and "T1 (two)": that is no third of each."""
    poses = "pose_id,q1_deg,q2_rad,q3_mm,payload\na,10,0.5,100,heavy\nb,-20,0.25,200,\nc,30,-0.5,0,heavy\n"
    tool = "[tool]\nmass_kg = {}\ncom_mm = [0.3, 0.7, 80.1]\n"
    one = load_campaign(write_example(tmp_path / "one", TOML + tool.format(10.0), poses))
    other = TOML.replace("[100.0, ", "[101.0, ") + tool.format(30.0)
    two = load_campaign(write_example(tmp_path / "two", other, poses))
    both = join([one, two])
    assert both.mounted == "tool (two)"
    mass, com = both.payloads["tool (two)"]
    x, y, z = (1e3 * com).tolist()
    text = TOML.replace("[100.0, ", "[101.0, ").replace("targets.T1", 'targets."T1 (two)"')
    text += f'[payloads."tool (two)"]\nmass_kg = {mass}\ncom_mm = [{x}, {y}, {z}]\n'
    planned = poses.replace(",heavy", ",tool (two)")
    points = POINTS.replace("T1", "T1 (two)")
    more = load_campaign(write_example(tmp_path / "more", text, planned, points))
    whole = join([one, two, more])
    assert len(set(whole.payload_names)) == len(whole.payload_names)
    assert [target.name for target in whole.targets] == ["T1 (one)", "T2", "T1 (two)"]
    names = [whole.payload_names[i] for i in whole.poses.payload[whole.of_label("more")]]
    assert names == ["tool (two)", "", "tool (two)"]
    assert whole.mounted == "tool (two)"


def test_what_is_called_as_another_is_renamed_stays_apart(tmp_path: Path) -> None:
    one = load_campaign(write_example(tmp_path / "one"))
    two = load_campaign(write_example(tmp_path / "two", TOML.replace("250.0", "100.0")))
    text = TOML.replace("payloads.heavy", 'payloads."heavy (two)"').replace("250.0", "7.0")
    poses = "pose_id,q1_deg,q2_rad,q3_mm,payload\na,10,0.5,100,heavy (two)\nb,-20,0.25,200,\nc,30,-0.5,0,\n"
    more = load_campaign(write_example(tmp_path / "more", text, poses))
    whole = join([one, two, more])
    assert whole.payload_names == ("", "heavy (one)", "heavy (two)", "heavy (two) (more)")
    assert whole.load_mass.tolist() == [0.0, 250.0, 100.0, 7.0]
