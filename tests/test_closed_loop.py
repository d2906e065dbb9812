"""The closed loop: its statics are the arm's, its gears push back, its correction works in motion."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from extended_example import extended, extended_kr500
from held_still import hold

from workbench.campaign.problem import Problem
from workbench.correction.command import compensate
from workbench.correction.conditions import Conditions, path_campaign
from workbench.correction.extended_arm import extended_arm
from workbench.correction.path_shapes import Run, line, work_frame
from workbench.correction.paths import Path, write_path
from workbench.effects import catalogue
from workbench.effects.gear_kinematic_error import GearKinematicError
from workbench.effects.hose_torque import HoseTorque
from workbench.effects.kinds import InstrumentEffect
from workbench.effects.place import Where
from workbench.effects.records import record
from workbench.effects.thermal_growth import ThermalGrowth
from workbench.effects.unnamed.joints import Pair, Product
from workbench.files.faults import InputError
from workbench.report.numbers import mm
from workbench.robot.compensator import compensator_law
from workbench.robot.description import load_robot
from workbench.robot.elastic_plant import elastic_twin
from workbench.robot.equilibrium import equilibrium
from workbench.robot.loop import Loop
from workbench.robot.rigid_plant import arrays, link_poses, rigid_twin
from workbench.simulation.closed_loop import scene as scene_of_loop
from workbench.simulation.closed_loop import verify, verify_file
from workbench.simulation.closed_loop.control import nominal_mechanics
from workbench.simulation.closed_loop.drives import drives
from workbench.simulation.closed_loop.dynamics import Along, Dynamics
from workbench.simulation.closed_loop.file import Verified
from workbench.simulation.closed_loop.gears import Gears
from workbench.simulation.closed_loop.machine import machine
from workbench.simulation.closed_loop.measures import figures, main_lines, path_accuracy
from workbench.simulation.closed_loop.mechanics import mechanics
from workbench.simulation.closed_loop.motion import motion
from workbench.simulation.closed_loop.page import page as whole_page
from workbench.simulation.closed_loop.pictures import pictures, sweep_picture
from workbench.simulation.closed_loop.repeatability import repeatability
from workbench.simulation.closed_loop.simulation import run
from workbench.simulation.closed_loop.verification import Sweep, speed_text

LOADS = Conditions(
    "heavy",
    150.0,
    (0.15, 0.02, 0.05),
    20.0,
    (0.0, 0.0, 0.1),
    wrench=(200.0, -100.0, 300.0, 20.0, 10.0, -15.0),
    temperature=27.0,
    clock=7200.0,
)
SMOOTH = Loop(coulomb=0.0)  # no dry friction, which holds a tool where it comes to rest first
LIGHT = replace(LOADS, payload_mass=3.0, tool_mass=0.5, wrench=(5.0, -5.0, 10.0, 0.2, 0.1, 0.3))
POSES = {
    "kr500": (0.3, -1.0, 1.2, 0.4, 0.7, 0.2),
    "longlink": (0.2, 0.6, 0.3, 0.8, -0.4, 0.9, 0.1),
    "cylindrical": (0.4, 0.2, 0.25),
    "ur5": (0.3, -1.0, 1.2, 0.4, 0.7, 0.2),
}


def standing(name):
    """A path that stands still, and its problem."""
    robot = load_robot(name)
    q = np.tile(POSES[name], (2, 1))
    path = Path(np.array([0.0, 1.0]), q=q)
    arm = arrays(robot)
    loads = LOADS if name == "kr500" else LIGHT
    whole = Problem(robot, arm, path_campaign(robot, path, q, loads), compensator_law(robot, arm))
    return path, loads, whole


def of_each_cause():
    """Robots with one effect each: every cause and variant that acts on a standing arm."""
    cases = []
    for name in ("kr500", "longlink", "cylindrical", "ur5"):
        robot = load_robot(name)
        _, _, whole = standing(name)
        seen = set()
        for cause, kind in catalogue().items():
            if issubclass(kind, InstrumentEffect) or cause == "readback_joints":
                continue
            for place in kind.places(whole):
                if cause == "gear_kinematic_error" and place.where.order is None:
                    place = replace(place, where=replace(place.where, order=37.5))
                form = cause, place.variant.split(" ")[0], getattr(place, "sliding", False)
                # on the other robots what the first one lacks: bearings, sliding and rigid joints
                if form in seen or (
                    name != "kr500"
                    and cause not in ("bearing_tilt", "joint_compliance", "backlash", "link_bending")
                ):
                    continue
                seen.add(form)
                values = [1.3 * p.typical for p in place.params]
                item = record(place, np.array(values))
                cases.append(pytest.param(name, replace(robot, effects=(item,)), id=f"{name}-{place.label}"))
    return [*cases, pytest.param("kr500", extended_kr500(), id="kr500-all")]


@pytest.mark.parametrize(("name", "robot"), of_each_cause())
def test_statics_are_the_arms(name, robot):
    """Springs slack at first, command held: the tool settles within 1 µm of the arm's loaded pose.

    The long-link arm swings at 1 to 2 Hz for half a minute, a gear that softens nearly as long, and a motor
    that is shaken crosses its play: they start loaded, and have to stay there.
    """
    path, loads, whole = standing(name)
    whole = replace(whole, robot=robot, arm=arrays(robot))
    side = np.where(np.arange(path.q.shape[1]) % 2, -1.0, 1.0)
    ext = extended_arm(whole)
    here = ext.at(path.q, np.stack([side, side]), slice(0, 2))
    arm, pull = ext.loads(here)
    _, where, _ = equilibrium(arm, path.q, ext.direct(here), pull, ext.acting.yielding(arm).motion)
    truth = mechanics(robot, path, path.q, loads)
    moved = hold(path.q[0], 1.8 if name == "kr500" else 1.0, side)
    swings = name == "longlink" or any(e.variant == "cubic" or e.cause == "backlash" for e in robot.effects)
    done = run(truth, nominal_mechanics(robot, truth), moved, at_rest=swings, loop=SMOOTH)
    off = done.tool[-1, :3, 3] - where.p[-1][0]
    turned = where.R[-1][0].T @ done.tool[-1, :3, :3]
    assert np.abs(off).max() < 1e-6
    assert np.abs(turned - np.eye(3)).max() < 1e-6
    for slot, X in enumerate(done.links[-1]):  # what the scene shows of base and links
        assert np.abs(X[:3, 3] - where.p[slot][0]).max() < 1e-6
        assert np.abs(X[:3, :3] - where.R[slot][0] @ arm.R_link[slot]).max() < 1e-6


def test_the_drives_bear_what_a_hose_pulls():
    """At rest they ask for what Drake's elastic twin says, and with that the arm stays where it is."""
    path, loads, whole = standing("kr500")
    robot = extended(load_robot("kr500"), [(HoseTorque(Where(joint=f"joint_{j}")), [300.0]) for j in (4, 5)])
    whole = replace(whole, robot=robot, arm=arrays(robot))
    ext = extended_arm(whole)
    here = ext.at(path.q[:1], np.zeros((1, 6)), slice(0, 1))
    arm, pull = ext.loads(here)
    assert np.abs(pull.torque[0, 3:5]).min() > 100
    twin = elastic_twin(arm, robot, ext.acting.yielding(arm), compensator=pull.compensator)
    twin.equilibrium(path.q[0], ext.direct(here)[0], pull)
    truth = mechanics(robot, path, path.q, loads)
    done = run(truth, nominal_mechanics(robot, truth), hold(path.q[0], 0.1, np.zeros(6)), loop=SMOOTH)
    assert done.torque[0] == pytest.approx(twin.drive_torque(), abs=1e-4)
    assert done.torque[-1] == pytest.approx(done.torque[0], abs=1e-2)
    assert np.abs(done.motor).max() < 1e-9


