"""Joints, points and robot that do not belong together are named, and an honest robot never is."""

import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from diagnosis_cases import measured
from scipy.optimize import least_squares

from workbench.campaign import Campaign, Target, write_campaign
from workbench.campaign.planned import TARGETS, planned, random_poses
from workbench.campaign.problem import problem_of
from workbench.cli.main import main
from workbench.diagnosis import prepared as preparation
from workbench.diagnosis.data_faults.wild_points import much_left_out
from workbench.diagnosis.first_look import first_look
from workbench.effects import catalogue
from workbench.files.faults import InputError
from workbench.identification import parameters
from workbench.identification.plausible import believed, judge, plausible_geometry
from workbench.report.first_look import check_campaign
from workbench.robot import rotations
from workbench.robot.description import load_robot
from workbench.robot.kinematics import frames
from workbench.simulation.random_robot import write_random_robot
from workbench.simulation.virtual_campaign import Truth, random_geometry, simulate
from workbench.studies.blind.cases import draw_case


def remarks(problem):
    return believed(problem)[1]


ROBOTS = ("ur5", "kr500", "6R")


@cache
def honest(name="ur5", count=3) -> Campaign:
    return measured(name, poses=40, loads=(), targets=count)


def joints(campaign, change):
    q = campaign.poses.q.copy()
    change(q)
    return campaign.with_poses(q=q)


def points(campaign, change):
    return replace(campaign, points=change(campaign.points.copy()))


def flip(j):
    return lambda c: joints(c, lambda q: q.__setitem__((slice(None), j), -q[:, j]))


def turn(j, degrees):
    return lambda c: joints(c, lambda q: q.__setitem__((slice(None), j), q[:, j] + np.radians(degrees)))


def swap(i, j):
    return lambda c: joints(c, lambda q: q.__setitem__((slice(None), [i, j]), q[:, [j, i]]))


def couple(j, i, sign):
    return lambda c: joints(c, lambda q: q.__setitem__((slice(None), j), q[:, j] + sign * q[:, i]))


def column(j, factor):
    return lambda c: joints(c, lambda q: q.__setitem__((slice(None), j), q[:, j] * factor))


BLUNDERS = {
    **{f"joint {j + 1} flipped": (flip(j), f"sign of q{j + 1}") for j in (1, 4)},
    "joints 2 and 3 exchanged": (swap(1, 2), "columns q2 and q3"),
    "zero of joint 2 by 90": (turn(1, 90), "add -90° to q2"),
    "zero of joint 5 by 180": (turn(4, 180), "add +180° to q5"),
    "joint 3 coupled": (couple(2, 1, 1.0), "write q3 minus q2 into the column q3"),
    "left-handed": (lambda c: points(c, lambda z: z * [1, -1, 1]), "left-handed"),
    "inches as mm": (lambda c: points(c, lambda z: z / 25.4), "points fit the robot only if they are inches"),
    "x in metres": (lambda c: points(c, lambda z: z * [1e-3, 1, 1]), "x fit the robot only if they are m"),
    "a row too many": (lambda c: points(c, lambda z: np.roll(z, 1, axis=0)), "every point belongs to the"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("blunder", "name"), [(blunder, ROBOTS[i % len(ROBOTS)]) for i, blunder in enumerate(BLUNDERS)]
)
def test_a_mistake_is_named_with_its_mend(blunder, name):
    spoil, said = BLUNDERS[blunder]
    with pytest.raises(InputError) as caught:
        believed(problem_of(spoil(honest(name))))
    assert said in str(caught.value)


def test_a_mistake_is_named_without_stated_targets():
    spoil, said = BLUNDERS["inches as mm"]
    blind = replace(honest(count=1), targets=(Target("T1"),))
    with pytest.raises(InputError) as caught:
        believed(problem_of(spoil(blind)))
    assert said in str(caught.value)


def test_two_mistakes_at_once_are_both_named():
    spoilt = points(flip(2)(honest()), lambda z: z / 25.4)
    with pytest.raises(InputError) as caught:
        believed(problem_of(spoilt))
    assert {fault.place for fault in caught.value.faults} == {"campaign.toml: poses", "campaign.toml: points"}
    assert "turns the other way" in str(caught.value)
    assert "inches" in str(caught.value)


def test_the_right_robot_is_named():
    other = load_robot("ur10")
    with pytest.raises(InputError, match='say robot = "ur5"'):
        believed(problem_of(replace(honest(), robot=other)))


def shuffled(z):
    return z[np.random.default_rng(0).permutation(len(z))]


def equal(z):
    return np.broadcast_to(z[:1], z.shape).copy()


@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda z: z[np.argsort(z[:, 0, 2])], "explains it; the rows are sorted by z of T1"),
        pytest.param(equal, "none of the usual mistakes", marks=pytest.mark.slow),
        pytest.param(lambda z: 0.87 * z, "a robot of 0.87", marks=pytest.mark.slow),
    ],
    ids=["sorted", "all equal", "a smaller robot"],
)
def test_what_fits_nothing_is_refused(spoil, told):
    with pytest.raises(InputError, match=told):
        believed(problem_of(points(honest(), spoil)))


