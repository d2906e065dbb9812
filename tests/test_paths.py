"""Paths: read with all faults at once, written and read back."""

from __future__ import annotations

from pathlib import Path as FilePath

import numpy as np
import pytest
from campaign_example import write_robot
from hypothesis import given, settings
from hypothesis import strategies as st
from program_paths import read_program
from scipy.spatial.transform import Rotation

from workbench.correction.paths import Path, load_path, write_path
from workbench.correction.programs import Program, find_format, write_program
from workbench.files.faults import InputError
from workbench.robot.description import Robot, load_robot
from workbench.robot.rotations import angle_between, pose

JOINTS = "t_s,q1_deg,q2_rad,q3_mm\n"
QUATERNIONS = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n"
ABC = "t_s,x_mm,y_mm,z_mm,a_deg,b_deg,c_deg\n"


@pytest.fixture
def robot(tmp_path: FilePath) -> Robot:
    return load_robot(write_robot(tmp_path))


def write(folder: FilePath, text: str) -> FilePath:
    path = folder / "path.csv"
    path.write_text(text)
    return path


def faults(folder: FilePath, text: str, robot: Robot | None = None) -> list[str]:
    with pytest.raises(InputError) as caught:
        load_path(write(folder, text), robot)
    return [str(fault).replace(f"{folder}/", "") for fault in caught.value.faults]


def test_joints(tmp_path: FilePath, robot: Robot) -> None:
    file = write(tmp_path, JOINTS + "0,90,0.5,100\n0.5,45,0.25,0\n")
    for path in (load_path(file), load_path(file, robot)):
        assert path.X is None
        assert path.q is not None
        np.testing.assert_allclose(path.q, [[np.pi / 2, 0.5, 0.1], [np.pi / 4, 0.25, 0.0]])
        assert path.time.tolist() == [0.0, 0.5]
        assert (path.title, len(path), path.warnings) == ("path", 2, ())
        assert path.place(1) == f"{file} line 3"
        assert (path.wrench, path.temperature) == (None, None)


def test_tool_poses_by_quaternion(tmp_path: FilePath) -> None:
    root = 0.70710678
    path = load_path(write(tmp_path, QUATERNIONS + f"0,1,2,3,1,0,0,0\n1,4,5,6,{root},0,0,{root}\n"))
    assert path.q is None
    assert path.X is not None
    np.testing.assert_allclose(path.X[0], [[1, 0, 0, 1e-3], [0, 1, 0, 2e-3], [0, 0, 1, 3e-3], [0, 0, 0, 1]])
    np.testing.assert_allclose(path.X[1, :3, :3], [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)


def test_tool_poses_by_kuka_angles(tmp_path: FilePath) -> None:
    path = load_path(write(tmp_path, ABC + "0,0,0,0,10,20,30\n1,0,0,0,0,0,90\n"))
    assert path.X is not None
    turns = [
        Rotation.from_euler(axis, angle, degrees=True) for axis, angle in (("z", 10), ("y", 20), ("x", 30))
    ]
    np.testing.assert_allclose(path.X[0, :3, :3], (turns[0] * turns[1] * turns[2]).as_matrix(), atol=1e-15)
    np.testing.assert_allclose(path.X[1, :3, :3], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-15)


BOTH = pytest.mark.parametrize("program", [False, True], ids=["load_path", "read_program"])


@BOTH
@pytest.mark.parametrize(
    ("text", "q", "time"),
    [
        ("t_s,q1_mrad,q2_um\n0,500,1e5\n1,250,0\n", [[0.5, 0.1], [0.25, 0.0]], [0.0, 1.0]),
        ("t_ms,q1_rad,q2_in\n500,0.5,10\n1500,0.25,0\n", [[0.5, 0.254], [0.25, 0.0]], [0.5, 1.5]),
        ("t_s,q1_rad,q2_m,remark,\n0,.5,.1,start,\n1,.25,0,,\n", [[0.5, 0.1], [0.25, 0.0]], [0.0, 1.0]),
        ('\ufefft_s,q1_rad,q2_m\r0,"0.5",.1\r\r1,.25,0\r', [[0.5, 0.1], [0.25, 0.0]], [0.0, 1.0]),
    ],
    ids=["mrad", "t_ms", "extra columns", "line ends and quotes"],
)
def test_one_set_of_rules_for_paths_and_programs(
    tmp_path: FilePath, program: bool, text: str, q: list[list[float]], time: list[float]
) -> None:
    file = write(tmp_path, text)
    path = read_program(file, "csv") if program else load_path(file)
    assert path.q is not None
    assert path.time is not None
    np.testing.assert_allclose(path.q, q, rtol=1e-15)
    np.testing.assert_allclose(path.time, time, rtol=1e-15)
    assert path.sliding == (False, True)


@BOTH
@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("t_s,q1_deg\n0,1\n1,-9_0\n", "line 3: q1_deg is '-9_0', not a number"),
        ("t_s,q1_deg\n0,1\n0,2\n", "line 3: t_s is 0 s, after 0 s; time has to rise from line to line"),
        ("t_s,q1_deg,q3_deg\n0,1,2\n1,1,2\n", "path.csv: no column q2; a path needs all joints"),
        ("t_s,q1_deg,q1_rad\n0,1,2\n1,1,2\n", "line 1: both q1_deg and q1_rad; keep one of them"),
        ("t_s,q1_kN\n0,1\n1,2\n", "line 1: column 'q1_kN': 'kN' is not a unit of it; name it q1_deg"),
        ("t_s,q1_deg,dwel_s\n0,1,0\n1,2,0\n", "column 'dwel_s' is not known; did you mean 'dwell_s'?"),
        (
            "t_s,q1_deg,dwell_s\n0,1,0\n1,2,1.5\n2,3,0\n",
            "line 3: rests 1.5 s, 1 s before the next line; t_s counts the rest as well",
        ),
        (QUATERNIONS + "0,1,2,3,1.005,0,0,0\n1,1,2,3,1,0,0,0\n", "line 2: qw qx qy qz has length 1.005"),
    ],
)
def test_one_set_of_faults_for_paths_and_programs(
    tmp_path: FilePath, program: bool, text: str, told: str
) -> None:
    file = write(tmp_path, text)
    with pytest.raises(InputError) as caught:
        read_program(file, "csv") if program else load_path(file)
    assert told in str(caught.value)


