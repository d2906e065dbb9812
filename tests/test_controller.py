"""`[controller]`: programs and campaigns in the controller's joints, by the makers' published kinematics."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.campaign import load_campaign
from workbench.correction.programs import Program, as_shown, as_urdf, find_format
from workbench.correction.programs.posture import turn_numbers
from workbench.files.faults import InputError
from workbench.robot import rotations
from workbench.robot.convention import Controller, convention_of
from workbench.robot.description import load_robot
from workbench.robot.kinematics import frames
from workbench.robot.rigid_plant import arrays

Steps = list[tuple[str, float]]


def chain(steps: Steps) -> np.ndarray:
    """Pose after turns (x y z [deg]) and shifts (X Y Z [mm]), each in the frame before."""
    X = np.eye(4)
    for axis, value in steps:
        step = np.eye(4)
        if axis.isupper():
            step["XYZ".index(axis), 3] = 1e-3 * value
        else:
            step[:3, :3] = Rotation.from_euler(axis, value, degrees=True).as_matrix()
        X = X @ step
    return X


def kuka(height: float, ahead: float, upper: float, down: float, forearm: float, hand: float):
    """A1, A4 and A6 clockwise, arm level at zero; flange with z forward and x down."""
    return lambda a: chain([
        ("Z", height), ("z", -a[0]), ("X", ahead), ("y", a[1]), ("X", upper), ("y", a[2]), ("Z", -down),
        ("X", forearm), ("x", -a[3]), ("y", a[4]), ("X", hand), ("x", -a[5]), ("y", 90),
    ])  # fmt: skip


def abb(j):
    """IRB 120: arm up and forearm level at zero; tool0 with z forward."""
    return chain([
        ("z", j[0]), ("Z", 290), ("y", j[1]), ("Z", 270), ("y", j[2]), ("Z", 70), ("x", j[3]),
        ("X", 302), ("y", j[4]), ("X", 72), ("x", j[5]), ("y", 90),
    ])  # fmt: skip


def fanuc(j):
    """LR Mate 200iD from the height of joint 2; joint 3 is the forearm's angle over the horizontal."""
    return chain([
        ("z", j[0]), ("X", 50), ("y", j[1]), ("Z", 330), ("y", -j[1] - j[2]), ("Z", 35), ("x", -j[3]),
        ("X", 335), ("y", -j[4]), ("X", 80), ("x", -j[5]), ("y", -90), ("x", 180),
    ])  # fmt: skip


def staubli(j):
    """RX170 from the height of joint 2: upright at zero, all frames as the world's."""
    return chain([
        ("z", j[0]), ("X", 100), ("Y", 70), ("y", j[1]), ("Z", 850), ("y", j[2]), ("z", j[3]), ("Z", 770),
        ("y", j[4]), ("Z", 115), ("z", j[5]),
    ])  # fmt: skip


def universal(d1: float, a2: float, a3: float, d4: float, d5: float, d6: float):
    """The maker's Denavit-Hartenberg table."""
    return lambda q: chain([
        ("z", q[0]), ("Z", d1), ("x", 90), ("z", q[1]), ("X", a2), ("z", q[2]), ("X", a3), ("z", q[3]),
        ("Z", d4),
        ("x", 90), ("z", q[4]), ("Z", d5), ("x", -90), ("z", q[5]), ("Z", d6),
    ])  # fmt: skip


MAKERS = {
    "kr500": ("krl", kuka(1045, 500, 1300, 55, 1025, 290)),
    "kr120": ("krl", kuka(675, 350, 1150, 41, 1000, 215)),
    "irb120": ("rapid", abb),
    "lrmate200id": ("ls", fanuc),
    "rx170": ("val3", staubli),
    "ur5": ("urscript", universal(89.159, -425, -392.25, 109.15, 94.65, 82.3)),
    "ur10": ("urscript", universal(127.3, -612, -572.3, 163.941, 115.7, 92.2)),
}
TOOL = rotations.pose(np.array([0.1, -0.02, 0.25]), Rotation.from_rotvec([0.2, 0.9, -0.4]).as_matrix())