SOME = np.random.default_rng(2).permutation(40) < 20


def moved(z):
    turn = np.array([[0.96, -0.28, 0.0], [0.28, 0.96, 0.0], [0.0, 0.0, 1.0]])
    return np.concatenate([z[:18], z[18:] @ turn.T + 0.2])


def one_hidden(points):
    """Points (N, 3, 3) of which each pose has two."""
    return np.where((np.arange(len(points)) % 3)[:, None, None] == np.arange(3)[:, None], np.nan, points)


IN_PART = {
    "an instrument moved": (moved, "the instrument or the tool stands elsewhere at the poses 1 … 18"),
    "first in metres": (
        lambda z: np.concatenate([z[:22] / 1e3, z[22:]]),
        "at the poses 1 … 22 the numbers of the points fit the robot only if they are metres",
    ),
    "rows of others": (
        lambda z: np.concatenate([z[:12], np.roll(z[12:], 3, axis=0)]),
        "the poses 13 … 40 do not fit the robot, all others do",
    ),
    "x and y exchanged in the middle": (
        lambda z: np.concatenate([z[:12], z[12:25][..., [1, 0, 2]], z[25:]]),
        "at the poses 13 … 25 x and y of the points are exchanged",
    ),
    "names of two targets that are never seen with a third": (
        lambda z: np.concatenate([one_hidden(z)[:25], one_hidden(z)[25:][:, [1, 0, 2]]]),
        "at the poses 26 … 40 the names of the targets T1 and T2 are exchanged",
    ),
    "two instruments": (
        lambda z: np.where(SOME[:, None, None], z[..., [1, 2, 0]] + 0.3, z),
        "the instrument or the tool stands elsewhere at 20 of 40 poses (",
    ),
}


@pytest.mark.parametrize("case", IN_PART)
def test_a_mistake_of_a_part_of_the_poses_says_which(case):
    spoil, said = IN_PART[case]
    with pytest.raises(InputError) as caught:
        believed(problem_of(points(honest(), spoil)))
    assert said in str(caught.value)


@pytest.mark.parametrize("share", [0.25, 0.5])
def test_a_sign_turned_at_poses_here_and_there_is_named(share):
    """However few of the points they are: none of so many is silently left out."""
    some = np.random.default_rng(1).permutation(40) < 40 * share
    half = joints(honest(), lambda q: q.__setitem__((some, 2), -q[some, 2]))
    with pytest.raises(InputError) as caught:
        believed(problem_of(half))
    (said,) = str(caught.value).splitlines()
    assert f"at {some.sum()} of 40 poses" in said
    assert "turns the other way round" in said
    assert "there: turn the sign of q3" in said


