"""URDFs as the world writes them: packages, meshes, roots, fingers, several arms, xacro."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pinocchio
import pytest
import urdf_example as example

from workbench import InputError, load_robot
from workbench.report.scene import Shown, scene_of
from workbench.robot import packages
from workbench.robot.guess import guess_flange
from workbench.robot.kinematics import frames
from workbench.robot.meshes import mesh_files
from workbench.robot.new_robot import new_robot
from workbench.robot.packages import given_packages, package_folder
from workbench.robot.portable import carried
from workbench.robot.rigid_plant import arrays
from workbench.robot.shown import shown_text, urdf_notes
from workbench.robot.urdf import parse_urdf
from workbench.robot.xacro_files import is_xacro
from workbench.simulation.export import export

HERE = Path("acme.urdf")
SOME = np.array([0.4, -0.3, 0.8, -1.2, 0.5, 2.0])


def toml(folder, urdf, extra="", flange="tool0"):
    path = folder / "acme.toml"
    path.write_text(f'schema = 1\nname = "acme"\nurdf = "{urdf}"\nflange = "{flange}"\n{extra}')
    return path


def published(folder, text):
    (folder / "acme.urdf").write_text(text)
    return load_robot(toml(folder, "acme.urdf"))


def nothing():
    return Shown(SOME, np.zeros((0, 3)), {"nominal": np.zeros((0, 3))})


def test_a_published_robot_is_read_and_drawn(tmp_path):
    urdf = example.package(tmp_path / "cloned")
    robot = load_robot(toml(tmp_path, urdf))
    arm = arrays(robot)
    assert robot.base == "base_link"  # not the world, whose name Drake has itself
    where = frames(arm, SOME[None])
    np.testing.assert_allclose(where.p[-1, 0], example.flange_place(SOME), atol=1e-12)
    assert [joint.upper for joint in robot.joints] == [3.0] * 5 + [np.inf]
    assert arm.mass.sum() == pytest.approx(sum(example.MASSES))
    shown = shown_text(robot)
    assert shown.count(".obj") == 6
    assert 'rgba="1 0 0 1"' in shown  # the DAE's own colour
    assert "<collision" not in shown
    (note,) = urdf_notes(robot)
    assert "stand at 0: finger_1, finger_2" in note
    html = scene_of(robot, nothing(), "acme")
    assert "Errors of the fitted poses" not in html, "there are none"
    assert len(html) < 5e6


def test_collada_units_count(tmp_path):
    import trimesh

    made = new_robot(example.package(tmp_path / "cloned"))
    text = next(str(data, "utf-8") for path, data in made.files.items() if "part" in path.name)
    vertices = trimesh.load(trimesh.util.wrap_as_stream(text), file_type="obj").vertices
    np.testing.assert_allclose(vertices.max(axis=0), 10 * 0.0254, atol=1e-5)


def test_a_dense_mesh_makes_a_small_scene(tmp_path):
    urdf = example.package(tmp_path / "cloned")
    example.stl(tmp_path / "cloned/meshes/cone.stl", facets=20_000)
    robot = load_robot(toml(tmp_path, urdf))
    shown = scene_of(robot, Shown(**{**vars(nothing()), "ghost_q": SOME}), "acme")
    assert len(shown) < 5e6
    faces = sum(data.count(b"\nf ") for path, data in new_robot(urdf).files.items() if path.suffix == ".obj")
    assert faces < 20_000


def test_missing_meshes_cost_nothing_but_a_line(tmp_path):
    text = example.robot(example.arm(package="elsewhere"))
    robot = published(tmp_path, text)
    (note,) = urdf_notes(robot)
    assert "2 of 2 meshes are not there" in note
    assert "--package elsewhere=DIR" in note
    np.testing.assert_allclose(
        frames(arrays(robot), SOME[None]).p[-1, 0], example.flange_place(SOME), atol=1e-12
    )
    assert "<cylinder" in shown_text(robot)  # bones, so that there is something to look at
    assert len(scene_of(robot, nothing(), "acme")) > 1e6


@pytest.mark.parametrize(
    "shape", ['<box size="0 0 0"/>', '<cylinder radius="0.1" length="0"/>', '<sphere radius="0.0"/>']
)
def test_a_shape_of_no_size_is_left_out(tmp_path, shape):
    """Published URDFs have such where a link has no picture; Drake ends the process for them."""
    text = example.robot(example.arm(package="elsewhere"))
    text = re.sub("<mesh [^>]*/>", shape, text)
    assert shape in text
    robot = published(tmp_path, text)
    assert shape not in shown_text(robot)
    assert len(scene_of(robot, nothing(), "acme")) > 1e6


def test_a_broken_mesh_is_left_out(tmp_path):
    urdf = example.package(tmp_path / "cloned")
    (tmp_path / "cloned/meshes/part.dae").write_text("<COLLADA")
    made = new_robot(urdf)
    assert any("a mesh is empty or cannot be read" in note for note in made.notes)
    assert 0 < str(made.files[Path("acme.urdf")]).count("cone") <= 3


@pytest.mark.parametrize(
    "variable", ["ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "--package", "sibling", "workspace"]
)
def test_packages_are_found(tmp_path, monkeypatch, variable):
    place = {
        "AMENT_PREFIX_PATH": "prefix/share/parts",
        "ROS_PACKAGE_PATH": "ws/src/vendor/other_name",
        "--package": "somewhere",
        "sibling": "src/parts_of_it",
        "workspace": "other_repository/parts_of_it",
    }[variable]
    folder = tmp_path / place
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>parts</name></package>")
    beside = tmp_path / "src/robot/urdf"
    beside.mkdir(parents=True)
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(name, raising=False)
    given = None
    if variable.endswith("PATH"):
        assert package_folder("parts", beside) is None
        monkeypatch.setenv(variable, str(tmp_path / place.split("/")[0]))
    elif variable == "--package":
        given = given_packages([f"parts={folder}"])
    assert package_folder("parts", beside, given) == folder
    assert package_folder("none", beside, given) is None


def test_a_package_option_that_is_none():
    with pytest.raises(InputError, match="is no NAME=DIR"):
        given_packages(["ur_description"])
    with pytest.raises(InputError, match="no folder"):
        given_packages(["ur=/nowhere/at/all"])


def test_the_urdf_of_a_new_robot_is_one_for_ros(tmp_path):
    """It wants effort and velocity of every limit, and bounds of a revolute joint; zero says: not known."""
    text = example.robot(example.arm())
    text = text.replace('effort="90"', 'effort="0"').replace('lower="-3" upper="3"', "", 1)
    (tmp_path / "acme.urdf").write_text(text)
    made = new_robot(tmp_path / "acme.urdf")
    plain = str(made.files[Path("acme.urdf")])
    other = pinocchio.buildModelFromXML(plain)
    assert [other.joints[i].nq for i in range(1, 7)] == [2, 1, 1, 1, 1, 2]  # turning on: cosine and sine
    (tmp_path / "plain.urdf").write_text(plain)
    read = load_robot(toml(tmp_path, "plain.urdf"))
    assert read.joints == load_robot(toml(tmp_path, "acme.urdf")).joints
    assert read.joints[0].effort == np.inf


def test_gravity_on_a_wall(tmp_path):
    """The URDF mounts the robot on the wall of its world; its own base frame is what counts here."""
    robot = published(tmp_path, example.robot(example.arm(rpy="0 1.5707963267948966 0")))
    np.testing.assert_allclose(robot.gravity, [9.80665, 0, 0], atol=1e-9)
    stated = load_robot(toml(tmp_path, "acme.urdf", "gravity = [0.0, 0.0, -9.8]\n"))
    assert stated.gravity == (0.0, 0.0, -9.8)


def test_a_floating_base(tmp_path):
    robot = published(tmp_path, example.robot(example.arm(kind="floating", xyz="0 0 2")))
    assert robot.base == "base_link"
    np.testing.assert_allclose(
        frames(arrays(robot), SOME[None]).p[-1, 0], example.flange_place(SOME), atol=1e-12
    )


def test_a_world_that_carries_a_joint(tmp_path):
    text = example.robot(example.arm()).replace('"base_link"', '"world"')
    text = text.replace('<link name="world"/>\n<joint name="mount"', '<joint name="mount"')
    start, end = text.index('<joint name="mount"'), text.index("</joint>") + len("</joint>")
    robot = published(tmp_path, text[:start] + text[end:])
    assert robot.base == "world_link"
    np.testing.assert_allclose(
        frames(arrays(robot), SOME[None]).p[-1, 0], example.flange_place(SOME), atol=1e-12
    )


def test_two_arms(tmp_path):
    left = example.arm("left_", mount="table", xyz="0 0.5 1", rpy="1.5707963267948966 0 0")
    right = example.arm("right_", mount="table", xyz="0 -0.5 1")
    text = example.robot(left + right + example.gripper("left_"), root="table")
    with pytest.raises(InputError, match="has 2 arms, to left_tool0, right_tool0; say --flange left_tool0"):
        guess_flange(parse_urdf(text, HERE))
    (tmp_path / "acme.urdf").write_text(text)
    made = new_robot(tmp_path / "acme.urdf", "left_tool0", "left_base_link")
    np.testing.assert_allclose(made.chain.down, [0, -1, 0], atol=1e-12)
    assert "right_base_link" not in str(made.files[Path("acme.urdf")])
    for path, data in made.files.items():
        (tmp_path / "new" / path).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "new" / path).write_bytes(data if isinstance(data, bytes) else data.encode())
    robot = load_robot(tmp_path / "new/acme.toml")
    np.testing.assert_allclose(robot.gravity, [0, -9.80665, 0], atol=1e-8)
    np.testing.assert_allclose(
        frames(arrays(robot), SOME[None]).p[-1, 0], example.flange_place(SOME), atol=1e-12
    )
    # from the table, the other arm counts as what stands there
    whole = load_robot(toml(tmp_path, "acme.urdf", flange="right_tool0"))
    assert whole.base == "table"
    assert sum("stand at 0: left_" in note for note in urdf_notes(whole)) == 1


@pytest.mark.parametrize(
    ("links", "flange", "why"),
    [
        ("tool0", "tool0", "by its name"),
        ("arm_flange", "arm_flange", "by its name"),
        ("link8", "link8", "the frame that is fixed to the last moving link 'wrist_3_link'"),
        (None, "wrist_3_link", "the last moving link"),
    ],
)
def test_the_flange_is_guessed(links, flange, why):
    text = example.robot(example.arm())
    end = text.index('<link name="flange"/>')
    extra = (
        f'<link name="{links}"/><joint name="e" type="fixed"><parent link="wrist_3_link"/>'
        f'<child link="{links}"/></joint>'
        if links
        else ""
    )
    guess = guess_flange(parse_urdf(text[:end] + extra + "</robot>", HERE))
    assert (guess.flange, guess.why) == (flange, why)


def test_a_link_that_stands_for_a_parts_shape_is_no_flange():
    """Franka's link7 carries link7_sc, collision shapes alone, before it carries the frame of its flange."""
    text = example.robot(example.arm())
    end = text.index('<link name="flange"/>')
    extra = '<link name="link7_sc"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
    extra += '<link name="link8"/>' + "".join(
        f'<joint name="to_{link}" type="fixed"><parent link="wrist_3_link"/><child link="{link}"/></joint>'
        for link in ("link7_sc", "link8")
    )
    assert guess_flange(parse_urdf(text[:end] + extra + "</robot>", HERE)).flange == "link8"


