"""Targets of a program in the posture that its file says: every inverse solution of a pose, with what the
maker's own kinematics and manual say of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_controller import MAKERS
from test_program_in_place import bent

from workbench.correction.in_place import Corrected, compensate_program
from workbench.correction.programs import Program, as_shown, find_format
from workbench.correction.programs.posture import margins, of_fanuc
from workbench.robot.description import Robot, load_robot

# All postures of one pose, as the controller shows the joints [deg].
SOLUTIONS = {
    "kr500": [
        (126.0, -90.0, -28.0, 60.0, -40.0, -25.0),
        (126.0, -90.0, -28.0, -120.0, 40.0, 155.0),
        (-54.0, -96.86278, -19.873643, -145.535351, -79.639121, 20.958366),
        (-54.0, -96.86278, -19.873643, 34.464649, 79.639121, -159.041634),
        (-54.0, -111.675435, 13.730718, -141.896809, -64.436093, 9.3001),
        (-54.0, -111.675435, 13.730718, 38.103191, 64.436093, -170.6999),
        (126.0, -111.951214, 21.857076, 40.904067, -58.227469, 3.474172),
        (126.0, -111.951214, 21.857076, -139.095933, 58.227469, -176.525828),
    ],
    "irb120": [
        (-33.0, 29.659957, -57.0, 41.843782, -82.169454, 121.516074),
        (-33.0, 29.659957, -57.0, -138.156218, 82.169454, -58.483926),
        (147.0, -51.0, -57.0, 57.0, 52.0, -95.0),
        (147.0, -51.0, -57.0, -123.0, -52.0, 85.0),
        (147.0, -29.659957, -96.899943, -132.369499, -63.446382, 102.362986),
        (147.0, -29.659957, -96.899943, 47.630501, 63.446382, -77.637014),
        (-33.0, 51.0, -96.899943, 45.200564, -68.649848, 108.33781),
        (-33.0, 51.0, -96.899943, -134.799436, 68.649848, -71.66219),
    ],
    "lrmate200id": [
        (100.0, 0.0, 32.0, 27.0, -57.0, -168.0),
        (-80.0, -21.116352, 131.116661, 23.558344, 72.293474, 19.955646),
        (100.0, 0.0, 32.0, -153.0, 57.0, 12.0),
        (-80.0, -21.116352, 131.116661, -156.441656, -72.293474, -160.044354),
        (-80.0, -47.351479, 105.422196, -157.489905, -96.000657, -150.009572),
        (-80.0, -47.351479, 105.422196, 22.510095, 96.000657, 29.990428),
        (100.0, 52.607863, 83.463162, -156.875082, 104.193273, 33.487387),
        (100.0, 52.607863, 83.463162, 23.124918, -104.193273, -146.512613),
    ],
    "rx170": [
        (4.0, 9.957802, 93.0, -161.440722, 72.737914, -61.391872),
        (4.0, 9.957802, 93.0, 18.559278, -72.737914, 118.608128),
        (4.0, 97.0, -93.0, -35.0, 32.0, 155.0),
        (4.0, 97.0, -93.0, 145.0, -32.0, -25.0),
        (-167.970659, -94.306425, 75.378101, 112.909017, 23.664275, -177.866238),
        (-167.970659, -23.298128, -75.378101, 22.941442, 71.53274, -70.734092),
        (-167.970659, -23.298128, -75.378101, -157.058558, -71.53274, 109.265908),
        (-167.970659, -94.306425, 75.378101, -67.090983, -23.664275, 2.133762),
    ],
}
TURNED = {"kr500": 3, "irb120": 5, "lrmate200id": 5}  # joints that go far enough for a whole turn
FAR = {"kr500": 350.0, "irb120": 400.0, "lrmate200id": 360.0}
Angles = tuple[float, ...]


def sin(angle: float) -> float:
    return float(np.sin(np.radians(angle)))


def cos(angle: float) -> float:
    return float(np.cos(np.radians(angle)))


def kuka_says(a: Angles) -> str:
    """S and T of a KR 500: lengths of its data sheet, stretched at A3 = -atan(55/1025)."""
    ahead = 500 + 1300 * cos(a[1]) + 1025 * cos(a[1] + a[2]) - 55 * sin(a[1] + a[2])
    elbow = a[2] >= -np.degrees(np.arctan(55 / 1025))
    status = 1 * (ahead < 0) + 2 * elbow + 4 * (a[4] < 0)
    return f"S {status}, T {sum(2**i for i in range(6) if a[i] < 0)}"


def abb_says(a: Angles) -> str:
    """confdata of an IRB 120."""
    ahead = 270 * sin(a[1]) + 70 * sin(a[1] + a[2]) + 302 * cos(a[1] + a[2])
    before_the_lower_arm = 302 * cos(a[2]) + 70 * sin(a[2])
    kind = 4 * (ahead < 0) + 2 * (before_the_lower_arm < 0) + 1 * (a[4] < 0)
    return f"[{','.join(str(int(np.floor(a[j] / 90))) for j in (0, 3, 5))},{kind}]"


def fanuc_says(a: Angles) -> str:
    """CONFIG of an LR Mate 200iD, whose joint 3 is the forearm's angle over the horizontal."""
    ahead = 50 + 330 * sin(a[1]) + 335 * cos(a[2]) - 35 * sin(a[2])
    bend = 335 * cos(a[1] + a[2]) - 35 * sin(a[1] + a[2])
    letters = f"{'F' if a[4] >= 0 else 'N'} {'U' if bend >= 0 else 'D'} {'T' if ahead >= 0 else 'B'}"
    return f"{letters}, {', '.join(str(round(a[j] / 360)) for j in (3, 4, 5))}"