def test_so_many_points_left_out_are_told_first():
    """Of six poses of forty nothing is told by what they have in common."""
    few = honest()
    points = few.points.copy()
    points[::7] += np.random.default_rng(0).normal(0.0, 0.5, (6, 3, 3))
    prepared = preparation.prepare(replace(few, points=points))
    assert prepared.notes[0].startswith("18 of 120 points (15%) do not fit the robot that the others fit")
    assert not preparation.prepare(few).notes


def test_where_most_points_are_left_out_nothing_is_told():
    few = problem_of(honest())
    points = few.campaign.points.copy()
    points[:21] = np.nan
    left = replace(few, campaign=replace(few.campaign, points=points))
    with pytest.raises(InputError, match=r"63 of 120 points \(52%\)"):
        much_left_out(few, left)


@pytest.mark.parametrize("fixed", [False, True])
def test_targets_stated_in_a_tool_frame_are_found(fixed):
    """300 mm off, all alike: said where they are, and used so unless they are called calibrated."""
    (x, y, z), other = honest(count=1).targets[0].xyz, honest(count=1)
    stated = replace(other, targets=(replace(other.targets[0], xyz=(x, y, z + 0.3), fixed=fixed),))
    if fixed:
        with pytest.raises(InputError, match="300\\) mm from where they are stated"):
            believed(problem_of(stated))
        return
    (told,) = remarks(problem_of(stated))
    assert "(+0, +0, -300) mm from where they are stated" in told


def framed(read):
    """A 6-D measurement whose quaternions w x y z and places were read otherwise."""
    rng = np.random.default_rng(3)
    plan = honest(count=1)
    place = problem_of(plan).rigid
    R, p = place.R[-1], place.p[-1]
    R, p = read(R, p + rng.normal(0.0, 1e-4, p.shape))
    points = np.stack([p, p + 0.1 * R[:, :, 0], p + 0.1 * R[:, :, 1]], axis=1)
    shots = np.repeat(plan.shots[:, :1], 3, axis=1)
    targets = (Target("P", (0.0, 0.0, 0.0)), Target("P_x"), Target("P_y"))
    return replace(plan, points=points, shots=shots, targets=targets, sigma=None, six_dof=True)


READ = {
    "as they are": (lambda R, p: (R, p), None),
    "scalar last": (
        lambda R, p: (rotations.from_quaternions(rotations.quaternions(R)[:, [1, 2, 3, 0]]), p),
        "qw comes last, not first",
    ),
    "scalar first": (
        lambda R, p: (rotations.from_quaternions(rotations.quaternions(R)[:, [3, 0, 1, 2]]), p),
        "qw comes first, not last",
    ),
    "turns inverted": (lambda R, p: (R.swapaxes(1, 2), p), "turn the signs of qx, qy and qz"),
    "poses inverted": (
        lambda R, p: (R.swapaxes(1, 2), -np.einsum("nji,nj->ni", R, p)),
        "those of the instrument in the target's frame",
    ),
    "other angles": (
        lambda R, p: (rotations.from_xyz(rotations.zyx_angles(R)[:, ::-1]), p),
        "the turns are angles about fixed x, y, z",
    ),
    "other angles back": (
        lambda R, p: (rotations.from_zyx(rotations.xyz_angles(R)[:, ::-1]), p),
        "the turns are angles about x, y, z that turn along",
    ),
    "angles in their order": (
        lambda R, p: (rotations.from_xyz(rotations.zyx_angles(R)), p),
        "the turns are angles about z, y, x",
    ),
    "places mirrored": (
        lambda R, p: (R, p * [1.0, -1.0, 1.0]),
        "y of the places has the wrong sign, the turns have not",
    ),
}


FURTHER = ("scalar first", "other angles back")


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow) if case in FURTHER else case for case in READ]
)
def test_turns_of_a_6d_measurement_read_otherwise_are_named(case):
    read, said = READ[case]
    problem = problem_of(framed(read))
    if said is None:
        assert remarks(problem) == []
        return
    with pytest.raises(InputError) as caught:
        believed(problem)
    assert said in str(caught.value)


