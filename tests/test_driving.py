"""Plans that are driven: free of collision, seen, in a short order; checked by other means than made."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise, permutations
from pathlib import Path

import numpy as np
import pytest
import trimesh
from urdf_example import package

from workbench import (
    Truth,
    load_campaign,
    load_robot,
    planned,
    problem_of,
    random_poses,
    simulate,
    write_campaign,
)
from workbench.campaign.cell import CellData, DrivingData, InstrumentData, ObstacleData, read_cell
from workbench.cli.main import main
from workbench.correction.programs import as_urdf, find_format
from workbench.files.faults import InputError
from workbench.measurement.driving.drive import drive
from workbench.measurement.driving.files import comments, programs
from workbench.measurement.driving.page import PlanPage, page_files
from workbench.measurement.driving.reach import Reach, reach
from workbench.measurement.driving.scene import _unhidden
from workbench.measurement.driving.tour import shortest
from workbench.measurement.driving.ways import Ways
from workbench.report.meshcat_page import ASIDE, camera
from workbench.robot.hulls import robot_hulls
from workbench.robot.kinematics import frames
from workbench.robot.rigid_plant import arrays

TABLE = ObstacleData(name="table", box_mm=(400, 900, 300), xyz_mm=(450, 300, 150))
HOLDER = ObstacleData(name="holder", box_mm=(60, 60, 80), xyz_mm=(0, 0, 40), on="flange")
INSTRUMENT = InstrumentData(xyz_mm=(1500, -900, 500))
SECOND = {"heavy": (2.0, (0.0, 0.0, 0.05))}


def reached(name: str, cell: CellData) -> Reach:
    problem = problem_of(planned(load_robot(name), np.zeros((1, len(load_robot(name).joints)))))
    return reach(problem, problem.stated_targets, cell, np.random.default_rng(0))


@pytest.fixture(scope="module")
def cell() -> Reach:
    return reached("irb120", CellData(instrument=INSTRUMENT, obstacles=(TABLE, HOLDER)))


@pytest.fixture(scope="module")
def driven(cell: Reach):
    q = cell.draw(24, np.random.default_rng(1))
    payload = ["heavy" if i % 2 else "" for i in range(24)]
    return drive(planned(cell.robot, q, payloads=SECOND, payload=payload), Ways(cell), 4.0)


def render_page(driven, cell: Reach) -> str:
    page = PlanPage("t", "h", [], None, driven, cell, {"inputs": {}})
    return page_files(page)["index.html"].decode()


# ---------------------------------------------------------------- bodies


@pytest.mark.parametrize("name", ["irb120", "kr500"])
def test_the_hulls_hold_what_is_drawn(name: str) -> None:
    """Each link's own mesh, placed by Drake's plant, in the hulls that are placed by the arrays."""
    from workbench.robot.meshes import ROOT_OF_GLTF
    from workbench.robot.rigid_plant import rigid_twin

    robot = load_robot(name)
    arm, twin = arrays(robot), rigid_twin(robot)
    q = random_poses(robot, 3, np.random.default_rng(3))[-1]
    twin.set_positions(q)
    where = frames(arm, q[None])
    for slot, link in enumerate((robot.base, *robot.links)):
        scene = trimesh.load_scene(robot.urdf.with_name(f"{link}.gltf"))
        scene.apply_transform(ROOT_OF_GLTF)
        pose = twin.plant.EvalBodyPoseInWorld(twin.context, twin.plant.GetBodyByName(link))
        drawn = scene.to_mesh().vertices @ pose.rotation().matrix().T + pose.translation()
        (hull,) = [one for one in robot_hulls(robot, arm) if one.slot == slot]
        inside = (drawn - where.p[slot, 0]) @ where.R[slot, 0] @ hull.normals.T <= hull.offsets + 1e-5
        assert inside.all()
        corners = hull.vertices @ where.R[slot, 0].T + where.p[slot, 0]
        np.testing.assert_allclose(np.ptp(corners, axis=0), np.ptp(drawn, axis=0), atol=2e-5)


@pytest.mark.parametrize(
    ("shape", "volume"),
    [
        ('<box size="0.2 0.3 0.4"/>', 0.024),
        ('<cylinder radius="0.1" length="0.5"/>', np.pi * 0.005),
        ('<sphere radius="0.1"/>', 4 / 3 * np.pi * 1e-3),
        ('<capsule radius="0.1" length="0.3"/>', np.pi * (0.003 + 4e-3 / 3)),
    ],
)
def test_a_shape_is_held_by_its_hull(shape: str, volume: float) -> None:
    import xml.etree.ElementTree as ET

    from workbench.robot.hulls import _primitive

    hull = trimesh.convex.convex_hull(_primitive(ET.fromstring(shape), "test"))
    assert volume * (1 - 1e-9) <= hull.volume < 1.15 * volume


def test_what_runs_into_what(cell: Reach) -> None:
    home = np.zeros(6)
    assert cell.collisions.free(home[None]).all()
    down = np.array([0.6, 1.5, 0.3, 0, 0, 0])  # over the table, and into it
    assert ("link_5", "table") in cell.collisions.touching(down) | {("link_6", "table")}
    assert not cell.collisions.free(down[None]).any()
    folded = np.array([np.pi / 2 + 1, 1.9, 0.9, 0, 0, 0])
    assert any("floor" in pair for pair in cell.collisions.touching(folded))


def test_a_thin_wall_is_seen_on_the_way() -> None:
    wall = ObstacleData(name="wall", box_mm=(600, 10, 900), xyz_mm=(600, 0, 450))
    walled = reached("irb120", CellData(obstacles=(wall,)))
    left, right = np.array([[0.9, 0.6, 0, 0, 0.4, 0], [-0.9, 0.6, 0, 0, 0.4, 0]])
    assert walled.collisions.free(np.array([left, right])).all()
    assert not Ways(walled).clear(left, right)
    over = Ways(walled).round(left, right)
    assert over
    assert all(Ways(walled).clear(a, b) for a, b in pairwise([left, *over, right]))
    assert reached("irb120", CellData()).collisions.clear_way(left, right)


# ---------------------------------------------------------------- sight


def test_rays_end_where_points_inside_say(cell: Reach) -> None:
    """Against points along each ray, looked up in the Delaunay cells of each hull."""
    from scipy.spatial import Delaunay

    assert cell.sight is not None
    q = random_poses(cell.robot, 60, np.random.default_rng(5))
    seen = cell.sight.lines(q)
    where = frames(cell.arm, q)
    ends = where.points(cell.sight.places, cell.sight.on)
    cells = [(hull, Delaunay(hull.vertices)) for hull in cell.hulls]
    clear = np.ones_like(seen)
    for n, t in np.ndindex(seen.shape):
        way = ends[n, t] - cell.sight.eye
        far = 1 - 0.03 / np.linalg.norm(way)
        along = cell.sight.eye + np.linspace(0, far, 1500)[:, None] * way
        for hull, inside in cells:
            R, p = (
                (np.eye(3), np.zeros(3)) if hull.slot < 0 else (where.R[hull.slot, n], where.p[hull.slot, n])
            )
            carries = hull.slot >= cell.arm.n - 1  # what a target sits on, and its neighbour
            if not carries or inside.find_simplex((ends[n, t] - p) @ R) < 0:
                clear[n, t] &= (inside.find_simplex((along - p) @ R) < 0).all()
    assert 0.2 < seen.mean() < 0.95
    assert (seen == clear).mean() > 0.99  # but for those that graze


def test_reflectors_look_at_the_instrument(cell: Reach) -> None:
    assert cell.sight is not None
    q = cell.draw(40, np.random.default_rng(2))
    where = frames(cell.arm, q)
    places = cell.sight.places
    for t, name in enumerate(cell.sight.names):
        way = cell.sight.eye - where.points(places, cell.sight.on)[:, t]
        opens = where.R[cell.sight.on[t]] @ cell.sight.opens[t]
        angle = np.arccos(np.einsum("ni,ni->n", way, opens) / np.linalg.norm(way, axis=1))
        assert np.degrees(angle).max() < 30
        assert name in cell.sight.proposals


def test_where_nothing_is_seen_it_is_said() -> None:
    behind = ObstacleData(name="screen", box_mm=(20, 4000, 4000), xyz_mm=(1200, 0, 2000))
    hidden = reached("irb120", CellData(instrument=INSTRUMENT, obstacles=(behind,)))
    with pytest.raises(InputError, match="are seen by the instrument"):
        hidden.draw(5, np.random.default_rng(0))


def test_bodies_that_end_where_others_begin_are_built_so(tmp_path: Path) -> None:
    """The first link begins where its base ends. Drake takes it for no neighbour of the body below, on which
    that is welded."""
    places = {
        "base": "",
        "plinth": "0 0 0",
        "first": "0 0 0.1575",
        "second": "0 0 0.2025",
        "third": "0.3 0 0",
    }
    long = {"base": "", "plinth": "0.1575", "first": "0.2025", "second": "", "third": ""}
    links = [
        f'<link name="{name}"><visual><origin xyz="0 0 {float(size) / 2}"/><geometry>'
        f'<cylinder radius="0.04" length="{size}"/></geometry></visual></link>'
        if size
        else f'<link name="{name}"/>'
        for name, size in long.items()
    ]
    joints = [
        f'<joint name="{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{places[child]}"/><axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>'
        for (parent, child), kind in zip(pairwise(places), ("fixed", *["revolute"] * 3), strict=True)
    ]
    (tmp_path / "arm.urdf").write_text(f'<robot name="arm">{"".join([*links, *joints])}</robot>')
    (tmp_path / "arm.toml").write_text('schema = 1\nname = "arm"\nurdf = "arm.urdf"\nflange = "third"\n')
    here = reached(str(tmp_path / "arm.toml"), CellData())
    turned = np.random.default_rng(0).uniform(-3, 3, (50, 3))
    assert here.collisions.free(turned).all()


def test_obstacles_may_be_called_as_they_like() -> None:
    """Two alike, as the floor, as a link of the robot, two alike on the flange: all of them are there."""
    names = ("fence", "fence", "floor", "link_2")
    far = [
        ObstacleData(name=name, box_mm=(100, 100, 100), xyz_mm=(5000, 400 * k, 500))
        for k, name in enumerate(names)
    ]
    near = ObstacleData(name="fence", box_mm=(400, 400, 400), xyz_mm=(500, 0, 300))
    tools = [ObstacleData(name="tool", box_mm=(40, 40, 40), xyz_mm=(0, 0, z), on="flange") for z in (30, 80)]
    here = reached("irb120", CellData(obstacles=(*far, *tools, near)))
    q = np.random.default_rng(0).uniform(-1, 1, (300, 6))
    hit = {name for one in q for pair in here.collisions.touching(one) for name in pair}
    assert "fence 3" in hit
    assert not {"fence", "fence 2", "floor 2", "link_2 2"} & hit


def test_what_stands_in_the_robot_is_said_to_be_unchecked(cell: Reach) -> None:
    inside = ObstacleData(name="inside", box_mm=(300, 300, 300), xyz_mm=(0, 0, 250))
    assert ("inside", "link_1") in reached("irb120", CellData(obstacles=(inside,))).unchecked
    assert not cell.unchecked


def test_the_camera_does_not_stand_behind_a_fence() -> None:
    links, extent = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.5], [0.6, 0.0, 0.6]]), 3.0
    open_cell = reached("irb120", CellData())
    centre = [0.3, 0.0, 0.4]
    assert _unhidden(open_cell, np.eye(3), centre, extent, links, links) == ASIDE
    eye, middle = camera(centre, extent, links[-1] - links[0])
    x, y, _ = (1e3 * (0.6 * eye + 0.4 * middle)).tolist()
    fence = ObstacleData(name="fence", box_mm=(100, 4000, 5000), xyz_mm=(x, y, 1500), abc_deg=(ASIDE, 0, 0))
    fenced = reached("irb120", CellData(obstacles=(fence,)))
    assert _unhidden(fenced, np.eye(3), centre, extent, links, links) != ASIDE


# ---------------------------------------------------------------- order


def length(time, order):
    """Time of a closed tour."""
    return float(time[order, np.roll(order, -1)].sum())


def test_a_tour_is_nearly_the_shortest() -> None:
    share = []
    for seed in range(12):
        q = np.random.default_rng(seed).uniform(-1, 1, (8, 3))
        time = np.abs(q[:, None] - q).max(axis=2)
        order = shortest(time)
        assert sorted(order) == list(range(8))
        best = min(length(time, np.array([0, *rest])) for rest in permutations(range(1, 8)))
        share.append(length(time, order) / best)
    assert max(share) < 1.1
    assert np.mean(share) < 1.02


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_few_places_make_a_tour(count: int) -> None:
    time = np.random.default_rng(count).uniform(1, 2, (count, count))
    assert sorted(shortest(time)) == list(range(count))


# ---------------------------------------------------------------- a day of measuring


def test_every_way_of_a_drive_is_free(cell: Reach, driven) -> None:
    """All joint targets of the programs, as read back, and 200 poses along each way between them."""
    format, robot = find_format("rapid"), cell.robot
    for name, program in programs(driven, format, 0.1, "measure").items():
        assert format.check(program) == []
        back = as_urdf(format.read(format.write(program)), robot)
        assert back.q is not None
        assert back.name == name
        share = np.linspace(0, 1, 200)[:, None]
        for a, b in pairwise(back.q):
            assert cell.collisions.free(a + share * (b - a)).all()


def test_a_drive_holds_the_plan(cell: Reach, driven) -> None:
    records, own = driven.records, driven.own
    assert len(own.poses) == 24
    assert [block.name for block in driven.blocks] == ["", "heavy"]
    for block in driven.blocks:
        inside = slice(block.start, block.stop)
        carried = {records.payload_names[k] for k in records.poses.payload[inside]}
        assert carried == {block.state.payload}
        assert driven.check[block.start]
        assert driven.check[block.stop - 1]
    assert np.ptp(records.poses.q[driven.check], axis=0).max() == 0  # always the same check pose
    assert np.all(np.diff(records.poses.time) > 0)
    assert driven.still_s == 4.0 + 2 * 3.0  # a further reflector takes 3 s
    assert records.poses.time[-1] + 10.0 == pytest.approx(driven.total_s, abs=5.0)
    assert driven.pauses_s == 600
    assert set(np.unique(records.poses.side)) == {1.0}
    plain = drive(
        own.with_poses(time=None), Ways(replace(cell, cell=CellData(driving=DrivingData(check_every=0)))), 4.0
    )
    assert not plain.check.any()
    q = plain.records.poses.q
    drawn = Ways(cell).time(own.poses.q[np.random.default_rng(0).permutation(24)][:-1], own.poses.q[1:])
    assert Ways(cell).time(q[:-1], q[1:]).sum() < 0.8 * drawn.sum()


def test_pull_and_warmth_are_told_wherever_the_plan_is(cell: Reach) -> None:
    """A pull of 500 N, then the same poses warm: in the words, the table, the campaign, each program."""
    q = cell.draw(9, np.random.default_rng(1))
    wrench, warm = np.zeros((9, 6)), np.repeat([20.0, 20.0, 30.0], 3)
    wrench[3:6, 1] = 500.0
    told = planned(cell.robot, q, wrench=wrench, time=np.repeat([0.0, 0.0, 7200.0], 3), temperature=warm)
    made = drive(told, Ways(cell), 4.0)
    works = [[work for work, _ in block.before] for block in made.blocks]
    assert works == [[], ["rigging"], ["rigging", "warming"]]
    assert made.total_s > 7200
    assert "5 min rigging the pull" in made.blocks[1].preparing
    assert "min working the arm warm" in made.spent
    pull, arm = "500 N along +y of base", "warm, about 30"
    said = (
        [text for text in made.block_lines if pull in text],
        [text for text in made.block_lines if arm in text],
    )
    assert [len(one) for one in said] == [1, 1]
    page = render_page(made, cell)
    assert page.count(pull) == 1 + (made.blocks[1].stop - made.blocks[1].start)
    assert f"{arm} °C" in page
    blocks = made.to_json()["blocks"]
    assert [block["wrench"][1] for block in blocks] == [0, 500, 0]
    assert [block["temp_degC"] for block in blocks] == [20, 20, 30]
    head = "\n".join(comments(made, Path("plan"), ""))
    assert "temp_degC" in head
    assert "fx_N" in head
    for name in ("rapid", "ls"):
        format = find_format(name)
        texts = [str(format.write(one)) for one in programs(made, format, 0.1, "m").values()]
        assert [f"pull: {pull}" in text for text in texts] == [False, True, False]
        assert [f"arm: {arm} degC" in text for text in texts] == [False, False, True]


# ---------------------------------------------------------------- the command


def test_torques_that_are_to_be_recorded_have_columns_and_are_asked_for(tmp_path: Path) -> None:
    out = tmp_path / "plan"
    assert main(["plan", "irb120", "--poses", "3", "--quick", "--torque", "--out", str(out)]) == 0
    lines = (out / "poses.csv").read_text().splitlines()
    assert "tau1_Nm" in lines[0]
    assert "nan" not in lines[1]
    assert "record the torque of each drive (tau1_Nm, " in (out / "index.html").read_text()
    assert "record the torque" in (out / "campaign.toml").read_text()
    assert main(["simulate", "irb120", "--poses", str(out / "poses.csv"), "--out", str(tmp_path / "m")]) == 0


def test_temperatures_are_asked_for_where_the_campaign_before_has_them(tmp_path: Path) -> None:
    """A follow-up without them would be taken to be as warm as that."""
    robot = load_robot("irb120")
    q = random_poses(robot, 12, np.random.default_rng(3))
    for name, warm in (("with", np.linspace(22, 28, len(q))), ("without", None)):
        before = tmp_path / name
        write_campaign(before, simulate(planned(robot, q, temperature=warm), Truth(sigma=2e-5), seed=1))
        out = before / "plan"
        call = ["plan", str(before / "campaign.toml"), "--poses", "3", "--quick", "--out", str(out)]
        assert main(call) == 0
        asked = [
            "temp" in (out / "poses.csv").read_text().splitlines()[0],
            "record how warm the arm is (temp_degC) in poses.csv." in (out / "campaign.toml").read_text(),
            json.loads((out / "plan.json").read_text())["drive"]["record_temperature"],
        ]
        assert asked == 3 * [name == "with"]


def test_a_public_robot_is_planned_measured_and_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    urdf = package(tmp_path / "src")
    assert main(["init", str(urdf), "--out", str(tmp_path / "arm")]) == 0
    (robot,) = [path for path in (tmp_path / "arm").glob("*.toml") if path.stem != "campaign"]
    (tmp_path / "cell.toml").write_text(
        "schema = 1\n[instrument]\nxyz_mm = [3000, 500, 800]\nacceptance_deg = 45\n"
        "[driving]\nspeed_share = 0.2\n"
    )
    out = tmp_path / "plan"
    call = [
        "plan",
        str(robot),
        "--poses",
        "8",
        "--quick",
        "--cell",
        str(tmp_path / "cell.toml"),
        "--out",
        str(out),
    ]
    capsys.readouterr()
    assert main([*call, "--out", str(out), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["drive"]["minutes"] > 0
    page = (out / "index.html").read_text()
    assert "Mount T1 so that it opens towards" in page
    assert "scene.html" in page
    from workbench.cli.told import from_file

    told, _ = from_file(load_robot(robot), str(out / "poses.csv"), {})
    plan = planned(load_robot(robot), told.q, direction=told.direction, time=told.time)
    made = simulate(replace(plan, poses=replace(plan.poses, ids=told.ids)), Truth(sigma=2e-5), seed=1)
    rows = [
        f"{name},{target.name},{','.join(f'{1e3 * v:.5f}' for v in made.points[i, t])}"
        for i, name in enumerate(made.poses.ids)
        for t, target in enumerate(made.targets)
    ]
    (out / "points.csv").write_text("\n".join(["pose_id,target,x_mm,y_mm,z_mm", *rows, ""]))
    read = load_campaign(out / "campaign.toml")
    assert read.n_poses == 8 + facts["drive"]["check_poses"]
    assert read.cell == read_cell(tmp_path / "cell.toml")
    assert all(target.opens is not None for target in read.targets)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('schema = 1\n[[obstacles]]\nname = "a"\n', "an obstacle has box_mm or mesh"),
        ('schema = 1\n[[obstacles]]\nname = "a"\nmesh = "no.stl"\n', "no file"),
        ("schema = 1\n[instrument]\nxyz = [0, 0, 0]\n", "unknown key"),
        ("[instrument]\nxyz_mm = [0, 0, 0]\n", "schema: is missing; the first line is schema = 1"),
        ("schema = 1\n[driving]\nspeed_share = 2\n", "less than or equal to 1"),
    ],
)
def test_a_wrong_cell_is_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "cell.toml").write_text(text)
    with pytest.raises(InputError, match=said):
        read_cell(tmp_path / "cell.toml")