def paths(name: str, count: int) -> tuple[np.ndarray, np.ndarray]:
    """(count, 2, n) joints within the limits, two poses near each other, and (count, 2, 4, 4) tool poses."""
    robot, rng = load_robot(name), np.random.default_rng(7)
    lower, upper = (np.array([getattr(joint, side) for joint in robot.joints]) for side in ("lower", "upper"))
    q = rng.uniform(0.9 * lower, 0.9 * upper, (count, len(lower)))
    q = np.stack([q, q + 0.01], axis=1)
    last = frames(arrays(robot), q.reshape(-1, q.shape[2]))
    X = rotations.pose(last.p[-1], last.R[-1]) @ TOOL
    return q, X.reshape(count, 2, 4, 4)


@pytest.mark.parametrize("name", MAKERS)
def test_joint_target_and_cartesian_target_put_the_tool_at_the_same_place(name: str) -> None:
    form, kinematics = MAKERS[name]
    robot, format = load_robot(name), find_format(form)
    (position, angle), (_, joint) = format.rounding(), format.joint_rounding()
    for q, X in zip(*paths(name, 40), strict=True):
        program = as_shown(Program("SAME", X, q, np.array([0.0, 1.0]), tool=TOOL), robot)
        start, first, *_ = format.scan(format.write(program)).moves
        assert (start.kind, first.kind) == ("joints", "pose")
        tool = kinematics(np.degrees(start.arm)) @ first.tool.matrix
        assert first.X is not None
        turn = rotations.angle_between(tool[None, :3, :3], first.X[None, :3, :3])[0]
        assert np.linalg.norm(tool[:3, 3] - first.X[:3, 3]) < 3 * position + 4 * (6 * joint + angle)
        assert turn < 6 * joint + 3 * angle + 1e-6  # DH tables in degrees, quaternions of eight digits
        straight = as_shown(Program("SAME", q=q, kind="joints", tool=TOOL), robot)
        again = format.read(format.write(straight))
        assert again.q is not None
        np.testing.assert_allclose(as_urdf(again, robot).q, q, atol=3 * joint)


def test_kuka_counts_axis_1_the_other_way() -> None:
    robot = load_robot("kr500")
    q = np.radians([[8.67, -90, 90, 0, 45, 0]])
    program = as_shown(Program("LEFT", q=q, kind="joints"), robot)
    assert "{A1 -8.6700,A2 -90.0000,A3 90.0000," in next(iter(find_format("krl").write(program).values()))


def test_fanuc_shows_joint_3_against_the_horizontal() -> None:
    q = np.radians([[10.0, 20.0, 50.0, 0.0, 0.0, 0.0]])
    program = as_shown(Program("J", q=q, kind="joints"), load_robot("lrmate200id"))
    assert "J3=    30.000 deg" in next(iter(find_format("ls").write(program).values()))


def test_fanuc_says_the_posture_and_the_turns_of_every_pose() -> None:
    robot = load_robot("lrmate200id")
    cases = {  # shown by the controller [deg]: CONFIG
        (0, 0, 0, 0, -90, 0): "N U T, 0, 0, 0",
        (0, 0, 0, 0, 90, 0): "F U T, 0, 0, 0",
        (0, 60, -100, 0, -60, 0): "N U T, 0, 0, 0",
        (0, -60, 150, 0, -60, 0): "N D B, 0, 0, 0",
        (0, -95, 100, 0, 60, 200): "F U B, 0, 0, 1",
        (30, 10, -10, -185, -90, -200): "N U T, -1, 0, -1",
    }
    convention = robot.convention
    assert convention is not None
    q = convention.joints(np.radians(list(cases)))
    last = frames(arrays(robot), q)
    X = rotations.pose(last.p[-1], last.R[-1])
    program = as_shown(Program("TURNS", X, q, np.arange(len(q))), robot)
    text = next(iter(find_format("ls").write(program).values()))
    said = [line.split("'")[1] for line in text.splitlines() if "CONFIG" in line]
    assert said == list(cases.values())
    assert list(turn_numbers(np.radians([-181, -179, 0, 179, 181, 541]))) == [-1, 0, 0, 0, 1, 2]