@pytest.mark.parametrize("scale", [1.0, 1.01, 0.99])
def test_points_of_another_scale_are_told_with_the_factor(scale):
    """One factor of all lengths, beside errors of half a millimetre each."""
    plan = honest("ur5")
    rough = random_geometry(problem_of(plan).arm, np.random.default_rng(4), 5e-4, 5e-4)
    seen = simulate(plan, Truth(geometry=rough, sigma=3e-5), seed=4)
    notes = preparation.prepare(points(seen, lambda z: scale * z)).notes
    told = [note for note in notes if "All lengths come out" in note]
    assert len(told) == (scale != 1.0)
    for note in told:
        assert float(note.split()[4]) == pytest.approx(scale, abs=2e-3)
        assert f"say scale = {1 / float(note.split()[4]):.3f}" in note


def held_in_sockets(coarse: float):
    """A ball at the hand, in one of three sockets 50 mm apart however the arm turns about it: points hardly
    spread, and what lengths and zeros are off by is as much, or a fifth of that."""
    plan, rng = measured("ur5", poses=30, loads=(), targets=1), np.random.default_rng(5)
    job, ball = problem_of(plan), np.array([0.0, 0.0, 0.13])
    sockets = np.array([(0.45, 0.1, 0.2), (0.5, 0.1, 0.2), (0.475, 0.143, 0.2)])

    def off(q, n):
        hand = frames(job.arm, q[None])
        return hand.p[-1, 0] + hand.R[-1, 0] @ ball - sockets[n % 3]

    q = np.array([least_squares(off, one, args=(n,)).x for n, one in enumerate(plan.poses.q)])
    truth = Truth(geometry=random_geometry(job.arm, rng, coarse * 1e-3, coarse * 5e-3), sigma=2e-4)
    at_ball = replace(plan.targets[0], xyz=tuple(ball.tolist()))
    held = simulate(replace(plan.with_poses(q=q), targets=(at_ball,)), truth, seed=5)
    return replace(held, targets=(replace(at_ball, xyz=None),))


@pytest.mark.parametrize("coarse", [pytest.param(1.0, marks=pytest.mark.slow), 4.0])
def test_a_ball_held_in_sockets_is_no_mistake(coarse):
    held = held_in_sockets(coarse)
    found = judge(problem_of(held))
    assert found.misfit.spread > 0.3  # not the points': as far as these joints move the ball
    assert not found.refused
    assert judge(problem_of(points(held, shuffled))).refused


def test_wild_points_do_not_make_an_inaccurate_robot_another_one():
    plan, rng = honest("ur5"), np.random.default_rng(5)
    geometry = random_geometry(problem_of(plan).arm, rng, 4e-3, 3e-2)
    rough = simulate(plan, Truth(geometry=geometry, sigma=3e-5), seed=5)
    z = rough.points.copy()
    z[[3, 17, 30], [0, 1, 2]] += 0.4
    (said,) = remarks(problem_of(replace(rough, points=z)))
    assert said.startswith("The geometry is up to")


@pytest.mark.parametrize("poses", [10, pytest.param(15, marks=pytest.mark.slow)])
@pytest.mark.parametrize("count", [pytest.param(1, marks=pytest.mark.slow), 3])
def test_few_poses_with_shuffled_points_are_refused(poses, count):
    """However freely so few numbers are fitted, geometry as of machines does not explain them."""
    few = measured("ur5", poses=poses, loads=(), targets=count)
    assert not judge(problem_of(few)).refused
    assert judge(problem_of(points(few, shuffled))).refused


def test_targets_stated_for_one_another_are_only_remarked():
    one, two, three = honest().targets
    renamed = replace(honest(), targets=(replace(one, xyz=two.xyz), replace(two, xyz=one.xyz), three))
    (said,) = remarks(problem_of(renamed))
    assert "targets T1, T2 are stated for one another" in said
    fixed = replace(renamed, targets=tuple(replace(target, fixed=True) for target in renamed.targets))
    with pytest.raises(InputError, match="stated for one another"):
        believed(problem_of(fixed))