def test_a_program_is_written_as_the_path_is(tmp_path: FilePath, robot: Robot) -> None:
    path = load_path(write(tmp_path, "t_s,q1_deg,q2_rad,q3_mm,dwell_s\n0,90,0.5,100,0\n3,45,1,0,1\n"), robot)
    assert path.dwell is not None
    assert "dwell_s" in path.warnings[0]
    write_path(tmp_path / "one.csv", path, robot)
    program = Program(
        "other", q=path.q, time=path.time, dwell=path.dwell, kind="joints", sliding=path.sliding
    )
    write_program(program, find_format("csv"), tmp_path / "other.csv")
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "other.csv").read_bytes()
    assert read_program(tmp_path / "one.csv", "csv").dwell.tolist() == [0.0, 1.0]


@pytest.mark.parametrize("kind", ["joints", "quaternion", "abc"])
def test_angles_keep_a_picoradian(tmp_path: FilePath, kind: str) -> None:
    rng = np.random.default_rng(0)
    R = Rotation.random(500, rng=rng).as_matrix()
    q = rng.uniform(-2 * np.pi, 2 * np.pi, (500, 6))
    X = pose(rng.uniform(-3, 3, (500, 3)), R)
    joints = kind == "joints"
    path = Path(np.arange(500.0), q=q if joints else None, X=None if joints else X)
    write_path(tmp_path / "path.csv", path, orientation="abc" if kind == "abc" else "quaternion")
    again = load_path(tmp_path / "path.csv")
    if joints:
        assert again.q is not None
        assert np.abs(again.q - q).max() < 1e-12
    else:
        assert again.X is not None
        assert angle_between(R, again.X[:, :3, :3]).max() < 1e-12


def test_wrench_temperature_and_what_is_not_used(tmp_path: FilePath) -> None:
    text = "t_s,q1_deg,fz_N,mx_Nm,temp_degC,remark\n0,1,-5,2,21,a\n1,2,-6,3,22,b\n"
    path = load_path(write(tmp_path, text))
    assert path.wrench is not None
    assert path.wrench.tolist() == [[0, 0, -5, 2, 0, 0], [0, 0, -6, 3, 0, 0]]
    assert path.temperature is not None
    assert path.temperature.tolist() == [21, 22]
    assert path.warnings == (f"{tmp_path / 'path.csv'}: column 'remark' is not used",)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (JOINTS + "0,1,2,3\n1,nan,2,3\n", "path.csv line 3: q1_deg is 'nan', not a finite number"),
        (JOINTS + "0,1,2,3\n1,1,,3\n", "path.csv line 3: q2_rad is empty"),
        (
            JOINTS + "0,1,2,3\nsoon,1,2,3\n",
            "path.csv line 3: t_s is 'soon', not a number; every sample",
        ),
        (
            JOINTS + "0,1,2,3\n\n0,1,2,3\n",
            "path.csv line 4: t_s is 0 s, after 0 s; time has to rise",
        ),
        (JOINTS + "0,1,2,3\n2,1,2,3\n1,1,2,3\n", "path.csv line 4: t_s is 1 s, after 2 s; time has to rise"),
        (JOINTS + "0,1,2,3\n", "path.csv: has one sample only; a path needs two at least"),
        ("q1_deg\n1\n2\n", "path.csv line 1: no column t_s; add it"),
        ("t_s\n1\n2\n", "path.csv: has neither joints nor tool poses; give q1_deg ... , or x_mm"),
        ("t_s,q1_deg,q3_deg\n0,1,2\n1,2,3\n", "path.csv: no column q2; a path needs all joints"),
        ("t_s,q2_deg,x_mm\n0,1,2\n1,2,3\n", "path.csv: has joints (q2_deg, ...) and tool poses (x_mm, ...)"),
        ("t_s,q1_deg,x_mm\n0,1,2\n1,2,3\n", "path.csv: has joints (q1_deg, ...) and tool poses (x_mm, ...)"),
        (
            "t_s,x_mm,y_mm,z_mm\n0,1,2,3\n1,2,3,4\n",
            "path.csv: has no orientation; give qw qx qy qz",
        ),
        (
            "t_s,x_mm,qw,qx,qy,qz\n0,1,1,0,0,0\n1,1,1,0,0,0\n",
            "path.csv: no column y_mm, z_mm; a tool",
        ),
        (ABC.replace(",b_deg", "") + "0,1,2,3,4,5\n1,1,2,3,4,5\n", "path.csv: no column b_deg; a tool pose"),
        (QUATERNIONS.replace(",qy", "") + "0,1,2,3,1,0,0\n1,1,2,3,1,0,0\n", "path.csv: no column qy; a tool"),
        (
            QUATERNIONS.replace(",qz", ",a_deg") + "0,1,2,3,1,0,0,0\n",
            "path.csv: gives the orientation twice",
        ),
        (
            QUATERNIONS + "0,1,2,3,1,0,0,0\n1,1,2,3,1,0.1,0,0\n",
            "path.csv line 3: qw qx qy qz has length 1.005, not 1; is one of the four wrong, or their order?",
        ),
        (
            JOINTS.replace(",", ";") + "0;1;2;3\n",
            "path.csv line 1: columns are separated by ';'; say",
        ),
        ("", "path.csv: is empty; it needs a header and a line per row"),
    ],
)
def test_faults(tmp_path: FilePath, text: str, told: str) -> None:
    got = faults(tmp_path, text)
    assert any(fault.startswith(told) for fault in got), got


