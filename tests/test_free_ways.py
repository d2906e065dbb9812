"""Ways between two looks, and reflectors inside of what stands there: against plain geometry."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy.optimize import linprog

from workbench import load_robot, planned, problem_of, random_poses
from workbench.campaign.cell import CellData, DrivingData, InstrumentData, ObstacleData
from workbench.measurement.driving.reach import Reach, reach
from workbench.measurement.driving.ways import Ways
from workbench.robot.kinematics import frames

PROBE = ObstacleData(name="probe", box_mm=(4, 4, 300), xyz_mm=(0, 0, 150), on="flange")


def reached(name: str, cell: CellData, places: np.ndarray | None = None) -> Reach:
    problem = problem_of(planned(load_robot(name), np.zeros((1, len(load_robot(name).joints)))))
    places = problem.stated_targets if places is None else places
    return reach(problem, places, cell, np.random.default_rng(0))


@pytest.mark.parametrize("degrees", [-21, -13, -4, 3, 11, 20])
def test_a_thin_probe_does_not_pass_through_a_thin_rod(degrees: float) -> None:
    place = 600 * np.cos(np.radians(degrees)), 600 * np.sin(np.radians(degrees)), 600
    rod = ObstacleData(name="rod", box_mm=(4, 4, 800), xyz_mm=place)
    cell = reached("irb120", CellData(obstacles=(PROBE, rod), driving=DrivingData(clearance_mm=2)))
    left, right = np.array([[0.5, 0, 0, 0, 0, 0], [-0.5, 0, 0, 0, 0, 0]])
    assert cell.collisions.free(np.array([left, right])).all()
    assert not cell.collisions.clear_way(left, right)
    beside = np.array([np.radians(degrees) + 0.03, 0, 0, 0, 0, 0])
    assert cell.collisions.clear_way(left, beside)


@pytest.mark.parametrize("name", ["irb120", "cylindrical"])
def test_no_two_bodies_move_farther_on_each_other_than_is_reckoned(name: str) -> None:
    cell = reached(name, CellData())
    arm, bodies = cell.arm, cell.collisions
    moving = [hull for hull in cell.hulls if hull.slot >= 0]
    for start, end in random_poses(cell.robot, 20, np.random.default_rng(2)).reshape(10, 2, arm.n):
        travel = bodies.travel(np.abs(end - start))
        where = frames(arm, np.array([start, end]))
        for one, other in combinations(moving, 2):
            R, p = where.R[one.slot], where.p[one.slot]
            corners = other.vertices @ np.swapaxes(where.R[other.slot], 1, 2) + where.p[other.slot][:, None]
            seen = (corners - p[:, None]) @ R
            farthest = np.linalg.norm(seen[1] - seen[0], axis=1).max()
            assert farthest <= travel[one.slot, other.slot] + 1e-9


def overlap(where, k: int, one, other) -> bool:
    """Whether two hulls share a point in the k-th pose: a point inside of all their planes."""
    planes = [(h.normals @ where.R[h.slot][k].T, h.offsets, where.p[h.slot][k]) for h in (one, other)]
    A = np.concatenate([normals for normals, _, _ in planes])
    b = np.concatenate([offsets + normals @ place for normals, offsets, place in planes])
    return linprog(np.zeros(3), A_ub=A, b_ub=b - 1e-4, bounds=(None, None)).status == 0


def test_bodies_that_are_built_near_each_other_may_not_run_into_each_other() -> None:
    """Links 5 and 7 of an iiwa are 6 mm apart in its zero pose: nearer than the clearance, and no contact."""
    cell = reached("iiwa7", CellData())
    assert cell.collisions.ignored == ()
    q = np.zeros((60, 7))
    q[:, 3], q[:, 5] = -1.2, np.linspace(-2.0, 2.0, len(q))
    where = frames(cell.arm, q)
    (one,), (other,) = ([h for h in cell.hulls if h.slot == slot] for slot in (5, 7))
    inside = np.array([overlap(where, k, one, other) for k in range(len(q))])
    assert 0 < inside.sum() < len(q)
    assert not cell.collisions.free(q[inside]).any()


def test_a_reflector_inside_of_another_body_is_not_seen() -> None:
    """One reflector at the flange: inside of a block that stands there, or of the robot's own base."""
    block = ObstacleData(name="block", box_mm=(300, 300, 60), xyz_mm=(374, 0, 700))
    cell = reached("irb120", CellData(instrument=InstrumentData(xyz_mm=(3000, 0, 640)), obstacles=(block,)))
    assert cell.sight is not None
    home = np.zeros((1, 6))
    flange = frames(cell.arm, home).p[-1, 0]
    for inside, hidden in [((0.374, 0, 0.7), True), ((0.05, 0, 0.05), True), (flange, False)]:
        sight = cell.sight.of(cell.names[:1])
        place = frames(cell.arm, home).R[-1, 0].T @ (np.array(inside) - flange)
        sight.places[:] = place
        assert sight.lines(home)[0, 0] != hidden