def test_a_gripper_is_no_flange():
    guess = guess_flange(parse_urdf(example.robot(example.arm() + example.gripper()), HERE))
    assert guess.flange == "tool0"


def test_an_impossible_inertia_keeps_its_mass(tmp_path):
    text = example.robot(example.arm()).replace('izz="0.01"', 'izz="5.0"', 1)
    robot = published(tmp_path, text)
    assert arrays(robot).mass.sum() == pytest.approx(sum(example.MASSES))
    assert any(
        "inertia that no body can have" in note and "shoulder_pan" in note for note in urdf_notes(robot)
    )


def test_each_missing_package_is_asked_for(tmp_path):
    text = example.robot(example.arm(package="elsewhere")).replace("package://elsewhere", "package://off", 1)
    (note,) = urdf_notes(published(tmp_path, text))
    assert "(package://off" in note
    assert "--package off=DIR --package elsewhere=DIR" in note


def test_a_rods_inertia_of_few_digits_is_read_without_a_word(tmp_path, caplog):
    rod = re.sub(
        "<inertia .*?/>",
        '<inertia ixx="0.0002512" iyy="0.0002511999" izz="2e-14" ixy="0" ixz="0" iyz="0"/>',
        example.robot(example.arm()),
        count=1,
    )
    robot = published(tmp_path, rod)
    assert not urdf_notes(robot)
    assert arrays(robot).mass.sum() == pytest.approx(sum(example.MASSES))
    assert not caplog.records


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('value="6.0"', 'value="1e5"', "elbow_link with 100000 kg; state"),
        (
            'value="0.6"',
            'value="1e-9"',
            "wrist_3_link with 1e-09 kg, wrist_3_link with a radius of gyration of",
        ),
        ('value="0.6"', 'value="0"', "wrist_3_link with 0 kg; state"),
        ('xyz="0.05 0 0.1"', 'xyz="50 0 100"', "shoulder_pan_link with its centre of mass 112 m away, "),
        ('izz="0.01"', 'izz="0.01"', None),
        ('value="0.6"', "", "wrist_3_link with 0 kg; state"),
    ],
)
def test_weights_that_no_arm_has_are_told(tmp_path, old, new, said):
    (tmp_path / "acme.urdf").write_text(example.robot(example.arm()).replace(old, new))
    notes = [note for note in new_robot(tmp_path / "acme.urdf").notes if "weights that no arm has" in note]
    assert [said in note for note in notes] == ([] if said is None else [True])