def test_a_warming_arm_grows_while_it_is_simulated():
    """Held still while the temperature of the path rises by 10 K."""
    robot = extended(load_robot("kr500"), [(ThermalGrowth(), [1.15e-5])])
    q = np.tile(POSES["kr500"], (2, 1))
    path = Path(np.array([0.0, 0.3]), q=q, temperature=np.array([20.0, 30.0]))
    whole = Problem(robot, arrays(robot), path_campaign(robot, path, q, LOADS))
    whole = replace(whole, compensator=compensator_law(robot, whole.arm))
    ext = extended_arm(whole)
    arm, pull = ext.loads(ext.problem)
    direct = ext.direct(ext.problem)
    wanted = equilibrium(arm, q, direct, pull, ext.acting.yielding(arm).motion)[1].p[-1]
    truth = mechanics(robot, path, q, LOADS)
    done = run(truth, nominal_mechanics(robot, truth), motion(path.time, q), loop=SMOOTH)
    grown = done.tool[-1, :3, 3] - done.tool[0, :3, 3]
    assert np.linalg.norm(grown) > 1e-4
    assert np.abs(grown - (wanted[1] - wanted[0])).max() < 2e-6


@pytest.mark.parametrize(
    "effect",
    [
        Pair(Where(joint="joint_2", other="joint_5")),
        Product(Where(joint="joint_2", other="joint_5"), third=2.0),
    ],
)
def test_what_hangs_on_two_joints_together_is_simulated(effect):
    """It is no sum over the motors: from pose to pose the tool moves as the arm's does."""
    values = 3e-4 * np.sin(np.arange(len(effect.params)))
    start = np.array(POSES["kr500"])
    end = start + np.array([0.0, 0.1, 0.1, 0.0, 0.1, 0.0])
    q = np.stack([start, start, end, end])
    path = Path(np.array([0.0, 0.2, 1.2, 2.0]), q=q)
    ends, wanted = [], []
    for effects in ([(effect, values.tolist())], []):
        robot = extended(load_robot("kr500"), effects)
        whole = Problem(robot, arrays(robot), path_campaign(robot, path, q, LOADS))
        ext = extended_arm(replace(whole, compensator=compensator_law(robot, whole.arm)))
        arm, pull = ext.loads(ext.problem)
        rest = equilibrium(arm, q, ext.direct(ext.problem), pull, ext.acting.yielding(arm).motion)[1]
        truth = mechanics(robot, path, q, LOADS)
        done = run(truth, nominal_mechanics(robot, truth), motion(path.time, q), loop=SMOOTH)
        ends.append(done.tool[[0, -1], :3, 3])
        wanted.append(rest.p[-1][[0, -1]])
    change = wanted[0] - wanted[1]
    assert np.abs(change).max() > 1e-4
    assert np.abs(ends[0] - ends[1] - change).max() < 1e-6


