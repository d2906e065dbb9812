"""Tables as trackers, cameras and controllers write them: what is above, beside and between the numbers."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench import InputError
from workbench.campaign.file import CampaignFile, PointsFile
from workbench.campaign.guess import guess_points, guess_poses
from workbench.campaign.point_table import read_points
from workbench.campaign.program_joints import joint_table, program_of
from workbench.files.tables import Column, Layout, read_table
from workbench.robot.chain import MovingJoint

NAMES = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
JOINTS = [f"{name}_joint" for name in NAMES]
ARM = [MovingJoint(name, "revolute", name, -6.3, 6.3, 1, 1) for name in JOINTS]
RNG = np.random.default_rng(4)
TURN = Rotation.from_quat(RNG.normal(size=(12, 4)))
HAND = RNG.uniform((1500, -800, 200), (2600, 900, 1400), (12, 3))  # mm, the instrument's frame
PLACES = np.stack([HAND + TURN.apply(at) for at in ([150, 0, 50], [-80, 140, 80], [-60, -160, 120])], axis=1)
ANGLES = RNG.uniform(-170, 170, (12, 6))
XYZ = [Column(axis, ("length",), required=True) for axis in "xyz"]


def cells(row):
    return ",".join(f"{value:.6f}" for value in row)


def points(tmp_path, text, encoding="utf-8"):
    """The layout as guessed, and the places (12, targets, 3) [mm] as then read."""
    (tmp_path / "points.csv").write_bytes(text.encode(encoding))
    found = guess_points(tmp_path / "points.csv")
    assert not found.lacking, found
    file = CampaignFile.model_validate(
        {"schema": 1, "robot": "r", "poses": {"file": "p"}, "points": {"file": "points.csv", **found.keys}}
    )
    table = read_points(tmp_path / "points.csv", file, "points")
    assert table.faults == []
    xyz = np.stack([1e3 * table.numbers[axis] for axis in "xyz"], axis=1)
    names = table.texts.get("target", ["T1"] * len(xyz))
    targets = list(dict.fromkeys(names))
    return found.keys, np.stack([xyz[np.array(names) == name] for name in targets], axis=1)


def long(head, factor=1.0, row="{},{},{:.7f},{:.7f},{:.7f}"):
    """A row per pose and target."""
    rows = [row.format(i + 1, f"T{t + 1}", *(factor * PLACES[i, t])) for i in range(12) for t in range(3)]
    return "\n".join([*head, *rows, ""])


def test_titles_above_the_header_are_passed_over(tmp_path):
    head = ["Tracker report", "Date;29.11.2026 12:03", "", "Point;Reflector;X [mm];Y [mm];Z [mm]"]
    text = long(head, row="{};{};{:.7f};{:.7f};{:.7f}").replace(".", ",")
    keys, found = points(tmp_path, text, "utf-16")
    assert keys["skip"] == 3
    assert keys["columns"]["pose_id"] == "Point"
    assert found == pytest.approx(PLACES)
    columns = {f"{axis}_mm": f"{axis.upper()} [mm]" for axis in "xyz"}
    (fault,) = read_table(tmp_path / "points.csv", Layout(separator=";", columns=columns), XYZ).faults
    assert fault.what.endswith("stand below it, in line 4")
    assert fault.mend == "say skip = 3"


def test_titles_above_rows_without_names_are_told(tmp_path):
    (tmp_path / "t.csv").write_text("made today\n\n1,2,3\n4,5,6\n")
    layout = {"header": False, "columns": {"x_mm": 1, "y_mm": 2, "z_mm": 3}}
    (fault,) = read_table(tmp_path / "t.csv", Layout(**layout), XYZ).faults
    assert fault.mend == "if the table begins below it, say skip = 2"
    table = read_table(tmp_path / "t.csv", Layout(skip=2, **layout), XYZ)
    assert not table.faults
    assert table.lines.tolist() == [3, 4]


def test_markers_of_cameras_side_by_side(tmp_path):
    """Names that come again, lines of kinds, names and units above them; the unit is said at the top."""
    head = "Format Version,1.23,Rotation Type,Quaternion,Length Units,Meters\n\n"
    head += f",,{','.join(['Marker'] * 9)}\n,,{','.join(['1'] * 9)}\nFrame,Time (Seconds){',X,Y,Z' * 3}\n"
    rows = "".join(f"{i},{i / 120:.4f},{cells(PLACES[i].ravel() / 1e3)}\n" for i in range(12))
    keys, found = points(tmp_path, head + rows)
    assert keys["wide"] == {"T1": [3, 4, 5], "T2": [6, 7, 8], "T3": [9, 10, 11]}
    assert found == pytest.approx(PLACES, abs=1e-3)
    head = f"Trajectories\n100\nFrame,Sub Frame{',X,Y,Z' * 3}\n,,{','.join(['cm'] * 9)}\n"
    rows = "".join(f"{i},0,{cells(PLACES[i].ravel() / 10)}\n" for i in range(12))
    keys, found = points(tmp_path, head + rows)
    assert (keys["header"], keys["skip"]) == (False, 4)
    assert found == pytest.approx(PLACES, abs=1e-3)


@pytest.mark.parametrize("names", ["X,Y,Z,W,X,Y,Z,", "Rot X,Rot Y,Rot Z,Rot W,Pos X,Pos Y,Pos Z,Error"])
def test_a_bodys_turn_is_no_target(tmp_path, names):
    rows = "".join(f"{i},{cells(TURN.as_quat()[i])},{cells(HAND[i] / 1e3)},0.0001\n" for i in range(12))
    keys, found = points(tmp_path, f"Frame,{names}\n{rows}")
    assert keys["turned_mm"] == 100
    right = HAND[:, None] + np.stack([0 * HAND, TURN.apply([100, 0, 0]), TURN.apply([0, 100, 0])], axis=1)
    assert found == pytest.approx(right, abs=1e-3)


@pytest.mark.parametrize(
    ("names", "beside"),
    [
        ("Nom X,Nom Y,Nom Z,Meas X,Meas Y,Meas Z,Dev X,Dev Y,Dev Z",
         (np.round, lambda xyz: xyz - np.round(xyz))),
        ("X Soll,Y Soll,Z Soll,X Ist,Y Ist,Z Ist", (np.round,)),
        ("RX,RY,RZ,TX,TY,TZ", (lambda xyz: 90 * np.sin(xyz),)),
        ("Ux,Uy,Uz,Mx,My,Mz", (lambda xyz: 0.01 + 0.002 * np.cos(xyz),)),
    ],
)  # fmt: skip
def test_what_was_not_measured_is_no_target(tmp_path, names, beside):
    """Nominal places, deviations, uncertainties and turns were targets beside the measured ones."""
    first, *rest = beside
    here = PLACES[:, 0]
    columns = [first(here), here, *(make(here) for make in rest)]
    rows = "".join(f"{i},{cells(row)}\n" for i, row in enumerate(np.concatenate(columns, axis=1), 1))
    keys, found = points(tmp_path, f"pose,{names}\n{rows}")
    assert "wide" not in keys
    assert found == pytest.approx(here[:, None])


def test_what_cannot_be_told_apart_is_asked(tmp_path):
    rows = "".join(f"{i},{cells([*np.round(at), *at])}\n" for i, at in enumerate(PLACES[:, 0], 1))
    (tmp_path / "points.csv").write_text(f"pose,xA,yA,zA,xB,yB,zB\n{rows}")
    found = guess_points(tmp_path / "points.csv")
    assert found.lacking == ["x", "y", "z"]
    assert found.why.startswith("xA, yA, zA and xB, yB, zB are not targets on one arm")


def test_targets_on_the_arm_and_on_the_base_stay_targets(tmp_path):
    base = np.broadcast_to([3000.0, 10.0, 20.0], (12, 3)) + 0.01 * TURN.apply([1, 0, 0])
    rows = np.concatenate([PLACES[:, 0], PLACES[:, 1], base], axis=1)
    text = "pose,xA,yA,zA,xB,yB,zB,xR,yR,zR\n" + "".join(f"{i},{cells(r)}\n" for i, r in enumerate(rows, 1))
    keys, _ = points(tmp_path, text)
    assert list(keys["wide"]) == ["A", "B", "R"]


@pytest.mark.parametrize(
    ("text", "factor"),
    [
        (["pose,target,X [in],Y [in],Z [in]"], 1 / 25.4),
        (["pose,target,X (inches),Y (inches),Z (inches)"], 1 / 25.4),
        (["pose,target,X_cm,Y_cm,Z_cm"], 0.1),
        (["// Units: Inches"], 1 / 25.4),
        (["pose,target,X,Y,Z", ",,m,m,m"], 1e-3),
        (["#pose,target,x [cm],y [cm],z [cm]"], 0.1),
    ],
)
def test_units_that_are_said_count(tmp_path, text, factor):
    """Of inches and centimetres the numbers look like millimetres."""
    _, found = points(tmp_path, long(text, factor))
    assert found == pytest.approx(PLACES, abs=1e-4)


def test_a_header_that_comes_again_is_no_row(tmp_path):
    head = "pose,target,X [mm],Y [mm],Z [mm]"
    lines = long([head]).split("\n")
    _, found = points(tmp_path, "\n".join([*lines[:19], head, *lines[19:]]))
    assert found == pytest.approx(PLACES)


def test_signs_for_nothing_are_blank(tmp_path):
    """The second target was left out with them, unsaid."""
    rows = [cells(row) for row in PLACES[:, :2].reshape(12, 6)]
    rows[4] = f"{cells(PLACES[4, 0])},-,-,NaN"
    (tmp_path / "points.csv").write_text("X1,Y1,Z1,X2,Y2,Z2\n" + "\n".join(rows))
    found = guess_points(tmp_path / "points.csv")
    layout = PointsFile(file="points.csv", **found.keys)
    file = CampaignFile.model_validate(
        {"schema": 1, "robot": "r", "poses": {"file": "p"}, "points": layout.model_dump()}
    )
    table = read_points(tmp_path / "points.csv", file, "points")
    assert not table.faults
    assert table.texts["target"].count("T2") == 11
    long_rows = long(["pose_id,target,x_mm,y_mm,z_mm"]).replace(f"{PLACES[0, 0, 0]:.7f}", "-")
    (tmp_path / "points.csv").write_text(long_rows)
    bare = CampaignFile.model_validate(
        {"schema": 1, "robot": "r", "poses": {"file": "p"}, "points": {"file": "points.csv"}}
    )
    (fault,) = read_points(tmp_path / "points.csv", bare, "points").faults
    assert str(fault).endswith(
        "line 2: x_mm is empty; leave x, y and z empty, or the line out, of a point that was not seen"
    )


def test_the_group_names_the_pose_and_not_the_collection(tmp_path):
    keys, found = points(tmp_path, long(["// Group Target X Y Z"], row="Col {} {} {:.7f} {:.7f} {:.7f}"))
    assert keys["columns"]["pose_id"] == 2
    assert found == pytest.approx(PLACES)


def test_decimal_commas_in_quotation_marks(tmp_path):
    text = "pose,target,x_mm,y_mm,z_mm\n"
    text += "".join(
        f"{i + 1},T{t + 1}," + ",".join(f'"{v:.7f}"'.replace(".", ",") for v in PLACES[i, t]) + "\n"
        for i in range(12)
        for t in range(3)
    )
    keys, found = points(tmp_path, text)
    assert keys["decimal"] == ","
    assert found == pytest.approx(PLACES)


def joint_columns(tmp_path, names, columns):
    text = ",".join(names) + "\n" + "".join(f"{cells(row)}\n" for row in np.column_stack(columns))
    (tmp_path / "poses.csv").write_text(text)
    found = guess_poses(tmp_path / "poses.csv", ARM)
    return found.lacking or list(found.keys["columns"].values())


def numbered(name, first=1):
    return [name.format(i) for i in range(first, first + 6)]


@pytest.mark.parametrize(
    ("names", "columns", "wanted"),
    [
        ([*numbered("J{}"), *"xyz", "q0", "q1", "q2", "q3"],
         (ANGLES, HAND, np.roll(TURN.as_quat(), 1, axis=1)), numbered("J{}")),
        ([*numbered("J{} [A]"), *numbered("J{} [deg]")], (ANGLES / 40, ANGLES), numbered("J{} [deg]")),
        ([*numbered("J{} [deg/s]"), *numbered("J{}")], (ANGLES / 40, ANGLES), numbered("J{}")),
        ([*numbered("actual_q_{}", 0), *numbered("target_q_{}", 0)], (ANGLES / 60, ANGLES / 60),
         numbered("target_q_{}", 0)),
        ([f"/joint_states/{name}/{kind}" for kind in ("effort", "position") for name in sorted(JOINTS)],
         (ANGLES / 60, ANGLES / 60), [f"/joint_states/{name}/position" for name in JOINTS]),
        (numbered("/joint_states/position[{}]", 0), (ANGLES / 60,), numbered("joint {}")),
    ],
)  # fmt: skip
def test_joints_are_told_from_what_is_named_like_them(tmp_path, names, columns, wanted):
    """Quaternions, currents and speeds were taken for joints; a bag's positions are in the order of names."""
    assert joint_columns(tmp_path, names, columns) == wanted