@pytest.mark.parametrize("order", [[1, 0, 2], [1, 2, 0]], ids=["two", "three"])
@pytest.mark.parametrize("stated", [True, False])
def test_names_exchanged_at_a_part_of_the_poses(order, stated):
    def mixed(z):
        z[18:] = z[18:][:, order]
        return z

    spoilt = points(honest(), mixed)
    if not stated:
        spoilt = replace(spoilt, targets=tuple(Target(target.name) for target in spoilt.targets))
    names = "T1 and T2" if order[2] == 2 else "T1, T2 and T3"
    with pytest.raises(InputError) as caught:
        believed(problem_of(spoilt))
    (said,) = str(caught.value).splitlines()
    # without stated places the order at the middle pose counts
    count, at = (22, "19, 20, 21 … 40") if stated else (18, "1, 2, 3 … 18")
    assert f"names of the targets {names} are exchanged at {count} of 40 poses ({at})" in said
    assert "exchange them there in the column target" in said


def test_names_exchanged_of_targets_stated_roughly():
    """Stated 6 mm off, so that the nearly equal distances change places: no pose has them as stated."""

    def mixed(z):
        z[18:] = z[18:][:, [1, 0, 2]]
        return z

    places = ((0.148, 0.001, 0.048), (-0.086, 0.136, 0.076), (-0.058, -0.156, 0.123))
    rough = tuple(replace(one, xyz=xyz) for one, xyz in zip(honest().targets, places, strict=True))
    with pytest.raises(InputError, match="T1 and T2 are exchanged at 22 of 40 poses"):
        believed(problem_of(replace(points(honest(), mixed), targets=rough)))


def test_targets_stated_for_one_another_keep_their_points():
    one, two, three = honest().targets
    renamed = replace(honest(), targets=(replace(one, xyz=two.xyz), replace(two, xyz=one.xyz), three))
    prepared = preparation.prepare(renamed)
    assert prepared.faults == ()
    assert [t.xyz for t in prepared.problem.campaign.targets] == [
        pytest.approx(t.xyz) for t in honest().targets
    ]
    left = preparation.prepare(honest()).geometry.chi2
    assert prepared.geometry.chi2 == pytest.approx(left, rel=1e-3)


def test_targets_listed_in_another_order_are_the_same_campaign():
    order = [2, 0, 1]
    same = honest()
    other = replace(
        same,
        points=same.points[:, order],
        shots=same.shots[:, order],
        targets=tuple(same.targets[i] for i in order),
    )
    assert remarks(problem_of(other)) == remarks(problem_of(same)) == []
    assert judge(problem_of(other)).misfit.total == pytest.approx(judge(problem_of(same)).misfit.total)


def test_stated_places_in_another_order_are_named_with_their_mend():
    one, two, three = honest().targets
    places = ((one, two.xyz), (two, three.xyz), (three, one.xyz))
    spoilt = replace(honest(), targets=tuple(replace(target, xyz=xyz) for target, xyz in places))
    (said,) = remarks(problem_of(spoilt))
    assert "targets T1, T2, T3 are stated for one another: mend xyz_mm" in said


def inaccurate(folder, seed):
    """A random arm, 2 mm and 2 mrad off everywhere, and the plan of a campaign with every column."""
    robot = load_robot(write_random_robot(folder, seed, ("6R", "7R", "PRRR")[seed % 3]))
    rng = np.random.default_rng(seed)
    q = np.tile(random_poses(robot, 20, rng), (2, 1))
    plan = planned(
        robot,
        q,
        targets=TARGETS[: 1 + 2 * (seed % 2)],
        payloads={"heavy": (100.0, (0.05, 0.0, 0.15))},
        payload=[""] * 20 + ["heavy"] * 20,
        direction=rng.choice([-1.0, 1.0], q.shape),
        time=np.linspace(0, 7200, 40),
        temperature=np.linspace(20, 40, 40),
    )
    return plan, problem_of(plan), rng