SWEPT = ("uncorrected", "corrected", "elastic", "rigid")
RIPPLE = GearKinematicError(Where(joint="joint_2", order=800.0)), [5e-5, 2e-5]
TABLE = Run(work_frame((1.7, 0.2, 0.9)), speed=0.05, acceleration=0.05, period=0.02)


@cache
def proof():
    """A robot with a gear's ripple, corrected by a model that does not know it."""
    truth = extended(load_robot("kr500"), [RIPPLE])
    belief = replace(truth, effects=())
    return verify(line(0.1, TABLE), truth, belief, LOADS, speeds=None, repeats=2)


def test_ripple_is_left_by_a_model_that_does_not_know_it():
    trials = proof().series[0].trials
    left, perfect = trials["corrected"].figures, trials["perfect"].figures
    assert trials["geometry"].figures.rms_mm > 10 * left.rms_mm  # it sags under the load
    assert left.rms_mm > 0.03
    assert trials["corrected"].lines[0].cause == "joint_2, 800 per joint turn"
    assert proof().series[0].ratio_to_perfect == pytest.approx(left.rms_mm / perfect.rms_mm)
    assert not proof().same


def test_the_loops_own_lag_is_corrected():
    """A gear's ripple under load pushes its motor off: the model that knows both corrects the command for
    it."""
    truth = extended(load_robot("kr500"), [RIPPLE])
    found = verify(line(0.02, TABLE), truth, truth, LOADS, speeds=None, repeats=0, feed_forward="loop")
    static, led = (found.slow.trials[name].figures for name in ("corrected", "loop"))
    assert led.rms_mm < 0.4 * static.rms_mm
    assert led.rz_mm < 0.4 * static.rz_mm