def staubli_says(a: Angles) -> str:
    """Configuration of an RX170."""
    ahead = 100 + 850 * sin(a[1]) + 770 * sin(a[1] + a[2])
    sign = ("negative", "positive")
    shoulder = "lefty" if ahead >= 0 else "righty"
    return f'shoulder="{shoulder}" elbow="e{sign[a[2] >= 0]}" wrist="w{sign[a[4] >= 0]}"'


def turn(X: np.ndarray, order: str) -> np.ndarray:
    return Rotation.from_matrix(X[:3, :3]).as_euler(order, degrees=True)


def krl(X: np.ndarray, says: str, before: str = "") -> dict[str, str]:
    pose = [f"{n} {v:.6f}" for n, v in zip("XYZABC", (*(1e3 * X[:3, 3]), *turn(X, "ZYX")), strict=True)]
    point = "{" + ", ".join(pose)
    lines = ["DEF p ( )", "$BASE=$NULLFRAME", "$TOOL=$NULLFRAME", before]
    lines += [f"PTP {point}{', ' + says if says else ''}}}", f"LIN {point}}}", "END", ""]
    return {"p.src": "\n".join(lines)}


def rapid(X: np.ndarray, says: str, before: str = "") -> dict[str, str]:
    place = ",".join(f"{1e3 * v:.6f}" for v in X[:3, 3])
    quaternion = np.roll(Rotation.from_matrix(X[:3, :3]).as_quat(), 1)
    point = f"[[{place}],[{','.join(f'{v:.9f}' for v in quaternion)}],{says},[9E9,9E9,9E9,9E9,9E9,9E9]]"
    moves = [before, f"MoveJ {point}, v100, fine, tool0;", f"MoveL {point}, v100, fine, tool0;"]
    return {"p.mod": "\n".join(["MODULE p", "PROC main()", *moves, "ENDPROC", "ENDMODULE", ""])}


def ls(X: np.ndarray, says: str) -> dict[str, str]:
    place = ",\t".join(f"{n} = {1e3 * v:.6f}  mm" for n, v in zip("XYZ", X[:3, 3], strict=True))
    turns = ",\t".join(f"{n} = {v:.6f} deg" for n, v in zip("WPR", turn(X, "ZYX")[::-1], strict=True))
    lines = ["/PROG  P", "/MN", "   1:J P[1] 20% FINE    ;", "   2:L P[1] 100mm/sec FINE    ;", "/POS"]
    lines += [
        "P[1]{",
        "   GP1:",
        f"\tUF : 0, UT : 1,\t\tCONFIG : '{says}',",
        f"\t{place},",
        f"\t{turns}",
        "};",
    ]
    return {"p.ls": "\n".join([*lines, "/END", ""])}