def test_no_weights_at_all_are_nothing_odd(tmp_path):
    (tmp_path / "acme.urdf").write_text(re.sub("<inertial>.*?</inertial>", "", example.robot(example.arm())))
    assert not any("weights" in note for note in new_robot(tmp_path / "acme.urdf").notes)


@pytest.mark.parametrize("encoding", ["iso-8859-1", "utf-8-sig", "utf-16", "cp1252", "utf-8", None])
def test_a_urdf_is_read_in_the_encoding_that_it_says(tmp_path, encoding):
    """None: Latin-1 that says nothing, or that it is UTF-8; a warning tells it."""
    text = (
        re.sub(r"<(visual|collision)>.*?</\1>", "", example.robot(example.arm()))
        .replace("wrist_3_link", "H\u00e4nd")
        .replace("<robot", "<!-- \u00fc --><robot")
    )
    head = f'<?xml version="1.0" encoding="{encoding.removesuffix("-sig")}"?>\n' if encoding else ""
    (tmp_path / "acme.urdf").write_bytes((head + text).encode(encoding or "cp1252"))
    made = new_robot(tmp_path / "acme.urdf")
    assert made.chain.joints[-1].link == "H\u00e4nd"
    assert any("read as Latin-1" in note for note in made.notes) == (encoding is None)
    robot = load_robot(toml(tmp_path, "acme.urdf"))
    assert any("read as Latin-1" in note for note in urdf_notes(robot)) == (encoding is None)
    assert "H\u00e4nd" in carried(robot.urdf, tmp_path)[1]


