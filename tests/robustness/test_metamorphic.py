"""The same measurement told otherwise gives the same diagnosis."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).parents[1]))

from diagnosis_cases import found, measured, named, with_points

from workbench.campaign import Campaign, join, load_campaign, write_campaign
from workbench.diagnosis.result import Diagnosis
from workbench.robot.description import load_robot
from workbench.robot.rotations import rotation_about

DATA = Path(__file__).parents[2].parent / "shared" / "data"
MEASURED = ("iiwa7-torque", "iiwa7-payload0", "irb120-faro", "ma1400-left", "ur5-tracker")
POSE = 7
EXACT = 1e-6  # relative: the same numbers, but for rounding
SPREAD = 1e-6  # of a standard deviation: a value that is hardly there has no digits of its own
OUTLIER = 0.1  # one pose less

Change = Callable[[Campaign, Path], Campaign]


def permuted(c: Campaign, _: Path) -> Campaign:
    return c.some(np.random.default_rng(3).permutation(len(c.poses.q)))


def other_frame(c: Campaign, _: Path) -> Campaign:
    R = rotation_about("z", 1.1) @ rotation_about("x", 0.4)
    return with_points(c, c.points @ R.T + [3.0, -2.0, 0.7])


def turned_instrument(c: Campaign, _: Path) -> Campaign:
    """About its own vertical: with another one the bearing from the instrument is another function."""
    return with_points(c, c.points @ rotation_about("z", 1.1).T)


def other_names(c: Campaign, _: Path) -> Campaign:
    ids = tuple(f"pose {len(c.poses.ids) - i}" for i in range(len(c.poses.ids)))
    targets = tuple(replace(target, name=f"SMR {9 - i}") for i, target in enumerate(c.targets))
    return replace(c.with_poses(ids=ids), targets=targets, title="another name")


def other_units(c: Campaign, folder: Path) -> Campaign:
    """Through files: radians and metres, with all digits."""
    path = write_campaign(folder, c)
    scale = {"deg": ("rad", np.pi / 180), "mm": ("m", 1e-3)}
    for name in ("poses.csv", "points.csv"):
        header, *rows = [line.split(",") for line in (folder / name).read_text().splitlines()]
        for i, column in enumerate(header):
            stem, _, unit = column.rpartition("_")
            if unit in scale:
                header[i] = f"{stem}_{scale[unit][0]}"
                for row in rows:
                    row[i] = repr(float(row[i]) * scale[unit][1])
        (folder / name).write_text("\n".join(",".join(row) for row in [header, *rows]) + "\n")
    return load_campaign(path)


def written_twice(c: Campaign, _: Path) -> Campaign:
    """Every row a second time, under another id."""
    n = len(c.poses.q)
    ids = tuple([*c.poses.ids, *(f"again {i}" for i in range(n))])
    return c.some(np.tile(np.arange(n), 2)).with_poses(ids=ids)


def an_outlier(c: Campaign, _: Path) -> Campaign:
    points = c.points.copy()
    seen = np.flatnonzero(np.isfinite(points[:, 0]).all(axis=1))
    points[seen[POSE], 0] += [0.0, 300.0, 0.0]
    return with_points(c, points)


def split_and_joined(c: Campaign, _: Path) -> Campaign:
    half = np.arange(len(c.poses.q)) % 2 == 0
    return join(
        [
            replace(c.some(np.flatnonzero(half)), title="even", path=Path("even/campaign.toml")),
            replace(c.some(np.flatnonzero(~half)), title="odd", path=Path("odd/campaign.toml")),
        ]
    )


@cache
def simulated() -> Campaign:
    hidden = ("gear_eccentricity:joint=joint_1,variant=1,amplitude=4e-4,phase=0.4",)
    return measured("cylindrical", hidden, poses=40, loads=())


@cache
def bent() -> Campaign:
    """A set of numbers that hardly shows, and is not straight: parallel axes, with much left by geometry."""
    hidden = ("gear_eccentricity:joint=joint_2,variant=1,amplitude=4e-4,phase=0.4",
              "joint_compliance:joint=joint_3,relative=0.3")  # fmt: skip
    return measured("kr500", hidden, poses=40)


@cache
def diagnosed(name: str) -> Diagnosis:
    return found(campaign_of(name))


def campaign_of(name: str) -> Campaign:
    made = {"simulated": simulated, "in a bent valley": bent}
    return made[name]() if name in made else load_campaign(DATA / name / "campaign.toml")


def same(after: Diagnosis, before: Diagnosis) -> None:
    """Causes with their places, status, gain and probability, their parameters, and all stages."""
    assert named(after) == named(before)
    assert after.verdict == before.verdict
    ours, theirs = ([(f.cause, str(f.where), f.parameters) for f in d.causes] for d in (after, before))
    for (*key, here), (*other, there) in zip(sorted(ours, key=str), sorted(theirs, key=str), strict=True):
        assert key == other
        for one, two in zip(here, there, strict=True):
            assert one.value == pytest.approx(two.value, rel=EXACT, abs=SPREAD * two.std)
    for one, two in zip(after.causes, before.causes, strict=True):
        assert one.probability == pytest.approx(two.probability, abs=EXACT)
        # a gain is a difference of two errors, and as exact as these are
        assert one.gain_mm == pytest.approx(
            two.gain_mm, rel=EXACT, abs=EXACT * before.stages[1].heldout_rms_mm
        )
    for one, two in zip(after.stages, before.stages, strict=True):
        assert one.fit_rms_mm == pytest.approx(two.fit_rms_mm, rel=EXACT)
        assert one.heldout_rms_mm == pytest.approx(two.heldout_rms_mm, rel=EXACT)


def test_the_simulated_campaign_shows_its_cause() -> None:
    assert set(named(diagnosed("simulated"))) == {("gear_eccentricity", "joint_1")}


@pytest.mark.parametrize(
    "change", [permuted, other_frame, other_names, other_units, written_twice], ids=lambda f: f.__name__
)
@pytest.mark.parametrize("name", ["simulated", pytest.param("in a bent valley", marks=pytest.mark.slow)])
def test_told_otherwise_it_is_the_same(tmp_path: Path, change: Change, name: str) -> None:
    same(found(change(campaign_of(name), tmp_path)), diagnosed(name))


def test_axes_counted_the_other_way(tmp_path: Path) -> None:
    """Which poses are held out together follows from their numbers: what is fitted is the same."""
    c, before = simulated(), diagnosed("simulated")
    folder = Path(shutil.copytree(c.robot.urdf.parent, tmp_path / "model"))
    turning, along = (folder / c.robot.urdf.name).read_text().split('<joint name="joint_3"')
    turning = turning.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 0 -1"/>', 1)
    along = along.replace('<axis xyz="1 0 0"/>', '<axis xyz="-1 0 0"/>', 1)
    along = along.replace('lower="0" upper="0.5"', 'lower="-0.5" upper="0"', 1)
    (folder / c.robot.urdf.name).write_text(f'{turning}<joint name="joint_3"{along}')
    way, side = np.array([-1.0, 1.0, -1.0]), c.poses.side
    assert side is not None
    other = replace(c, robot=load_robot(folder / "cylindrical.toml"))
    after = found(other.with_poses(q=c.poses.q * way, side=side * way))
    assert named(after) == named(before)
    assert after.verdict == before.verdict
    for one, two in zip(after.causes, before.causes, strict=True):
        assert one.probability == pytest.approx(two.probability, abs=EXACT)
    for one, two in zip(after.stages, before.stages, strict=True):
        assert one.fit_rms_mm == pytest.approx(two.fit_rms_mm, rel=EXACT)


@pytest.mark.parametrize("change", [an_outlier, split_and_joined])
def test_one_outlier_or_two_files_change_no_cause(tmp_path: Path, change: Change) -> None:
    after, before = found(change(simulated(), tmp_path)), diagnosed("simulated")
    assert named(after) == named(before)
    assert after.verdict == before.verdict
    assert len(after.faults) == (change is an_outlier)
    assert after.stages[-1].fit_rms_mm == pytest.approx(before.stages[-1].fit_rms_mm, rel=OUTLIER)


@pytest.mark.slow
@pytest.mark.skipif(not DATA.is_dir(), reason=f"no measured data at {DATA.parent.name}/{DATA.name}")
@pytest.mark.parametrize("name", MEASURED)
@pytest.mark.parametrize(
    "change", [turned_instrument, other_names, written_twice, an_outlier]
)  # rows are in order of time
def test_measured_campaigns_told_otherwise(tmp_path: Path, name: str, change: Change) -> None:
    after, before = found(change(campaign_of(name), tmp_path)), diagnosed(name)
    if change is an_outlier:
        assert named(after) == named(before)
        assert after.verdict == before.verdict
    else:
        same(after, before)