def test_faults_against_the_robot(tmp_path: FilePath, robot: Robot) -> None:
    (told,) = faults(tmp_path, "t_s,q1_deg,q2_deg,q3_deg\n0,1,2,3\n1,1,2,3\n", robot)[:1]
    assert (
        told
        == "path.csv line 1: column 'q3_deg': rail slides, which 'deg' does not fit; name it q3_mm or q3_m"
    )
    assert faults(tmp_path, "t_s,q1_deg,q2_deg\n0,1,2\n1,1,2\n", robot) == [
        "path.csv: no column q3; a path needs all joints"
    ]
    assert faults(tmp_path, "t_s,q1_deg,q2_deg,q3_m,q4_deg\n0,1,2,0,3\n1,1,2,0,3\n", robot) == [
        "path.csv: column 'q4_deg', but tiny has 3 joints; take it out, or name the right robot"
    ]


def test_all_faults_at_once(tmp_path: FilePath) -> None:
    text = QUATERNIONS + "0,1,2,3,1,0,0,0\n1,x,2,3,0.5,0,0,0\n0.5,1,2,,1,0,0,0\n2,1,2,3,1,0,0\n"
    assert [fault.split(" is ")[0].split(" has ")[0] for fault in faults(tmp_path, text)] == [
        "path.csv line 5:",
        "path.csv line 3: x_mm",
        "path.csv line 4: z_mm",
        "path.csv line 4: t_s",
        "path.csv line 3: qw qx qy qz",
    ]


def test_quaternion_a_little_off_is_normalised(tmp_path: FilePath) -> None:
    path = load_path(write(tmp_path, QUATERNIONS + "0,1,2,3,1.0005,0,0,0\n1,1,2,3,-0.9995,0,0,0\n"))
    assert path.X is not None
    np.testing.assert_allclose(path.X[:, :3, :3], np.tile(np.eye(3), (2, 1, 1)), atol=1e-15)


TIMES = st.lists(st.floats(1e-3, 10.0), min_size=2, max_size=6).map(np.cumsum)


@settings(max_examples=50, deadline=None)
@given(time=TIMES, seed=st.integers(0, 2**32 - 1), kind=st.sampled_from(["joints", "quaternion", "abc"]),
       beside=st.booleans())  # fmt: skip
def test_what_is_written_is_loaded(
    tmp_path_factory: pytest.TempPathFactory, time: np.ndarray, seed: int, kind: str, beside: bool
) -> None:
    folder = tmp_path_factory.mktemp("round")
    robot = load_robot(write_robot(folder))
    rng, n = np.random.default_rng(seed), len(time)
    X = np.tile(np.eye(4), (n, 1, 1))
    X[:, :3, :3], X[:, :3, 3] = Rotation.random(n, rng=rng).as_matrix(), rng.normal(size=(n, 3))
    path = Path(
        time=time,
        q=rng.normal(size=(n, 3)) if kind == "joints" else None,
        X=None if kind == "joints" else X,
        wrench=rng.normal(size=(n, 6)) if beside else None,
        temperature=rng.normal(size=n) if beside else None,
    )
    file = folder / "out" / "path.csv"
    write_path(file, path, robot, orientation="abc" if kind == "abc" else "quaternion")
    again = load_path(file, robot)
    for name in ("time", "q", "X", "wrench", "temperature"):
        mine, theirs = getattr(path, name), getattr(again, name)
        assert (mine is None) == (theirs is None)
        if mine is not None:
            np.testing.assert_allclose(mine, theirs, rtol=1e-10, atol=1e-11)
