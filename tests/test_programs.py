"""Robot programs: written, read back, equal within the rounding that each format states."""

from __future__ import annotations

import logging
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from program_paths import read_program
from scipy.spatial.transform import Rotation

from workbench.correction.programs import (
    Program,
    find_format,
    formats,
    krl,
    rounding_effect,
    write_program,
)
from workbench.correction.programs.base import Array, legs_of
from workbench.correction.programs.files import is_folder
from workbench.correction.programs.urscript import UrScript
from workbench.files.faults import InputError
from workbench.robot import rotations

ALL = sorted(formats())
WITH_RAILS = [name for name in ALL if find_format(name).most_rails != 0]
SPIRAL = np.linspace(0.0, 1.0, 40)


def poses(p: Array, R: Array) -> Array:
    return rotations.pose(np.asarray(p, float).reshape(-1, 3), np.asarray(R).reshape(-1, 3, 3))


def random_poses(count: int, seed: int = 1) -> Array:
    rng = np.random.default_rng(seed)
    return poses(rng.uniform(-3, 3, (count, 3)), Rotation.random(count, rng=rng).as_matrix())


def path(name: str = "PATH_1", **change: object) -> Program:
    """A bent path with turning tool at changing speed."""
    s = SPIRAL
    p = np.stack([1.2 + 0.2 * s, 0.1 * np.sin(5 * s), 0.8 + 0.05 * s**2], axis=1)
    R = Rotation.from_euler("ZYX", np.stack([s, 1.2 - s, 3 * s], axis=1)).as_matrix()
    return replace(Program(name, poses(p, R), time=4 * s + s**2), **change)


def again(program: Program, name: str) -> Program:
    return find_format(name).read(find_format(name).write(program))


def assert_equal_poses(program: Program, name: str) -> None:
    back, (position, angle) = again(program, name), find_format(name).rounding()
    assert program.X is not None
    assert back.X is not None
    assert back.count == program.count
    tiny = 1e-12
    assert np.abs(back.X[:, :3, 3] - program.X[:, :3, 3]).max() <= position + tiny
    assert rotations.angle_between(program.X[:, :3, :3], back.X[:, :3, :3]).max() <= angle + tiny


def test_catalogue_has_the_six_formats() -> None:
    assert {"csv", "krl", "rapid", "val3", "ls", "urscript"} <= set(ALL)
    with pytest.raises(InputError, match="one of csv"):
        find_format("no_such_format")


@pytest.mark.parametrize("name", ALL)
def test_random_poses_come_back(name: str) -> None:
    X = random_poses(300)
    program = Program("RANDOM", X, time=np.arange(300.0))
    assert_equal_poses(program, name)
    assert again(program, name).name == "RANDOM"


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("near", [0.0, 1e-12, 1e-9, 1e-8, 1e-7, 1e-5, 1e-3])
def test_gimbal_lock(name: str, near: float) -> None:
    """At B = ±90° (and Stäubli's ry) the three angles are not unique; the rotation is."""
    angles = [
        [a, side * (np.pi / 2 - near), c]
        for a in (-3.1, 0.4, 2.0)
        for c in (-1.0, 0.0, 3.0)
        for side in (-1, 1)
    ]
    for order in ("ZYX", "XYZ"):
        R = Rotation.from_euler(order, np.array(angles)).as_matrix()
        p = np.arange(3.0 * len(R)).reshape(-1, 3) * 0.01
        assert_equal_poses(Program("GIMBAL", poses(p, R), time=np.arange(len(R))), name)


numbers = st.floats(-4, 4, allow_nan=False)


@settings(deadline=None)
@given(
    st.lists(st.tuples(st.tuples(*[numbers] * 3), st.tuples(*[st.floats(-7, 7)] * 3)), min_size=1, max_size=8)
)
def test_any_pose_comes_back_in_any_format(points: list[tuple[tuple[float, ...], tuple[float, ...]]]) -> None:
    p = np.array([point for point, _ in points])
    R = Rotation.from_rotvec(np.array([vector for _, vector in points])).as_matrix()
    program = Program("ANY", poses(p, R), time=np.arange(len(p)))
    for name in ALL:
        assert_equal_poses(program, name)


@settings(deadline=None)
@given(st.tuples(*[st.floats(-10, 10)] * 3))
def test_angles_make_the_rotation_again(angles: tuple[float, float, float]) -> None:
    R = Rotation.from_euler("ZYX", [angles]).as_matrix()
    for there, back in (
        (rotations.zyx_angles, rotations.from_zyx),
        (rotations.xyz_angles, rotations.from_xyz),
    ):
        assert rotations.angle_between(R, back(there(R)))[0] < 1e-14