def test_the_scene_replays_the_simulated_arm(monkeypatch):
    """Link by link, with the tool at the last: not a rigid arm at the commanded joints."""
    found, shown = proof(), []
    draw = scene_of_loop.draw_links
    monkeypatch.setattr(scene_of_loop, "draw_links", lambda *args: (shown.append(args), draw(*args)))
    scene_of_loop.scene(found)
    ((_, robot, poses, _, time),) = shown
    trial = found.slow.trials["corrected"]
    rows = [int(np.argmin(np.abs(found.slow.time - t))) for t in time]  # the slow path is shown at its pace
    assert len(rows) > 20
    tool = (found.X[:, :3, 3] + trial.error)[rows]
    held = np.einsum("fji,fj->fi", poses[:, -1, :3, :3], tool - poses[:, -1, :3, 3])
    twin = rigid_twin(robot)
    X_LF = twin.plant.GetFrameByName(robot.flange).CalcPoseInBodyFrame(twin.context)
    assert np.abs(held - X_LF.translation()).max() < 1e-9
    rigid = link_poses(robot, compensate(robot, found.path, LOADS).q_command[rows])
    assert np.abs(rigid[:, -1] - poses[:, -1]).max() > 5e-4  # it sags


def unchanged(found):
    """The same verification, had the correction done nothing."""
    series = found.slow
    before = series.trials["uncorrected"]
    same = dict.fromkeys(series.trials, before)
    return replace(found, series=(replace(series, trials=same),))


def test_what_stays_is_not_said_to_fall():
    found = unchanged(proof())
    text = whole_page(found)
    rms = mm(found.slow.trials["corrected"].figures.rms_mm)
    assert f"<h1>The correction changes nothing here: the error stays at {rms} mm RMS" in text
    assert f"A model without any error would reach the same {rms} mm." in text
    assert "before and after" in text
    assert "falls from" not in text
    for before, after in re.findall(r"(?:from|largest) ([\d.]+) (?:to|→) ([\d.]+) mm", text):
        assert before != after
    assert "falls from" in whole_page(proof())


def test_what_is_the_same_all_along_the_path_is_said():
    """Uncorrected, the tool is 3 mm beside its path everywhere: another base takes that; not so a wave."""
    found, wave = proof(), np.sin(np.linspace(0, 30, len(proof().X)))
    for error, left in ((np.full_like(wave, 3e-3), 0.0), (3e-3 * wave, None)):
        before = replace(found.slow.trials["uncorrected"], error=np.outer(error, [0.0, 0.0, 1.0]))
        trials = {**found.slow.trials, "uncorrected": before}
        seen = replace(found, series=(replace(found.slow, trials=trials),))
        assert seen.anew_rms_mm == (left if left is None else pytest.approx(left, abs=1e-6))
        for text in (whole_page(seen), Verified(seen, ()).text):
            assert ("same all along the path" in text) == (left is not None)


def test_half_the_step_changes_nothing():
    series = proof().series[0]
    assert 1e-3 * series.step_change_um < 0.005 * series.trials["corrected"].figures.rms_mm
    assert not series.refined


def test_repeats_scatter_by_the_joints():
    before, after = proof().repeats
    assert (before.count, before.speed) == (2, proof().series[0].speed)
    assert 0.001 < after.rt_mm < 0.1
    assert after.at_mm < before.at_mm