def test_turning_and_sliding_joints_stand_in_one_row_of_names(tmp_path):
    kinds = ("revolute", "prismatic", "prismatic")
    arm = [MovingJoint(f"axis_{i}", kind, "l", -6, 6, 1, 1) for i, kind in enumerate(kinds, 1)]
    rows = "".join(f"{cells(row)}\n" for row in ANGLES)
    (tmp_path / "t.csv").write_text("J1 [°],J2 [mm],J3 [mm],J1 [A],J2 [A],J3 [A]\n" + rows)
    wanted = {"q1_deg": "J1 [°]", "q2_mm": "J2 [mm]", "q3_mm": "J3 [mm]"}
    assert guess_poses(tmp_path / "t.csv", arm).keys["columns"] == wanted


def test_joints_of_position_registers():
    text = "[*POSREG*]$POSREG  Storage: CMOS  Access: RW  : ARRAY[1,9] OF Position Reg\n"
    text += "    [1,1] =   'Home'   Group: 1\n  J1 =  10.000 deg   J2 =  -60.000 deg   J3 =   .500 deg \n"
    text += "  J4 =     4.000 deg   J5 =    5.000 deg   J6 =     6.000 deg \n  EXT1:   700.000 mm  \n\n"
    text += "    [1,2] =   '' Uninitialized\n    [1,3] =   '' \n  Group: 1   Config: F U T, 0, 0, 0\n"
    text += "  X:  2066.881   Y: -1269.113   Z: -1122.291\n"
    assert program_of(text) == "ls"
    assert (
        joint_table(text, "ls", "posreg.va").split("\n")[1]
        == "PR1,10.000,-60.000,.500,4.000,5.000,6.000,700.000"
    )