def val3(X: np.ndarray, says: str, before: Sequence[float] = ()) -> dict[str, str]:
    place = " ".join(f'{n}="{1e3 * v:.6f}"' for n, v in zip("xyz", X[:3, 3], strict=True))
    turns = " ".join(f'r{n}="{v:.6f}"' for n, v in zip("xyz", turn(X, "XYZ"), strict=True))
    data = f'<Data name="p"><Value key="0" {place} {turns} {says} fatherId="world[0]"/></Data>'
    axes = " ".join(f'j{i}="{value:.6f}"' for i, value in enumerate(before, 1))
    data += f'<Data name="j"><Value key="0" {axes}/></Data>' if before else ""
    first = "movej(j[0],flange,m)\n" if before else ""
    code = f"begin\n{first}movej(p[0],flange,m)\nmovel(p[0],flange,m)\nend"
    return {
        "p.pjx": "<Project/>",
        "p.dtx": f'<Database>{data}<Data name="m"><Value key="0" vel="50"/></Data></Database>',
        "start.pgx": f'<Programs><Program name="start"><Code>{code}</Code></Program></Programs>',
    }


Write = Callable[..., dict[str, str]]
KINDS: dict[str, tuple[Callable[[Angles], str], Write]] = {
    "kr500": (kuka_says, krl),
    "irb120": (abb_says, rapid),
    "lrmate200id": (fanuc_says, ls),
    "rx170": (staubli_says, val3),
}


def all_postures(name: str) -> list[Angles]:
    """The solutions, and those of them with a joint turned once round that its range allows."""
    found: list[Angles] = list(SOLUTIONS[name])
    for shown in SOLUTIONS[name] if name in TURNED else ():
        other = list(shown)
        other[TURNED[name]] -= np.copysign(360.0, other[TURNED[name]])
        if abs(other[TURNED[name]]) < FAR[name]:
            found.append(tuple(other))
    return found


def flange(name: str) -> np.ndarray:
    """(4, 4) the pose of the solutions in the controller's world."""
    return np.asarray(MAKERS[name][1](SOLUTIONS[name][0]))


def corrected(folder: Path, model: Path, texts: dict[str, str]) -> Corrected:
    for file, text in texts.items():
        (folder / file).write_text(text)
    tool = np.eye(4) if "p.ls" in texts else None  # stands on FANUC's controller
    return compensate_program(folder / next(iter(texts)), model, folder / "new", tool=tool)


def shown(robot: Robot, done: Corrected) -> np.ndarray:
    """(M, 6) joints at the targets as the controller shows them [deg]."""
    assert robot.convention is not None
    return np.degrees(robot.convention.shown(done.compensation.q_nominal))


@pytest.mark.parametrize("name", KINDS)
def test_the_solutions_are_postures_of_one_pose_and_the_maker_says_each_otherwise(name: str) -> None:
    says, _ = KINDS[name]
    postures = all_postures(name)
    assert len(postures) >= 8
    for posture in postures:
        np.testing.assert_allclose(MAKERS[name][1](posture), flange(name), atol=1e-6)
    assert len({says(posture) for posture in postures}) == len(postures)


@pytest.mark.parametrize("name", KINDS)
def test_a_target_is_taken_in_the_posture_that_the_file_says(name: str, tmp_path: Path) -> None:
    model, robot = bent(name, tmp_path)
    says, write = KINDS[name]
    moved = []
    for posture in all_postures(name):
        done = corrected(tmp_path, model, write(flange(name), says(posture)))
        away = shown(robot, done) - posture
        if name not in TURNED:  # whole turns are not said
            away -= 360 * np.round(away / 360)
        assert np.abs(away).max() < 1e-3, says(posture)
        assert not done.notes
        moved.append(1e3 * (done.compensation.X_command - done.compensation.X_desired)[0, :3, 3])
    apart = np.linalg.norm(moved[0] - np.array(moved[1:8]), axis=1)
    assert apart.max() > 0.1  # mm: each posture has its own correction