def test_reflectors_do_not_run_into_the_arm() -> None:
    """One 0.2 m beside the flange, and none: where its middle is inside of a link behind the wrist."""
    none = np.full((3, 3), np.nan)
    beside = np.vstack([[-0.2, 0.0, -0.1], none[1:]])
    cell, bare = (reached("irb120", CellData(), places) for places in (beside, none))
    assert (cell.reflectors, bare.reflectors) == (("T1",), ())
    q = random_poses(cell.robot, 6000, np.random.default_rng(5))
    where = frames(cell.arm, q)
    point, hit = where.points(beside[:1], cell.on[:1])[:, 0], np.zeros(len(q), dtype=bool)
    for hull in (hull for hull in cell.hulls if 0 <= hull.slot <= 4):
        local = np.einsum("nji,nj->ni", where.R[hull.slot], point - where.p[hull.slot])
        hit |= (local @ hull.normals.T < hull.offsets).all(axis=1)
    hit[hit] = bare.collisions.free(q[hit])
    assert hit.sum() > 20
    assert not cell.collisions.free(q[hit]).any()


@pytest.fixture(scope="module")
def fenced() -> Reach:
    """A thin probe among thin rods all around."""
    around = [np.array([np.cos(a), np.sin(a)]) for a in np.linspace(0, 2 * np.pi, 24, endpoint=False)]
    rods = [ObstacleData(name="rod", box_mm=(4, 4, 1500), xyz_mm=(550 * x, 550 * y, 750)) for x, y in around]
    cell = reached("irb120", CellData(obstacles=(PROBE, *rods), driving=DrivingData(clearance_mm=2)))
    return replace(cell, closely=True)


def test_the_map_and_what_hangs_on_it_are_looked_at_closely(fenced: Reach) -> None:
    known = np.argwhere(np.triu(np.isfinite(fenced.map.ways), 1))
    nodes, clear = fenced.map.nodes, fenced.collisions.clear_way
    assert all(clear(nodes[a], nodes[b]) for a, b in known[::16])
    for q in fenced.draw(12, np.random.default_rng(4)):
        assert any(clear(q, node) for node in nodes)


def test_a_pose_is_reached_over_itself_where_nothing_leads_to_its_approach(monkeypatch) -> None:
    ways = Ways(reached("cylindrical", CellData()))
    start, approach, end = np.array([[0.0, 0.1, 0.1], [1.0, 0.2, 0.2], [1.1, 0.3, 0.3]])
    shut = approach.tobytes()
    monkeypatch.setattr(Ways, "round", lambda self, a, b: None if b.tobytes() == shut else [end])
    monkeypatch.setattr(Ways, "clear", lambda self, a, b: b.tobytes() != shut or a.tobytes() == end.tobytes())
    (over,) = ways.to(start, approach, end)
    np.testing.assert_array_equal(over, end)