@pytest.mark.parametrize("seed", range(4))
def test_an_inaccurate_robot_is_no_mistake(tmp_path, seed):
    plan, job, rng = inaccurate(tmp_path, seed)
    truth = Truth(geometry=random_geometry(job.arm, rng, 2e-3, 2e-3), sigma=1e-4)
    found = judge(problem_of(simulate(plan, truth, seed=seed)))
    assert not found.refused
    assert found.misfit.total < 0.01


def test_zeros_and_lengths_off_everywhere_are_fitted_and_told():
    """Every joint some degrees and every length some millimetres off: 18 mm, 4 % of the spread."""
    plan, rng = honest("ur5"), np.random.default_rng(5)
    geometry = random_geometry(problem_of(plan).arm, rng, 4e-3, 3e-2)
    rough = problem_of(simulate(plan, Truth(geometry=geometry, sigma=3e-5), seed=5))
    assert judge(rough).misfit.middle > 0.02
    (said,) = remarks(rough)
    assert said.startswith("The geometry is up to")
    assert "Targets are found" not in said
    elsewhere = [replace(one, xyz=tuple(np.add(one.xyz, [0.0, 0.0, 0.08]))) for one in rough.campaign.targets]
    (said,) = remarks(replace(rough, campaign=replace(rough.campaign, targets=tuple(elsewhere))))
    assert said.startswith("The geometry is up to")
    assert re.search(r"Targets are found up to (7|8)\d mm from where they are stated", said)


def alarms(folder, seed, cause):
    """Whether a robot that has the cause in ten times its usual size, at a random place, is refused."""
    plan, job, rng = inaccurate(folder, seed)
    places = [] if catalogue()[cause].needs(job) else catalogue()[cause].places(job)
    known = [place for place in places if not place.ordered or place.where.order is not None]
    if not known:
        return None
    effect = known[rng.integers(len(known))]
    values = np.array([10 * p.typical * rng.choice([-1, 1]) for p in effect.params])
    values = np.clip(values, [p.lower for p in effect.params], [p.upper for p in effect.params])
    truth = Truth(geometry=random_geometry(job.arm, rng), effects=((effect, values),), sigma=3e-5)
    return judge(problem_of(simulate(plan, truth, seed=seed))).refused


def test_no_cause_however_strong_is_a_mistake(tmp_path):
    found = [alarms(tmp_path, seed, cause) for seed, cause in enumerate(catalogue())]
    assert found.count(False) > 10
    assert not any(found)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(40))
def test_no_cause_however_strong_is_a_mistake_on_any_robot(tmp_path, seed):
    assert not any(alarms(tmp_path, seed, cause) for cause in catalogue())


def test_the_command_line_refuses_and_writes_nothing(tmp_path, capsys):
    path = str(write_campaign(tmp_path / "c", flip(2)(honest())))
    out = tmp_path / "out"
    assert main(["diagnose", path, "--out", str(out)]) == 2
    assert "turn the sign of q3" in capsys.readouterr().err
    assert not out.exists()
    assert main(["plan", path, "--quick", "--out", str(tmp_path / "p.csv")]) == 2
    assert "turn the sign of q3" in capsys.readouterr().err


def test_strong_faults_that_bend_the_geometry_are_not_another_robot(tmp_path, monkeypatch):
    """A compensator far off, believed to the noise, bends it by decimetres along what hardly shows where what
    no point shows is not held."""
    free = []
    monkeypatch.setattr(parameters, "LEVER_PRIOR", parameters.GEOMETRY_PRIOR)
    monkeypatch.setattr(
        preparation, "plausible_geometry", lambda fit: free.append(fit) or plausible_geometry(fit)
    )
    held = preparation.prepare(draw_case("pair/11", 8, tmp_path).campaign).geometry

    def farthest(fit):
        return np.abs(fit.state.geometry - fit.model.problem.arm.geometry)[:, :3].max()

    assert farthest(free[0]) > 0.3
    assert farthest(held) < 0.03
    assert held.noise is free[0].noise