def test_tool_poses_of_a_controller_are_told(tmp_path):
    (tmp_path / "posreg.va").write_text(
        "    [1,3] =   '' \n  Group: 1   Config: F U T, 0, 0, 0\n  X:  2066.881   Y: -1269.113   Z: 1.0\n"
    )
    assert "positions are the tool's" in guess_poses(tmp_path / "posreg.va", ARM).why


def test_an_open_quotation_mark_and_a_missing_mark_are_faults(tmp_path):
    (tmp_path / "t.csv").write_text('pose,x,y,z\n1,"2,3,4\n')
    with pytest.raises(InputError, match="cannot be split"):
        guess_points(tmp_path / "t.csv")
    (tmp_path / "t.csv").write_bytes("pose,x,y,z\n".encode("utf-16-le"))
    with pytest.raises(InputError, match="is it UTF-16 without a mark"):
        guess_points(tmp_path / "t.csv")


@pytest.mark.parametrize("text", ["X,Y,Z", "t,X,Y,Z\n,mm\n1,2,3,4\n2,3,4,5\n"])
def test_a_table_that_breaks_off_is_no_crash(tmp_path, text):
    (tmp_path / "t.csv").write_text(text)
    assert bool(guess_points(tmp_path / "t.csv").lacking) == (text == "X,Y,Z")