def test_abb_says_quarters_and_posture_of_every_target() -> None:
    robot = load_robot("irb120")
    q = np.radians(
        [[0, 0, 0, 0, 30, 0], [100, 0, 0, -100, -30, 190], [0, -100, 0, 0, 30, 0], [0, 60, -200, 0, -30, 0]]
    )
    last = frames(arrays(robot), q)
    X = rotations.pose(last.p[-1], last.R[-1])
    program = as_shown(Program("CONF", X, q, np.arange(len(q))), robot)
    text = next(iter(find_format("rapid").write(program).values()))
    said = [line.split("],[")[2] for line in text.splitlines() if "robtarget" in line]
    assert said == ["0,0,0,0", "1,-2,2,1", "0,0,0,4", "0,0,0,7"]


def test_without_a_convention_nothing_is_exported_but_as_the_urdf_has_it() -> None:
    robot = replace(load_robot("kr500"), controller=Controller())
    program = Program("LEFT", q=np.radians([[8.67, -90, 90, 0, 45, 0]]), kind="joints")
    with pytest.raises(InputError, match=r"no .controller.; state names, signs.*--as-urdf"):
        as_shown(program, robot)
    for name in ("krl", "rapid", "ls", "val3", "urscript"):
        files = find_format(name).write(as_shown(program, robot, as_urdf=True))
        assert any("URDF" in text.upper() for text in files.values()), name
        assert find_format(name).read(files).q == pytest.approx(program.q, abs=1e-5)


CONTROLLER = Controller(
    names=("E1", "J1", "J2", "J3"),
    joints=("rail", "one", "two", "three"),
    signs=(1, -1, 1, -1),
    zeros=(100.0, 0.0, 90.0, 10.0),
    units=("mm", "deg", "deg", "rad"),
    couplings=({"joint": "J3", "on": "J2", "factor": -1.0},),  # type: ignore[arg-type]
    external=("E1",),
)
JOINTS, SLIDING = ("one", "two", "rail", "three"), (False, False, True, False)


def test_shown_and_joints_are_each_others_way_back() -> None:
    convention = convention_of(CONTROLLER, JOINTS, SLIDING)
    q = np.array([[0.1, 0.2, 0.3, 0.4]])
    second = 0.2 + np.pi / 2
    assert convention.shown(q) == pytest.approx(np.array([[0.4, -0.1, second, 10 - 0.4 - second]]))
    assert convention.joints(convention.shown(q)) == pytest.approx(q)
    assert convention.sliding == (True, False, False, False)
    # three turns back by its own sign, and on by what J2 does; where these disagree nobody knows
    sides = convention.sides(np.array([[0.0, 1.0, 1.0, 1.0], [0.0, 0.0, 1.0, -1.0]]))
    assert sides.tolist() == [[-1.0, 1.0, 0.0, -1.0], [0.0, 1.0, 0.0, 0.0]]


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"signs": (1, 1)}, "controller.signs: has 2 entries for 4 joints"),
        ({"joints": ("rail", "one", "two", "four")}, "controller.joints: are not the URDF's"),
        ({"external": ("E2",)}, "controller.external: no joint 'E2'"),
        ({"units": ("deg", "deg", "deg", "deg")}, "controller.units: deg does not fit rail"),
        ({"names": ()}, "controller.names: is missing"),
        ({"names": ("J1", "J1", "J2", "J3")}, "controller.names: has a name twice"),
    ],
)
def test_what_a_convention_cannot_say(change: dict, what: str) -> None:
    told = CONTROLLER.model_copy(update=change).faults("robot.toml: controller", JOINTS, SLIDING)
    assert any(what in str(fault) for fault in told)


def test_a_faulty_controller_is_told_with_the_robot(tmp_path: Path) -> None:
    source = load_robot("kr120").path
    assert source is not None
    text = source.read_text().replace('names = ["A1", ', 'names = ["A1"]  # [')
    text = re.sub(r'urdf( *)= "', rf'urdf\1= "{source.parent}/', text)
    (tmp_path / "bad.toml").write_text(text)
    with pytest.raises(InputError, match=r"controller\.names: has 1 entries for 6 joints; give one for each"):
        load_robot(tmp_path / "bad.toml")