def shown(*spoilt):
    """Columns as another counting shows them: each of `spoilt` is a joint, its sign, its zero [deg] and what
    else it counts."""

    def change(q):
        true = q.copy()
        for j, sign, zero, *other in spoilt:
            q[:, j] = sign * true[:, j] + np.radians(zero)
            for i, factor in other:
                q[:, j] += factor * true[:, i]

    return lambda c: joints(c, change)


COUNTED = {
    "two signs": ("irb120", shown((3, -1, 0), (5, -1, 0)), ["joint_4 is -q4", "joint_6 is -q6"]),
    "three signs": ("kr120", shown((0, -1, 0), (3, -1, 0), (5, -1, 0)), ["joint_1 is -q1", "joint_4 is -q4"]),
    "sign and zero": ("ur5", shown((1, -1, 90)), ["shoulder_lift_joint is 90° - q2"]),
    "like KUKA": (
        "irb120",
        shown((0, -1, 0), (1, 1, -90), (2, 1, 90), (3, -1, 0), (5, -1, 0)),
        ["joint_1 is -q1, joint_2 is q2 + 90°, joint_3 is q3 - 90°, joint_4 is -q4, joint_6 is -q6",
         "signs = [-1, 1, 1, -1, 1, -1], zeros = [0, -90, 90, 0, 0, 0]"],
    ),
    "like FANUC": (
        "irb120",
        shown((2, -1, 0, (1, -1))),
        ["joint_3 is -q3 - q2", 'couplings = [{joint = "J3", on = "J2", factor = -1}]'],
    ),
    "as its controller does": (
        "kr500", shown((0, -1, 0), (3, -1, 0), (5, -1, 0)), ['say joints = "controller" under']
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow) if " sign" in case else case for case in COUNTED]
)
def test_joints_counted_otherwise_in_several_ways_at_once(case):
    name, spoil, told = COUNTED[case]
    with pytest.raises(InputError) as caught:
        believed(problem_of(spoil(honest(name))))
    (fault,) = caught.value.faults
    assert all(part in str(fault) for part in told)


def test_a_mend_that_stays_within_the_limits_comes_first():
    """On this robot q2 + 180° explains the sign of q1 as well, and cannot be."""
    with pytest.raises(InputError) as caught:
        believed(problem_of(flip(0)(honest("irb120"))))
    assert "turn the sign of q1" in str(caught.value)
    assert "180°" not in str(caught.value)


def test_a_check_refuses_what_a_diagnosis_refuses():
    wrong = honest().with_known(["no nonsense_cause", "nonsense_fact:joint=joint_1,ratio=100,std=1"])
    said = [str(fault) for fault in first_look(wrong).wrong]
    assert any("no cause 'nonsense_cause'" in fault for fault in said)
    assert any("no cause 'nonsense_fact'" in fault for fault in said)


def test_a_check_does_not_promise_that_calibration_mends_another_robot():
    checked = check_campaign(first_look(flip(2)(honest())))
    assert "not of this robot in these poses" in checked.headline
    assert "no calibration mends that" in checked.text
    right = check_campaign(first_look(honest()))
    assert "0 suspicious" in right.headline
    assert "calibration takes most of that" in right.text


def test_a_check_says_of_a_target_that_is_none_in_one_line():
    """Rotations that were read as places, as of a table with both."""

    def spoilt(places):
        no_places(places)[5, 2] += 2.0
        return places

    checked = check_campaign(first_look(points(honest(), spoilt)))
    (said,) = (lines for title, lines in checked.sections.items() if title.startswith("Suspicious"))
    assert len(said) == 2
    assert said[0].startswith("T2: 40 of its 40 points")
    assert "T3" in said[1]
    assert len(checked.facts["suspicious"]) == 41
    one = check_campaign(first_look(points(honest(), no_places)))
    assert "calibration takes most of that but for the suspicious ones" in one.text