def test_parted_thousands_are_said_to_be_that(tmp_path):
    text = long(["pose;target;x;y;z"], row="{};{};{:,.3f};{:,.3f};{:,.3f}")
    (tmp_path / "points.csv").write_text(text)
    found = guess_points(tmp_path / "points.csv")
    assert (found.keys["columns"]["x_mm"], found.targets) == ("x", ["T1", "T2", "T3"])
    table = read_table(tmp_path / "points.csv", Layout(separator=";", columns={"x_mm": "x"}), XYZ[:1])
    assert {fault.mend for fault in table.faults[:5]} == {"write it without a sign between the thousands"}


def test_a_column_without_a_finite_number_is_no_place(tmp_path):
    (tmp_path / "t.csv").write_text("".join(f"{i},{cells(PLACES[i, 0])},1e400\n" for i in range(12)))
    assert guess_points(tmp_path / "t.csv").keys["columns"] == {"pose_id": 1, "x_mm": 2, "y_mm": 3, "z_mm": 4}


@pytest.mark.parametrize("names", ["q0,qx,qy,qz,tx,ty,tz", "Q0,Q1,Q2,Q3,X,Y,Z", "Qw,Qx,Qy,Qz,Tx,Ty,Tz"])
def test_a_scalar_that_is_called_otherwise_than_the_rest_of_a_turn(tmp_path, names):
    turn = np.roll(TURN.as_quat(), 1, axis=1)
    rows = "".join(f"{i},OK,{cells(turn[i])},{cells(HAND[i])},0.12\n" for i in range(12))
    keys, found = points(tmp_path, f"Frame,State,{names},Error\n{rows}")
    assert keys["turned_mm"] == 100
    assert found[:, 1] == pytest.approx(HAND + TURN.apply([100, 0, 0]), abs=1e-3)