def test_conventions_against_their_definition() -> None:
    x, y, z = (
        Rotation.from_euler(axis, angle).as_matrix() for axis, angle in (("x", 0.3), ("y", -0.5), ("z", 1.1))
    )
    assert rotations.zyx_angles((z @ y @ x)[None])[0] == pytest.approx([1.1, -0.5, 0.3])
    assert rotations.xyz_angles((x @ y @ z)[None])[0] == pytest.approx([0.3, -0.5, 1.1])


def test_quaternions_do_not_jump() -> None:
    turn = Rotation.from_rotvec(np.linspace(0, 4 * np.pi, 200)[:, None] * [0.0, 0.6, 0.8])
    quaternion = rotations.quaternions(turn.as_matrix())
    assert quaternion[0, 0] >= 0
    assert np.linalg.norm(np.diff(quaternion, axis=0), axis=1).max() < 0.05


@pytest.mark.parametrize("name", ALL)
def test_time_speed_dwell_and_tool_come_back(name: str) -> None:
    tool = poses([0.1, -0.02, 0.25], Rotation.from_rotvec([0.2, 0.9, -0.4]).as_matrix())[0]
    dwell = np.where(np.arange(len(SPIRAL)) == 10, 1.5, 0.0)
    program = path(dwell=dwell, tool=tool)
    program = replace(program, time=4 * SPIRAL + SPIRAL**2 + np.where(np.arange(len(SPIRAL)) > 10, 1.5, 0))
    back = again(program, name)
    assert back.time is not None
    assert program.time is not None
    assert back.time == pytest.approx(program.time, abs=5e-3 * program.time[-1])
    assert back.speed == pytest.approx(program.speed, rel=2e-2)
    assert back.dwell == pytest.approx(dwell, abs=1e-3)
    if find_format(name).carries_tool:
        position, angle = find_format(name).rounding()
        assert np.abs(back.tool - tool)[:3, 3].max() <= position + 1e-12
        assert rotations.angle_between(back.tool[None, :3, :3], tool[None, :3, :3])[0] <= angle
    if name != "csv":
        assert back.blend > 0


@pytest.mark.parametrize("name", ALL)
def test_a_turn_on_the_spot_and_a_standstill_keep_their_time(name: str) -> None:
    p = [[1, 0, 1], [1.1, 0, 1], [1.1, 0, 1], [1.1, 0, 1], [1.2, 0, 1]]
    R = Rotation.from_euler("z", [[0.0], [0.0], [0.5], [0.5], [0.5]]).as_matrix()
    program = Program("CORNER", poses(p, R), time=[0, 1, 3, 6, 7])
    legs, back = legs_of(program), again(program, name)
    assert list(legs.turning) == [False, False, True, False, False]
    assert legs.pause == pytest.approx([0, 0, 3, 0, 0])
    assert not legs.blend.any()
    assert back.time is not None
    assert back.time[-1] == pytest.approx(7, abs=1e-2)
    assert find_format(name).check(program) == []


@pytest.mark.parametrize("name", ALL)
def test_joint_targets_with_dwell_come_back(name: str) -> None:
    q = np.random.default_rng(3).uniform(-3, 3, (50, 6))
    program = Program("MEASURE", q=q, dwell=np.array(4.0), kind="joints", share=0.2)
    back, (_, angle) = again(program, name), find_format(name).joint_rounding()
    assert find_format(name).check(program) == []
    assert back.kind == "joints"
    assert back.q is not None
    assert np.abs(back.q - q).max() <= angle + 1e-12
    assert back.dwell == pytest.approx(np.full(50, 4.0))
    if name != "csv":
        assert back.share == pytest.approx(0.2, abs=1e-3)


@pytest.mark.parametrize("name", WITH_RAILS)
def test_a_rail_comes_back(name: str) -> None:
    q = np.hstack([np.linspace(0, 2, 20)[:, None], np.random.default_rng(3).uniform(-3, 3, (20, 6))])
    sliding = (True, *[False] * 6)
    targets = Program("RAIL", q=q, kind="joints", sliding=sliding)
    back = again(targets, name)
    assert back.q is not None
    assert back.sliding == sliding
    assert np.abs(back.q - q).max() < 2e-5
    if name != "csv":
        along = Program("RAIL", random_poses(20), q, np.arange(20.0), sliding=sliding)
        assert np.abs(again(along, name).rails - q[:, :1]).max() < 1e-6
        assert again(along, name).count == 20  # the approach by joints is no point of the path


@pytest.mark.parametrize("name", ALL)
def test_the_start_is_approached_by_joints_where_known(name: str) -> None:
    program = path(q=np.full((len(SPIRAL), 6), 0.3))
    assert again(program, name).count == len(SPIRAL)
    assert not any("posture that it stands in" in text for text in find_format(name).warnings(program))