def test_a_free_target_after_joints_is_taken_in_the_posture_that_the_file_says(tmp_path: Path) -> None:
    """And in that of the joints before where the file says none, or the controller does not obey it."""
    model, robot = bent("kr500", tmp_path)
    start, other = SOLUTIONS["kr500"][0], SOLUTIONS["kr500"][5]
    axes = f"PTP {{{', '.join(f'A{i} {value}' for i, value in enumerate(start, 1))}}}"
    for says, wanted in ((kuka_says(other), other), ("", start)):
        done = corrected(tmp_path, model, krl(flange("kr500"), says, axes))
        assert shown(robot, done) == pytest.approx(np.array([start, wanted, wanted]), abs=1e-3)
        assert not done.notes
    model, robot = bent("irb120", tmp_path)
    start, other = SOLUTIONS["irb120"][0], SOLUTIONS["irb120"][5]
    axes = f"MoveAbsJ [{list(start)},[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs, v100, fine, tool0;"
    for switch, wanted in (
        ("", other),
        ("ConfJ\\On;", other),
        ("ConfJ\\Off;", start),
        ("ConfL\\Off;", other),
    ):
        done = corrected(tmp_path, model, rapid(flange("irb120"), abb_says(other), switch + axes))
        assert shown(robot, done) == pytest.approx(np.array([start, wanted, wanted]), abs=1e-3), switch
        assert not done.notes


def test_a_posture_that_the_file_leaves_open_is_told(tmp_path: Path) -> None:
    model, robot = bent("kr500", tmp_path)
    done = corrected(tmp_path, model, krl(flange("kr500"), ""))
    taken = ", ".join(f"A{i} {value:z.1f}" for i, value in enumerate(shown(robot, done)[0], 1))
    told = "the file does not say the posture of the arm, and other postures need other corrections; taken"
    assert done.notes == (f"p.src line 5: {told}: {taken} deg",)
    assert f"{told}: {taken} deg" in done.text
    model, robot = bent("rx170", tmp_path)
    done = corrected(tmp_path, model, val3(flange("rx170"), 'shoulder="ssame" elbow="esame" wrist="wsame"'))
    assert [note for note in done.notes if told in note]
    model, robot = bent("irb120", tmp_path)
    posture = SOLUTIONS["irb120"][4]
    done = corrected(tmp_path, model, rapid(flange("irb120"), abb_says(posture), "ConfJ\\Off;"))
    assert shown(robot, done)[0] == pytest.approx(posture, abs=1e-3)
    told = f"the controller does not obey {abb_says(posture)} here, but no joints come before; taken"
    assert [note for note in done.notes if told in note]


def test_a_posture_that_the_arm_does_not_have_is_told_and_the_nearest_taken(tmp_path: Path) -> None:
    model, robot = bent("kr500", tmp_path)
    posture = SOLUTIONS["kr500"][4]
    status, turns = (int(part.split()[1]) for part in kuka_says(posture).split(","))
    wrong = (
        f"S {status ^ 2}, T {turns}"  # the elbow on the other side, which no solution has with these signs
    )
    assert wrong not in {kuka_says(other) for other in all_postures("kr500")}
    done = corrected(tmp_path, model, krl(flange("kr500"), wrong))
    assert shown(robot, done)[0] == pytest.approx(posture, abs=1e-3)
    taken = "A1 -54.0, A2 -111.7, A3 13.7, A4 -141.9, A5 -64.4, A6 9.3 deg"
    told = f"no posture of this arm within its limits has {wrong}; taken: the nearest: {taken}"
    assert done.notes == (f"p.src line 5: {told}",)


def test_a_joint_at_zero_has_either_sign(tmp_path: Path) -> None:
    model, robot = bent("kr500", tmp_path)
    posture = (126.0, -90.0, -28.0, 60.0, -40.0, 0.3)
    X = np.asarray(MAKERS["kr500"][1](posture))
    status, turns = (int(part.split()[1]) for part in kuka_says(posture).split(","))
    for said in (turns, turns ^ 32):
        done = corrected(tmp_path, model, krl(X, f"S {status}, T {said}"))
        assert shown(robot, done)[0] == pytest.approx(posture, abs=1e-3)
        assert not done.notes


@pytest.mark.parametrize("name", ["irb120", "lrmate200id"])
def test_what_is_written_of_a_posture_is_read(name: str) -> None:
    """Of all postures of one pose, each is the one and only that its own target says."""
    robot, format = load_robot(name), find_format(MAKERS[name][0])
    convention = robot.convention
    assert convention is not None
    angles = np.radians(all_postures(name))
    q = convention.joints(angles)
    X = np.repeat(
        convention.from_world(flange(name) @ np.linalg.inv(convention.flange))[None], len(q), axis=0
    )
    files = format.write(as_shown(Program("P", X, q, np.arange(float(len(q)))), robot))
    said = [move.posture for move in format.scan(files).moves if move.kind == "pose"]
    assert len(said) == len(q)
    for i, one in enumerate(said):
        assert one is not None
        agrees = one.against(margins(robot, convention, q), angles)[:, 0] == 0
        assert np.flatnonzero(agrees).tolist() == [i]