def test_turns_of_two_bodies_are_not_mixed(tmp_path):
    """The turns of the last had gone with the places of the first."""
    turn = np.roll(TURN.as_quat(), 1, axis=1)
    base = cells([1, 0, 0, 0, 3000, 10, 20])
    rows = "".join(f"2,Probe,{cells(turn[i])},{cells(HAND[i])},Base,{base}\n" for i in range(12))
    head = "Tools,Port 1,Q0,Qx,Qy,Qz,Tx,Ty,Tz,Port 2,Q0,Qx,Qy,Qz,Tx,Ty,Tz\n"
    keys, found = points(tmp_path, head + rows)
    assert "turned_mm" not in keys
    assert list(keys["wide"]) == ["T1", "T2"]
    assert found[:, 0] == pytest.approx(HAND, abs=1e-3)
    assert found[:, 1] == pytest.approx(np.broadcast_to([3000, 10, 20], (12, 3)))


def test_blanks_within_cells_do_not_part_columns_that_tabs_do(tmp_path):
    """As many blanks in the header as in the rows: the columns were one too far to the left."""
    rows = "".join("Point {}\t{}\t{}\t{}\t12:03:01 AM\n".format(i, *at) for i, at in enumerate(HAND))
    keys, found = points(tmp_path, f"Feature Name\tX\tY\tZ\tDate Time\n{rows}")
    assert keys["separator"] == "\t"
    assert found == pytest.approx(HAND[:, None])


@pytest.mark.parametrize(
    ("names", "mapped"),
    [
        ("Rx,Ry,Rz", {"rx_deg": "Rx", "ry_deg": "Ry", "rz_deg": "Rz"}),
        ("Roll [deg],Pitch [deg],Yaw [deg]",
         {"rx_deg": "Roll [deg]", "ry_deg": "Pitch [deg]", "rz_deg": "Yaw [deg]"}),
        ("A,B,C", {"rx_deg": "C", "ry_deg": "B", "rz_deg": "A"}),
    ],
)  # fmt: skip
def test_angles_of_a_6d_measurement_are_found(tmp_path, names, mapped):
    turns = TURN.as_euler("xyz", degrees=True)
    rows = "".join(f"{i},{cells(HAND[i])},{cells(turns[i])}\n" for i in range(12))
    (tmp_path / "points.csv").write_text(f"pose,X,Y,Z,{names}\n{rows}")
    found = guess_points(tmp_path / "points.csv")
    assert found.keys["columns"] == {"pose_id": "pose", "x_mm": "X", "y_mm": "Y", "z_mm": "Z", **mapped}
    assert found.keys["turned_mm"] == 100
    assert not found.lacking
    same = "".join(f"{i},{cells(HAND[i])},0,0,0\n" for i in range(12))
    (tmp_path / "points.csv").write_text(f"pose,X,Y,Z,{names}\n{same}")
    assert "turned_mm" not in guess_points(tmp_path / "points.csv").keys


def test_what_keeps_a_column_from_being_numbers_is_told(tmp_path):
    """It was said that x, y and z are not found, among names x, y and z."""
    rows = [f"{i},{cells(at)}" for i, at in enumerate(HAND)]
    rows[7] = rows[7].rpartition(",")[0] + ",over"
    (tmp_path / "t.csv").write_text("\n".join(["pose,X,Y,Z", *rows, ""]))
    assert guess_points(tmp_path / "t.csv").why == "Z holds 'over', which is no number"
    rows = [",".join(f"{v:.2f}°" for v in row) for row in ANGLES]
    (tmp_path / "t.csv").write_text("\n".join([",".join(numbered("A{}")), *rows, ""]))
    assert guess_poses(tmp_path / "t.csv", ARM).why == f"A1 holds '{ANGLES[0, 0]:.2f}°', which is no number"