def test_ur_streams_dense_paths() -> None:
    program, format = path(), UrScript(stream=True)
    fine = replace(program, time=0.05 * np.arange(program.count))
    assert format.check(program) == []
    assert "servoj(get_inverse_kin(p[" in next(iter(format.write(fine).values()))
    assert format.read(format.write(fine)).time == pytest.approx(fine.time, abs=1e-3)
    assert "sample the path finer" in str(format.check(replace(program, time=np.arange(program.count)))[0])


@pytest.mark.parametrize("name", [name for name in ALL if name != "csv"])
@pytest.mark.parametrize("bad", ["", "7 up", "my-path", "längs der Naht", "while", "x" * 80])
def test_illegal_names_get_a_legal_one(name: str, bad: str) -> None:
    format = find_format(name)
    faults = format.check(path(bad))
    legal = format.legal_name(bad)
    assert format.check(path(legal)) == []
    if len(bad) < 80 or format.longest_name is not None:
        if name != "ls" or bad != "while":  # no word of Fanuc's, but not in capitals
            assert faults
        assert all(repr(legal) in str(fault) for fault in faults)


def test_names_are_as_long_as_the_controllers_take() -> None:
    for name, longest in (("krl", 24), ("rapid", 32), ("ls", 36), ("val3", 15)):
        format = find_format(name)
        assert format.check(path("A" * longest)) == []
        assert f"{longest + 1} characters" in str(format.check(path("A" * (longest + 1)))[0])


@pytest.mark.parametrize(
    ("name", "count", "what"),
    [("ls", 33_000, "33000 points"), ("ls", 9_998, "takes 10000 lines"), ("val3", 10_000, "takes 9999")],
)
def test_too_many_points(name: str, count: int, what: str) -> None:
    X = np.tile(np.eye(4), (count, 1, 1))
    X[:, 0, 3] = 1e-3 * np.arange(count) - 15
    (fault, *_) = find_format(name).check(Program("LONG", X, time=0.01 * np.arange(count)))
    assert what in fault.what
    assert "split the path into 2 programs" in fault.mend


def test_too_large_a_krl_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(krl, "SURELY_FITS", 10)
    monkeypatch.setattr(krl, "MOST_BYTES", 2500)
    assert "holds 0 MB; split the path into" in str(find_format("krl").check(path())[0])


def test_values_that_no_controller_takes() -> None:
    good, format = path(), find_format("krl")
    assert good.X is not None
    assert good.time is not None
    nan, far, skew, back = good.X.copy(), good.X.copy(), good.X.copy(), good.time.copy()
    nan[3, 0, 3], far[4, 1, 3], skew[5, 0, 0], back[7] = np.nan, 1500.0, 2.0, 0.0
    for change, what in (
        ({"X": nan}, "point 4: holds a value that is no number"),
        ({"X": far}, "point 5: is more than 100 m away; positions are in metres"),
        ({"X": skew}, "point 6: is no pose"),
        ({"time": back}, "point 8: time runs back"),
        ({"time": None}, "has no time"),
        ({"time": np.zeros(good.count)}, "point 2: moves in no time"),
        ({"dwell": np.full(good.count, -1.0)}, "dwells a negative time"),
        ({"share": 2.0}, "between 0 and 1"),
        ({"tool": 2 * np.eye(4)}, "tool: is no pose"),
        ({"time": good.time / 100}, "takes 2 m/s; stretch the path's time"),
    ):
        assert what in "\n".join(map(str, format.check(replace(good, **change))))
    assert format.check(Program("EMPTY", np.zeros((0, 4, 4)), time=np.zeros(0)))[0].what == "has no points"


def test_arms_that_a_format_cannot_say() -> None:
    q = np.zeros((2, 7))
    for name in ("krl", "rapid", "ls", "val3", "urscript"):
        assert "7 turning joints" in str(find_format(name).check(Program("SEVEN", q=q, kind="joints"))[0])
    scara = Program("SCARA", q=q, kind="joints", sliding=(*[False] * 6, True))
    assert "inside the arm" in str(find_format("krl").check(scara)[0])
    rail = Program("RAIL", q=q, kind="joints", sliding=(True, *[False] * 6))
    assert "1 rails, URScript takes 0; use csv" in str(find_format("urscript").check(rail)[0])
    assert find_format("csv").check(scara) == []