def written_by_a_controller(folder: Path, q: np.ndarray, robot: str = "lrmate200id") -> Path:
    """A campaign whose joints are the controller's, columns and all; and the same in the URDF's joints."""
    loaded = load_robot(robot)
    convention = loaded.convention
    assert convention is not None
    shown, places = np.degrees(convention.shown(q)), frames(arrays(loaded), q).p[-1]
    rows = [
        ",".join([f"p{i}", *(f"{value:.9f}" for value in row), "1,1,0,0,1,0,0,0"])
        for i, row in enumerate(shown)
    ]
    names = ",".join([*convention.names, "dir2", "dir3", *(f"tau{k}_Nm" for k in range(1, 7))])
    (folder / "shown.csv").write_text("\n".join([f"pose_id,{names}", *rows, ""]))
    points = [f"p{i},T1," + ",".join(f"{1e3 * v:.6f}" for v in p) for i, p in enumerate(places)]
    (folder / "points.csv").write_text("\n".join(["pose_id,target,x_mm,y_mm,z_mm", *points, ""]))
    text = f'schema = 1\nrobot = "{robot}"\n[poses]\nfile = "shown.csv"\njoints = "controller"\n'
    (folder / "campaign.toml").write_text(text + '[points]\nfile = "points.csv"\n')
    return folder / "campaign.toml"


def test_a_campaign_comes_in_as_the_controller_has_it(tmp_path: Path) -> None:
    q = np.random.default_rng(2).uniform(-1, 1, (8, 6))
    poses = load_campaign(written_by_a_controller(tmp_path, q)).poses
    assert poses.q == pytest.approx(q, abs=1e-10)
    assert poses.side is not None
    assert poses.torque is not None
    # J2 and J3 both upwards: the forearm against the upper arm by both, so upwards too
    assert poses.side[0].tolist() == [0, 1, 1, 0, 0, 0]
    # the drive of J3 works on the URDF's joint 3, and against joint 2
    assert poses.torque[0].tolist() == [0, -1, 1, 0, 0, 0]


def test_columns_may_be_mapped_by_the_controllers_names(tmp_path: Path) -> None:
    q = np.random.default_rng(2).uniform(-1, 1, (8, 6))
    path = written_by_a_controller(tmp_path, q)
    (tmp_path / "shown.csv").write_text((tmp_path / "shown.csv").read_text().replace(",J", ",Soll J"))
    mapped = ", ".join(f"J{k} = {k + 1}" for k in range(1, 6)) + ', J6 = "Soll J6"'
    keys = f'joints = "controller"\ncolumns = {{ {mapped} }}\nunits = {{ J6 = "deg" }}\n'
    path.write_text(path.read_text().replace('joints = "controller"\n', keys))
    assert load_campaign(path).poses.q == pytest.approx(q, abs=1e-10)


def test_a_controllers_table_may_have_its_own_encoding(tmp_path: Path) -> None:
    q = np.random.default_rng(2).uniform(-1, 1, (8, 6))
    path = written_by_a_controller(tmp_path, q)
    for name in ("shown.csv", "points.csv"):
        text = (tmp_path / name).read_text().replace("p0,", "höchste,")
        (tmp_path / name).write_text(text, encoding="latin-1")
    path.write_text(path.read_text().replace('.csv"\n', '.csv"\nencoding = "latin-1"\n'))
    poses = load_campaign(path).poses
    assert poses.ids[0] == "höchste"
    assert poses.q == pytest.approx(q, abs=1e-10)


def test_a_campaign_without_convention_is_told(tmp_path: Path) -> None:
    path = written_by_a_controller(tmp_path, np.zeros((8, 6)))
    path.write_text(path.read_text().replace("lrmate200id", "iiwa7"))
    with pytest.raises(
        InputError, match=r"poses\.joints: .*iiwa7.toml does not say how its controller counts"
    ):
        load_campaign(path)