def test_an_encoding_that_nobody_knows(tmp_path):
    (tmp_path / "acme.urdf").write_text('<?xml version="1.0" encoding="klingon"?>\n<robot/>')
    with pytest.raises(InputError, match="says encoding 'klingon', which nobody knows; save it as UTF-8"):
        new_robot(tmp_path / "acme.urdf")


def test_xacro_in_another_encoding_is_refused(tmp_path):
    (tmp_path / "acme.xacro").write_bytes(
        b'<?xml version="1.0" encoding="latin-1"?>\n<robot><!-- \xfc --></robot>'
    )
    with pytest.raises(InputError, match="is not all UTF-8, and xacro reads nothing else; save the file"):
        new_robot(tmp_path / "acme.xacro")


def test_a_mesh_that_lacks_is_one(tmp_path):
    text = example.robot(example.arm(package="elsewhere").replace("part.dae", "cone.stl"))
    (tmp_path / "acme.urdf").write_text(text)
    assert new_robot(tmp_path / "acme.urdf").notes[0].startswith("the only mesh is not there (")


@pytest.mark.parametrize("to", ["urdf", "sdf"])
def test_an_exported_robot_finds_its_meshes(tmp_path, to):
    """Below the URDF, beside it, of the same name elsewhere, and by their full path."""
    urdf = example.package(tmp_path / "cloned")
    text = urdf.read_text()
    for where in ("parts/cone.stl", "../meshes/cone.stl", "../other/cone.stl", f"{tmp_path}/part.dae"):
        text = text.replace(f"package://acme_description/meshes/{Path(where).name}", where, 2)
        example.stl(urdf.parent / where, facets=len(where))
    urdf.write_text(text)
    folder = tmp_path / "elsewhere/out"
    (file, *_) = export(load_robot(toml(tmp_path, urdf)), to, folder).files
    named = re.findall('filename="(.*?)"|<uri>(.*?)</uri>', file.read_text())
    files = {a or b for a, b in named if "package://" not in a}
    assert all(
        (folder / name).is_file() and (folder / name).resolve().is_relative_to(folder) for name in files
    )
    sizes = sorted((folder / name).stat().st_size for name in files)
    assert sizes == sorted(path.stat().st_size for path in carried_files(urdf))