def test_the_data_sheets_repeatability_stands_beside_every_residual():
    found = proof()
    assert found.repeatability.data_sheet_mm == 0.08  # the KR 500's, not what its joints' makes
    joints = found.repeatability.joints_mm
    assert 0.02 < joints < 0.08
    said = "repeatability 0.080 mm by data sheet"
    text = Verified(found, ()).text
    assert text.count(said) == len(found.series)
    assert f"data sheet 0.080 mm, the joints' own {mm(joints)} mm at the tool" in text
    written = whole_page(found)
    assert written.count(said) >= 2 * len(found.series)  # tile and table
    along = pictures(found)[0]
    sweep = sweep_picture(Sweep(np.array([0.01, 1.0]), dict.fromkeys(SWEPT, np.array([0.05, 0.5]))),
                          found.repeatability)  # fmt: skip
    for drawn in (along, sweep):
        assert "Repeatability by data sheet" in drawn.svg
        assert "Repeatability of the joints" in drawn.svg
    numbers = found.to_json()
    assert numbers["pose_repeatability_mm"] == 0.08
    assert numbers["joints_repeatability_mm"] == pytest.approx(joints, rel=1e-5)


def test_unknown_repeatability_is_said_to_be():
    robot = load_robot("longlink")  # a paper's arm, without a data sheet; its joints' is stated
    q = np.tile(POSES["longlink"], (2, 1))
    assert repeatability(robot, q).short.endswith("by the joints, no data sheet's")
    found = replace(proof(), repeatability=repeatability(load_robot("cylindrical"), np.zeros((2, 3))))
    assert "repeatability not known" in whole_page(found)
    assert "not known, neither a data sheet's nor the joints'" in Verified(found, ()).text
    assert "Repeatability" not in pictures(found)[0].svg
    assert found.to_json()["pose_repeatability_mm"] is None


def moving():
    """A run's robot, the nominal one, and the command."""
    robot = extended(load_robot("kr500"), [RIPPLE])
    path = line(0.02, TABLE)
    q = compensate(robot, path, LOADS).q_command
    truth = mechanics(robot, path, q, LOADS)
    return truth, nominal_mechanics(robot, truth), motion(path.time, q)


def test_the_gear_pushes_back():
    """Without the reaction on the motor the tool goes wrong where the gear's error is steep."""
    truth, nominal, moved = moving()
    with_it = run(truth, nominal, moved)
    without = run(truth, nominal, moved, reaction=False)
    off = np.linalg.norm(with_it.tool[:, :3, 3] - without.tool[:, :3, 3], axis=1)
    assert off.max() > 3e-6


def test_gear_and_spring_have_one_potential():
    """What spring and motor feel is the gradient of U(e − δ(q))."""
    truth, _, moved = moving()
    drive = drives(truth, moved.q[0], SMOOTH)
    built = machine(truth, drive)
    gears = Gears(truth, moved.q)
    j, k = truth.arm.names.index("joint_2"), len(moved.q) // 2
    at, motor, e = int(built.own_at[built.own[j]]), int(built.motors[j]), 3e-4
    felt = []
    for reaction in (True, False):
        dynamics = Dynamics(truth, built, drive, SMOOTH, gears, Along(), 5e-4, reaction)
        force, x = np.zeros(dynamics.size), np.zeros(2 * dynamics.size)
        x[built.motors], x[at] = moved.q[k], e
        dynamics.springs.add(x[dynamics.size :], x.tolist(), dynamics.side, force)
        force[at] -= built.stiffness[built.own[j]] * e  # the plant's own spring
        felt.append(force)

    def potential(q, stretch):
        return 0.5 * built.stiffness[built.own[j]] * (stretch - truth.gear_error(q[None], q[None])[0, j]) ** 2

    step = np.eye(truth.arm.n)[j] * 1e-7
    q = moved.q[k]
    by_motor = (potential(q + step, e) - potential(q - step, e)) / 2e-7
    by_spring = (potential(q, e + 1e-7) - potential(q, e - 1e-7)) / 2e-7
    assert felt[0][at] == pytest.approx(-by_spring, rel=1e-3)
    assert (felt[0] - felt[1])[motor] == pytest.approx(-by_motor, rel=1e-3)