@pytest.mark.parametrize("name", ALL)
def test_rounding_at_the_tool(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    program, (position, angle) = (
        Program("EFFECT", random_poses(200), time=np.arange(200.0)),
        find_format(name).rounding(),
    )
    effect = rounding_effect(program, find_format(name))
    print(f"{name}: {effect}")
    assert "rounding moves the tool by" in capsys.readouterr().out
    assert 0 < effect.mean_mm <= effect.max_mm <= 1e3 * np.sqrt(3) * position + 1e-9
    assert effect.max_deg <= np.degrees(angle) + 1e-10
    tool = poses([0.3, 0.0, 0.4], np.eye(3))[0]  # its own digits count as well, if the file has them
    assert rounding_effect(replace(program, tool=tool), find_format(name)).max_mm < 3e3 * (position + angle)


def test_rounding_of_joints_goes_through_the_arm() -> None:
    def forward(q: Array) -> Array:
        X = np.tile(np.eye(4), (len(q), 1, 1))
        for i, axis in enumerate("zyyxyx"):
            step = poses(
                np.tile([0.4, 0.0, 0.1], (len(q), 1)), Rotation.from_euler(axis, q[:, [i]]).as_matrix()
            )
            X = X @ step
        return X

    program = Program("M", q=np.random.default_rng(0).uniform(-3, 3, (100, 6)), kind="joints")
    three, four = (rounding_effect(program, find_format(name), forward).max_mm for name in ("ls", "krl"))
    assert 1e-3 < three < 0.06
    assert 0.05 < four / three < 0.2
    with pytest.raises(ValueError, match="forward"):
        rounding_effect(program, find_format("krl"))


@pytest.mark.parametrize("name", ALL)
def test_files_on_disk(name: str, tmp_path: Path) -> None:
    format = find_format(name)
    out = tmp_path / f"PATH_1{format.extension}"
    written = write_program(path(), find_format(name), out)
    assert out in written
    assert all(file.is_file() for file in written)
    assert sorted(tmp_path.iterdir()) == sorted(written)
    assert (b"\r\n" in out.read_bytes()) == (format.newline == "\r\n")
    assert read_program(out, name).count == path().count
    assert read_program(tmp_path, name).count == path().count
    assert write_program(path(), find_format(name), tmp_path) == written


def test_val3_makes_a_folder(tmp_path: Path) -> None:
    written = write_program(path(""), find_format("val3"), tmp_path / "naht")
    assert {file.name for file in written} == {"naht.pjx", "naht.dtx", "start.pgx", "stop.pgx"}
    assert read_program(tmp_path / "naht", "val3").count == path().count


def test_a_name_made_of_the_file_is_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        written = write_program(path(""), find_format("rapid"), tmp_path / "7. Naht (neu).mod")
    assert written == [tmp_path / "7. Naht (neu).mod"]
    assert "named 'p7_Naht_neu'" in caplog.text
    assert read_program(written[0], "rapid").name == "p7_Naht_neu"
    with caplog.at_level(logging.WARNING):
        write_program(path("other"), find_format("krl"), tmp_path / "this.src")
    assert "wants the file named as the program, 'other'" in caplog.text


def test_nothing_is_written_of_a_faulty_program(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="say 'my_path'"):
        write_program(path("my path"), find_format("krl"), tmp_path / "my_path.src")
    assert list(tmp_path.iterdir()) == []


def test_all_files_or_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "PATH_1.pjx").write_text("old")
    real, calls = os.replace, []

    def failing(source: str, target: str) -> None:
        calls.append(target)
        if len(calls) == 3:
            raise OSError(28, "No space left on device")
        real(source, target)

    monkeypatch.setattr(os, "replace", failing)
    with pytest.raises(InputError, match="No space left"):
        write_program(path(), find_format("val3"), tmp_path / "PATH_1.pjx")
    assert [file.name for file in tmp_path.iterdir()] == ["PATH_1.pjx"]
    assert (tmp_path / "PATH_1.pjx").read_text() == "old"


def test_a_path_that_stops_everywhere_is_told() -> None:
    assert any("stops at every point" in text for text in find_format("krl").warnings(path(blend=0.0)))
    assert not any("stops at every point" in text for text in find_format("krl").warnings(path()))
    assert legs_of(path()).blend.max() <= 0.4 * legs_of(path()).distance.max()


def test_a_table_may_end_as_it_likes_but_not_as_a_program():
    csv = find_format("csv")
    for name in ("x.csv", "x.txt", "x.tsv"):
        assert not is_folder(Path(name), csv)
    with pytest.raises(InputError, match=r"ends in \.src; CSV ends in \.csv.* or say --format krl"):
        is_folder(Path("x.src"), csv)
    with pytest.raises(InputError, match=r"ends in \.txt; KUKA KRL ends in \.src"):
        is_folder(Path("x.txt"), find_format("krl"))