def carried_files(urdf):
    """The mesh files that a URDF names by their place."""
    names = {name for name in re.findall('filename="(.*?)"', urdf.read_text()) if "://" not in name}
    assert len(names) == 4
    return [urdf.parent / name for name in names]


def behind(name, kind, parent, child, more=""):
    """A joint and the link that it moves."""
    return (
        f'<link name="{child}"/><joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/><axis xyz="0 0 1"/><limit lower="0" upper="0.05" effort="1" velocity="1"/>'
        f"{more}</joint>"
    )


LAST, PALM = "wrist_3_link", behind("palm", "fixed", "wrist_3_link", "palm")
FOLLOWS = behind("f", "revolute", "palm", "right", '<mimic joint="drive"/>')


@pytest.mark.parametrize(
    ("tool", "flange", "named"),
    [
        # a finger that slides, and none that follows it; one in a hand that turns
        (behind("drive", "prismatic", LAST, "left"), LAST, False),
        (PALM + behind("drive", "revolute", "palm", "left") + FOLLOWS,
         "palm", False),
        # chains of joints that say what they are
        (behind("jaw_1", "revolute", LAST, "a") + behind("b", "revolute", "a", "c"), LAST, False),
        # a spindle, and a rotating mount with a finger, on what is called a flange
        (behind("spindle", "continuous", "tool0", "mill"), "tool0", True),
        (behind("turn", "revolute", "tool0", "mount") + behind("drive", "prismatic", "mount", "left"),
         "tool0", True),
        (behind("l", "revolute", "tool0", "left") + behind("m", "fixed", "left", "left_ee_link")
         + behind("r", "revolute", "tool0", "right"), "tool0", True),
        # nothing says that this is no axis
        (behind("turn", "revolute", LAST, "mount"), "mount", False),
        (behind("gripper_roll", "revolute", LAST, "hand"), "hand", False),
    ],
)  # fmt: skip
def test_what_moves_in_a_tool_is_no_axis(tool, flange, named):
    text = example.robot(example.arm())
    end = text.index("</robot>") if named else text.index('<link name="flange"/>')
    assert guess_flange(parse_urdf(f"{text[:end]}{tool}</robot>", HERE)).flange == flange


def test_levers_beside_an_arm_do_not_end_it():
    """The rods of a parallelogram that nothing follows: the branch with the flange goes on."""
    text = example.robot(example.arm() + behind("lever", "revolute", "shoulder_lift_link", "rod"))
    assert guess_flange(parse_urdf(text, HERE)).flange == "tool0"


def wrong(text):
    with pytest.raises(InputError) as caught:
        guess_flange(parse_urdf(text, HERE))
    return str(caught.value)