def test_targets_on_the_base_make_none_on_the_arm_suspicious():
    """They err by the noise alone, whatever the robot does."""
    seen = honest()
    still = np.broadcast_to([[1.0, 2.0, 0.1], [1.5, 2.0, 0.2]], (*seen.points.shape[:1], 2, 3))
    rng = np.random.default_rng(2)
    beside = replace(
        seen,
        targets=(*seen.targets, Target("B1", on="base"), Target("B2", on="base")),
        points=np.concatenate([seen.points, still + 3e-5 * rng.standard_normal(still.shape)], axis=1),
        shots=np.concatenate([seen.shots, np.ones((len(seen.shots), 2), dtype=np.int64)], axis=1),
    )
    checked, alone = check_campaign(first_look(beside)), check_campaign(first_look(seen))
    assert "0 suspicious" in checked.headline
    assert checked.facts["median_mm"] == pytest.approx(alone.facts["median_mm"], rel=0.05)


def no_places(places):
    places[:, 1] = np.random.default_rng(1).uniform(-0.18, 0.18, (len(places), 3))
    return places


def another_frame(places):
    places[:, 1] = places[:, 1][:, [1, 2, 0]]
    return places


def on_a_pillar(places):
    places[:, 1] = np.random.default_rng(2).normal((1.5, 0.3, 0.2), 3e-5, (len(places), 3))
    places[3, 1] = np.nan
    return places


def knocked(places):
    places[20:, 1] += 0.1
    return places


def test_of_two_targets_one_that_is_none_is_refused():
    """No majority of the points tells which are wild: a fit of all would explain nothing."""
    with pytest.raises(InputError) as caught:
        believed(problem_of(points(honest(count=2), no_places)))
    assert "the points of T2 do not fit the robot that the others fit" in str(caught.value)
    with pytest.raises(InputError) as caught:
        believed(problem_of(points(honest(count=2), another_frame)))
    assert "the points of T1 and T2 fit the robot, but not together" in str(caught.value)
    believed(problem_of(points(honest(count=2), knocked)))


@pytest.mark.parametrize("count", [2, 3])
def test_a_target_that_stands_still_is_told_as_that(count):
    """The advice to leave it out lost what such a target tells of the base."""
    standing = points(honest(count=count), on_a_pillar)
    if count == 2:
        with pytest.raises(InputError) as caught:
            believed(problem_of(standing))
        told = str(caught.value)
    else:
        told = check_campaign(first_look(standing)).text
    assert "still while the arm moves" in told
    assert 'say on = "base" under [targets.T2]' in told


def test_the_command_line_warns_of_a_zero_that_is_off(tmp_path, capsys):
    path = str(write_campaign(tmp_path / "c", turn(2, 3.0)(honest("ur5"))))
    assert main(["diagnose", path, "--json"]) == 0
    err = capsys.readouterr().err
    assert "warning: elbow_joint stands -3.09° from where its numbers say" in err


@pytest.mark.parametrize("degrees", [3.0, pytest.param(-4.0, marks=pytest.mark.slow)])
def test_a_joint_with_its_zero_some_degrees_off_is_fitted_and_told(degrees):
    campaign = turn(2, degrees)(honest("ur5"))
    (said,) = remarks(problem_of(campaign))
    assert "elbow_joint stands" in said
    assert abs(judge(problem_of(campaign)).zero[1] + np.radians(degrees)) < np.radians(0.2)


def test_a_load_that_outweighs_the_arm_is_doubted():
    light = honest()
    assert not any("kilograms" in said for said in remarks(problem_of(light)))
    (said,) = [s for s in remarks(problem_of(replace(light, tool_mass=4500.0))) if "kilograms" in s]
    assert said.startswith("Tool and payload weigh 4500 kg")