def test_gear_and_damper_lose_what_slides():
    """Spring and motor together lose c (ė − δ′ q̇)², with the damper that the plant itself has."""
    truth, _, moved = moving()
    drive = drives(truth, moved.q[0], Loop(viscous=0.0))
    built = machine(truth, drive)
    j, q, e = truth.arm.names.index("joint_2"), moved.q[len(moved.q) // 2], 3e-4
    i = built.own[j]
    at, motor = int(built.own_at[i]), int(built.motors[j])
    dynamics = Dynamics(truth, built, drive, Loop(viscous=0.0), Gears(truth, moved.q), Along(), 5e-4)
    size, still, fast = dynamics.size, np.zeros(dynamics.size), np.zeros(dynamics.size)
    x = np.zeros(2 * size)
    x[built.motors], x[at] = q, e
    dynamics.springs.add(x[size:], x.tolist(), dynamics.side, still)
    x[size + at], x[size + motor] = 2e-3, 0.3
    dynamics.springs.add(x[size:], x.tolist(), dynamics.side, fast)
    step = np.eye(truth.arm.n)[j] * 1e-7
    ahead, behind = (truth.gear_error((q + s * step)[None], q[None])[0, j] for s in (1, -1))
    slides = 2e-3 - (ahead - behind) / 2e-7 * 0.3
    assert (fast - still)[at] - drive.damping[j] * 2e-3 == pytest.approx(-drive.damping[j] * slides, rel=1e-4)
    lost = (fast - still)[at] * 2e-3 - drive.damping[j] * 2e-3**2 + (fast - still)[motor] * 0.3
    assert lost == pytest.approx(-drive.damping[j] * slides**2, rel=1e-4)


def test_two_runs_are_bitwise_equal():
    truth, nominal, moved = moving()
    first, second = (run(truth, nominal, moved) for _ in range(2))
    assert np.array_equal(first.states, second.states)


def test_an_encoders_steps_show_a_little():
    truth, nominal, moved = moving()
    fine = run(truth, nominal, moved)
    coarse = run(truth, nominal, moved, loop=Loop(encoder_steps=65536.0))
    off = np.linalg.norm(fine.tool[:, :3, 3] - coarse.tool[:, :3, 3], axis=1)
    assert 1e-9 < off.max() < 2e-5
    rough, smooth = (np.abs(np.diff(done.torque, n=2, axis=0)).max(axis=0) for done in (coarse, fine))
    assert (rough > 5 * smooth).all()  # every count is a jump of the speed that is seen


def test_iso_figures():
    runs = [
        np.array([[0.0, 0.001, 0.0], [0.0, 0.002, 0.0]]),
        np.array([[0.0, 0.003, 0.0], [0.0, 0.002, 0.0]]),
    ]
    at, rt = path_accuracy(runs)
    assert at == pytest.approx(2.0)
    assert rt == pytest.approx(1.0)  # both runs are 1 mm off their mean: l̄ = 1, S = 0


def test_a_constant_height_is_no_roughness():
    error = np.tile([0.0, 0.0, 2e-4], (100, 1))
    found = figures(error, error, error[:, 2], np.arange(100.0))
    assert (found.ra_mm, found.rz_mm) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert found.offset_mm == pytest.approx(0.2)


def test_a_wave_along_the_whole_path_has_its_whole_height():
    """R_z is never below R_a, however long the wave is."""
    z = 1e-4 * np.sin(np.linspace(0, 2 * np.pi, 1001))
    error = np.outer(z, [0.0, 0.0, 1.0])
    found = figures(error, error, z, np.arange(1001.0))
    assert found.rz_mm == pytest.approx(0.2)
    assert found.ra_mm == pytest.approx(0.2 / np.pi, rel=0.01)


def test_a_gear_is_named_by_its_order():
    t = np.linspace(0, 10, 5000)
    q = np.stack([0.05 * t, 0.02 * t + 0.01 * np.sin(t)], axis=1)
    error = 1e-5 * np.stack([np.sin(300 * q[:, 1]), 0 * t, np.cos(300 * q[:, 1])], axis=1)
    found = main_lines(t, error, q, [("a", 0, 100.0), ("b", 1, 300.0), ("c", 1, 90.0)])
    assert found[0].cause == "b"


@pytest.fixture
def files(tmp_path):
    path = tmp_path / "line.csv"
    write_path(path, line(0.02, TABLE))
    return path


def test_files_are_whole(files, tmp_path):
    done = verify_file(files, "kr500", None, tmp_path / "out", speeds=None, repeats=0)
    assert sorted(file.name for file in done.files) == [
        "errors.csv",
        "scene.html",
        "verify.html",
        "verify.json",
    ]
    errors = np.genfromtxt(tmp_path / "out" / "errors.csv", delimiter=",", names=True)
    size = np.linalg.norm([errors[f"corrected_{axis}_mm"] for axis in "xyz"], axis=0)
    assert size.max() == pytest.approx(done.found.slow.trials["corrected"].figures.max_mm)
    page = (tmp_path / "out" / "verify.html").read_text(encoding="utf-8")
    assert "<svg" in page
    assert "nan" not in page
    assert "PerspectiveCamera" in (tmp_path / "out" / "scene.html").read_text(encoding="utf-8")
    assert "AT" in done.text
    assert done.text.startswith("The model ran against itself: this shows what the controller adds")
    assert "<h1>The model ran against itself: this shows what the controller adds" in page
    assert "times as accurate" not in page
    assert "true robot" not in page
    assert done.to_json()["speeds"][0]["commands"]["corrected"]["rms_mm"] < 0.1


@pytest.mark.filterwarnings("error")
def test_a_path_of_a_tenth_of_a_millimetre_has_its_page(tmp_path):
    """It is over in 3 ms: no line of the spectrum lies below 100 Hz."""
    q = np.array(POSES["kr500"]) + np.linspace(0, 3e-5, 3)[:, None] * np.array([1.0, 0, 0, 0, 0, 0])
    path = tmp_path / "path.csv"
    write_path(path, Path(0.001 * np.arange(3.0), q=q))
    done = verify_file(path, "kr500", None, tmp_path / "out", speeds=[0.03], repeats=0)
    assert "nan" not in (tmp_path / "out" / "verify.html").read_text(encoding="utf-8")
    assert done.found.slow.time[-1] - done.found.slow.time[0] < 0.01


@pytest.mark.parametrize(
    ("model", "truth", "said"),
    [
        ("kr500", "kr120", "same robot"),
        ("kr500", "nothing", "no such robot"),
        ("ur5", None, "line 2: the tool cannot get there"),
    ],
)
def test_what_cannot_be_leaves_nothing_behind(files, tmp_path, model, truth, said):
    with pytest.raises(InputError, match=said):
        verify_file(files, model, truth, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_tool_that_turns_where_it_is_runs_in_the_paths_own_time():
    """Axis 6 alone turns by 20° in 1 s: its flange, on the axis, goes nowhere."""
    robot = load_robot("kr500")
    q = np.tile(POSES["kr500"], (21, 1))
    q[:, 5] += np.radians(np.linspace(0, 20, 21))
    path = Path(np.linspace(0, 1, 21), q=q)
    done = verify(path, robot, robot, speeds=[0.03, 0.3], repeats=0)
    (series,) = done.series
    assert series.speed == 0.0
    assert 1.0 <= series.time[-1] < 2.0  # and comes to rest; no speed in m/s stretches it
    assert any("run in the path's own time" in note for note in done.notes)
    assert series.trials["corrected"].figures.rms_mm < 0.1 * series.trials["uncorrected"].figures.rms_mm
    assert speed_text(series.speed) == "the path's own speed"
    with pytest.raises(InputError, match="--sweep"):
        verify(path, robot, robot, speeds=None, repeats=0, sweep=True)


def test_bad_calls_are_told(files):
    with pytest.raises(InputError, match="m/s"):
        verify_file(files, "kr500", speeds=[0.0])
    still = Path(np.array([0.0, 1.0]), q=np.tile(POSES["kr500"], (2, 1)))
    with pytest.raises(InputError, match="does not move"):
        verify(still, load_robot("kr500"), load_robot("kr500"))