def test_what_is_wrong_with_a_urdf_is_said():
    good = example.robot(example.arm())
    assert "is not XML" in wrong("<robot")
    assert "not a URDF's <robot>" in wrong("<sdf/>")
    assert "link 'flange' twice" in wrong(good.replace("</robot>", '<link name="flange"/></robot>'))
    assert "no link 'nowhere'" in wrong(good.replace('<parent link="flange"/>', '<parent link="nowhere"/>'))
    assert "has no moving joint" in wrong('<robot name="r"><link name="a"/></robot>')
    xacro = good.replace("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"')
    assert "workbench init" in wrong(xacro.replace("</robot>", "<xacro:arm/></robot>"))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('<axis xyz="1 0 0"/>', '<axis xyz="0 0 0"/>', "its axis is 0 0 0"),
        ('lower="-3" upper="3"', 'lower="3" upper="-3"', "its limits are 3 .. -3"),
        ('xyz="0 0 0.18"', 'xyz="0 0 a"', "'0 0 a' is not three numbers"),
        (
            '<axis xyz="1 0 0"/>',
            '<mimic joint="elbow_joint"/>',
            '(mimic, times 1); .* write type="fixed"',
        ),
        ('type="continuous"', 'type="planar"', "no moving joint|is 'planar'"),
    ],
)
def test_what_is_wrong_with_a_chain_is_said(tmp_path, old, new, said):
    text = example.robot(example.arm())
    assert old in text
    with pytest.raises(InputError, match=said.replace("(", r"\(").replace(")", r"\)")):
        arrays(published(tmp_path, text.replace(old, new, 1)))


def test_prefixes_that_nobody_declared(tmp_path):
    """Of a simulator's extensions, in old URDFs: ROS reads them."""
    extension = '<gazebo reference="flange"><sensor:camera name="rgb"><hfov>50</hfov></sensor:camera>'
    robot = published(tmp_path, example.robot(example.arm() + extension + "</gazebo>"))
    assert len(robot.joints) == 6
    assert "<sensor:camera" in carried(robot.urdf, tmp_path)[1]


def test_mesh_files_prefer_visuals(tmp_path):
    urdf = example.package(tmp_path / "cloned")
    tree = parse_urdf(urdf.read_text(), urdf)
    from workbench.robot.chain import read_chain

    files = dict(mesh_files(tree, read_chain(tree, "tool0")))
    assert sorted(path.name for path in files.values()) == ["cone.stl", "part.dae"]


XACRO = """<robot name="acme" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="lift" default="0"/>
<xacro:include filename="$(find acme_parts)/urdf/arm.xacro"/>
<link name="world"/><xacro:acme height="$(arg lift)"/></robot>"""


def count_runs(monkeypatch):
    """A list that grows with each time that xacro works a file through."""
    import xacro

    runs, process = [], xacro.process_doc
    monkeypatch.setattr(xacro, "process_doc", lambda *a, **keys: (runs.append(a), process(*a, **keys)))
    return runs


def test_xacro(tmp_path, monkeypatch):
    example.package(tmp_path / "src/cloned")
    parts = tmp_path / "src/parts"
    (parts / "urdf").mkdir(parents=True)
    (parts / "package.xml").write_text("<package><name>acme_parts</name></package>")
    inner = example.arm(xyz="0 0 ${height}")
    (parts / "urdf/arm.xacro").write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:macro name="acme" params="height">'
        f"{inner}</xacro:macro></robot>"
    )
    source = tmp_path / "src/cloned/urdf/acme.urdf.xacro"
    source.write_text(XACRO)
    runs = count_runs(monkeypatch)
    made = new_robot(source, arguments={"lift": "0.5"}, base="world")
    assert len(runs) == 2, "once, and once more for xacrodoc to see that nothing is left to be done"
    assert made.name == "acme"
    assert 'xyz="0.0 0.0 0.5"' in str(made.files[Path("acme.urdf")])
    assert any(path.suffix == ".obj" for path in made.files)
    (parts / "package.xml").unlink()
    from workbench.robot.packages import _package_name

    _package_name.cache_clear()
    parts.rename(tmp_path / "src/gone")
    with pytest.raises(InputError, match="needs the package 'acme_parts'; say --package acme_parts=DIR"):
        new_robot(source)
    with pytest.raises(InputError, match="no such file"):
        new_robot(tmp_path / "none.xacro")


def test_xacro_that_is_called_urdf(tmp_path):
    """As many are; what is xacro in a comment alone is none."""
    source = tmp_path / "acme.urdf"
    head = '<robot name="acme" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="world"/>'
    lift = '<xacro:property name="lift" value="0.5"/>'
    source.write_text(f"{head}{lift}{example.arm(xyz='0 0 ${lift}')}</robot>")
    assert 'xyz="0.0 0.0 0.5"' in str(new_robot(source, base="world").files[Path("acme.urdf")])
    source.write_text("<<<<<<< HEAD\n" + source.read_text())
    with pytest.raises(InputError, match=r"is not XML: .* line 1, column 1; mend it there"):
        new_robot(source)
    source.write_text(f"{head}<!-- {lift}\n-->{example.arm()}</robot>")
    assert not is_xacro(source, source.read_text())
    with pytest.raises(InputError, match="is no xacro: nothing in it takes lift; leave"):
        new_robot(source, arguments={"lift": "0.5"})