def test_status_and_turn_are_read_as_bits_too() -> None:
    said = [
        find_format("krl").scan(krl(np.eye(4), text)).moves[0].posture
        for text in ("S 6, T 27", "S 'B110', T 'B11011'", "T 'H1B', S 'H6'", "S 'B10110', T 27")
    ]
    assert {(one.flags, one.between) for one in said if one} == {(said[0].flags, said[0].between)}  # type: ignore[union-attr]
    assert None not in said
    assert said[0] is not None
    assert said[0].flags == (True, True, False)
    assert [low < 0 for _, low, _ in said[0].between] == [True, True, False, True, True, False]


def test_a_free_target_without_posture_keeps_the_status_before_on_the_shortest_way(tmp_path: Path) -> None:
    """KUKA's controller retains the Status where none is programmed; the Turn is the shortest way's."""
    model, robot = bent("kr500", tmp_path)
    convention = robot.convention
    assert convention is not None
    turns = np.array([(0, 0, 0, 360 * i, 0, 360 * j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    every = (np.array(SOLUTIONS["kr500"])[:, None] + turns).reshape(-1, 6)
    every = every[(np.abs(every) < FAR["kr500"]).all(axis=1)]

    def status(angles: np.ndarray) -> np.ndarray:
        return np.asarray(margins(robot, convention, convention.joints(np.radians(angles))) >= 0)

    lower, upper = np.array([-150, -100, -50, -300, -100, -300]), np.array([150, -20, 100, 300, 100, 300])
    rng, taken = np.random.default_rng(3), set()
    for start in rng.uniform(lower, upper, (24, 6)):
        axes = f"PTP {{{', '.join(f'A{i} {value:.4f}' for i, value in enumerate(start, 1))}}}"
        done = corrected(tmp_path, model, krl(flange("kr500"), "", axes))
        same = (status(every) == status(start[None])).all(axis=1)
        assert any("the posture before" in note for note in done.notes) == (not same.any())
        ways = np.abs(every - start)
        far = ways.max(axis=1) + 1e-6 * ways.sum(axis=1)  # no joint takes a turn that is not needed
        nearest = int(np.where(same, far, 1e9).argmin()) if same.any() else None
        if nearest is not None:
            assert shown(robot, done)[1] == pytest.approx(every[nearest], abs=1e-3)
            taken.add((nearest, nearest == int(far.argmin())))
    assert len(taken) > 5
    assert {nearest_of_all for _, nearest_of_all in taken} == {True, False}


def test_a_configuration_that_stays_the_same_is_that_of_the_joints_before(tmp_path: Path) -> None:
    model, robot = bent("rx170", tmp_path)
    convention = robot.convention
    assert convention is not None

    def flags(angles: np.ndarray) -> list[bool]:
        q = convention.joints(np.radians(angles))[None]
        return [bool(flag) for flag in margins(robot, convention, q)[0] >= 0]

    rng, same = np.random.default_rng(3), 'shoulder="ssame" elbow="esame" wrist="wsame"'
    lower, upper = np.array([-170, -110, -120, -170, -110, -200]), np.array([170, 110, 120, 170, 110, 200])
    reached = {tuple(flags(np.array(one))) for one in SOLUTIONS["rx170"]}
    starts = [start for start in rng.uniform(lower, upper, (40, 6)) if tuple(flags(start)) in reached]
    assert len(starts) > 20
    for start in starts[:12]:
        done = corrected(tmp_path, model, val3(flange("rx170"), same, tuple(start)))
        assert flags(shown(robot, done)[1]) == flags(start)
        assert not [note for note in done.notes if "posture" in note]


def test_configuration_is_read_with_and_without_spaces() -> None:
    close, apart = (of_fanuc(says) for says in ("NUT, 0, 0, 0", "N U T, 0, 0, 0"))
    assert close.flags == apart.flags == (True, True, False)
    assert close.between == apart.between