def test_a_xacro_file_that_asks_for_more_says_what_it_takes(tmp_path):
    head = '<robot name="acme" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="model"/>'
    source = tmp_path / "acme.urdf.xacro"
    rest = '<xacro:arg name="lift" default="0"/><link name="$(arg model)"/>'
    source.write_text(f"{head}{rest}</robot>")
    with pytest.raises(InputError, match=r"NAME:=VALUE behind the file; it takes model, lift$"):
        new_robot(source)
    source.write_text(f"{head.replace('acme', '$(arg place)', 1)}{rest}</robot>")
    with pytest.raises(InputError, match=r"given as place:=VALUE behind the file; it takes model, lift$"):
        new_robot(source)


def test_a_xacro_file_of_macros_names_the_file_that_calls_them(tmp_path):
    space = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    macro = tmp_path / "acme_macro.xacro"
    macro.write_text(
        f'<robot {space}><xacro:macro name="acme" params="">{example.arm()}</xacro:macro></robot>'
    )
    with pytest.raises(InputError, match=r"makes no link by itself; name the file that calls its macros$"):
        new_robot(macro)
    call = f'<robot name="acme" {space}><xacro:include filename="acme_macro.xacro"/><link name="world"/>'
    (tmp_path / "acme.xacro").write_text(f"{call}<xacro:acme/></robot>")
    with pytest.raises(InputError, match=r"calls its macros: acme\.xacro$"):
        new_robot(macro)
    assert len(new_robot(tmp_path / "acme.xacro").chain.joints) == 6


def test_what_a_xacro_file_names_counts_from_its_own_folder(tmp_path, monkeypatch):
    """Files that it includes, from a folder with letters that mean something to xacro, standing elsewhere."""
    folder = tmp_path / "acme & Co"
    (folder / "parts").mkdir(parents=True)
    space = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
    (folder / "parts/arm.xacro").write_text(f'<robot {space}><xacro:include filename="limbs.xacro"/></robot>')
    (folder / "parts/limbs.xacro").write_text(f"<robot {space}>{example.arm()}</robot>")
    top = f'<robot name="acme" {space}><link name="world"/>'
    (folder / "acme.xacro").write_text(f'{top}<xacro:include filename="parts/arm.xacro"/></robot>')
    monkeypatch.chdir(tmp_path)
    assert len(new_robot(Path("acme & Co/acme.xacro")).chain.joints) == 6


def test_meshes_of_the_machine_that_expanded_the_urdf(tmp_path):
    """Its files are not here, their package is."""
    urdf = example.package(tmp_path / "cloned")
    text = urdf.read_text()
    urdf.write_text(text.replace("package://", "file:///opt/maker/install/parts/share/"))
    made = new_robot(urdf)
    assert any(path.suffix == ".obj" for path in made.files)
    assert not any("not there" in note for note in made.notes)
    urdf.write_text(text.replace("package://acme_description", "file:///opt/maker/share/elsewhere"))
    assert "say --package elsewhere=DIR" in new_robot(urdf).notes[0]


def test_a_package_that_is_there_is_not_asked_for(tmp_path):
    """Some of its meshes lack: no other folder would help."""
    urdf = example.package(tmp_path / "cloned")
    (tmp_path / "cloned/meshes/part.dae").unlink()
    (note,) = new_robot(urdf).notes[:1]
    assert "1 of 2 meshes is not there" in note
    assert "--package" not in note


def test_a_package_is_looked_for_once(tmp_path, monkeypatch):
    """However many meshes are in it: the walk among folders may be long."""
    asked = []
    monkeypatch.setattr(packages, "package_folder", lambda name, **_: asked.append(name))
    (tmp_path / "acme.urdf").write_text(example.robot(example.arm()))
    new_robot(tmp_path / "acme.urdf")
    assert asked == ["acme_description"]
