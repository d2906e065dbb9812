"""Campaigns: what is written is loaded again."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from campaign_example import POINTS, TOML, write_example, write_robot
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.campaign import Campaign, Target, load_campaign, write_campaign
from workbench.campaign.poses import Poses
from workbench.files.faults import InputError
from workbench.robot.description import load_robot


def assert_same(one: Campaign, other: Campaign) -> None:
    """Equal but for the path, the hashes and the last digits."""
    for name in ("title", "payload_names", "setup_names", "six_dof"):
        assert getattr(one, name) == getattr(other, name), name
    assert one.poses.ids == other.poses.ids
    names = ("load_mass", "load_com", "tool_mass", "tool_com", "points", "shots", "sigma", "noise_sigma")
    pairs = {name: (getattr(one, name), getattr(other, name)) for name in names}
    columns = other.poses.columns()
    pairs |= {name: (mine, columns[name]) for name, mine in one.poses.columns().items() if name != "ids"}
    for name, (mine, theirs) in pairs.items():
        assert (mine is None) == (theirs is None), name
        if mine is not None:
            np.testing.assert_allclose(mine, theirs, rtol=1e-11, atol=1e-14, err_msg=name)
    for target, same in zip(one.targets, other.targets, strict=True):
        assert (target.name, target.on, target.fixed) == (same.name, same.on, same.fixed)
        np.testing.assert_allclose(target.xyz or 0, same.xyz or 0, rtol=1e-11)


NAMES = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Zl", "Zp")), min_size=1, max_size=6
).map(str.strip).filter(bool)  # fmt: skip
SIZES = st.floats(-1e3, 1e3, allow_subnormal=False)
TITLES = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc",), include_characters="\t\n"),
    min_size=1,
    max_size=8,
)


@st.composite
def campaigns(draw: st.DrawFn, robot_folder: Path) -> Campaign:
    """Any campaign of the tiny robot."""
    robot = load_robot(write_robot(robot_folder))
    names = draw(st.lists(NAMES, min_size=1, max_size=4, unique=True))
    n, n_targets, n_loads = len(names), draw(st.integers(1, 3)), draw(st.integers(1, 3))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    scale = draw(st.sampled_from([1e-3, 1.0, 3.3]))
    seen = rng.random((n, n_targets)) < 0.7
    seen[:, 0], seen[0, :] = True, True
    setups = list(dict.fromkeys(draw(st.lists(NAMES | st.just(""), min_size=n, max_size=n))))
    setup = np.minimum(np.arange(n), len(setups) - 1)

    def maybe(*shape: int) -> np.ndarray | None:
        return scale * rng.normal(size=shape) if draw(st.booleans()) else None

    targets = tuple(
        Target(name, None if draw(st.booleans()) else draw(st.tuples(SIZES, SIZES, SIZES)), on)
        for name, on in zip(
            draw(st.lists(NAMES, min_size=n_targets, max_size=n_targets, unique=True)),
            ["flange", "base", "link_2"],
            strict=False,
        )
    )
    loads = draw(st.lists(NAMES, min_size=n_loads, max_size=n_loads, unique=True))
    load_com = np.concatenate([np.zeros((1, 3)), rng.normal(size=(n_loads, 3))])
    sigma = rng.uniform(1e-5, 1e-3, (n, n_targets, 3)) if draw(st.booleans()) else None
    return Campaign(
        title=draw(TITLES),
        path=robot_folder / "campaign.toml",
        robot=robot,
        payload_names=("", *loads),
        load_mass=np.concatenate([[0.0], rng.uniform(0, 100, n_loads)]),
        load_com=load_com,
        tool_mass=draw(st.sampled_from([0.0, 12.5])),
        tool_com=np.zeros(3),
        setup_names=tuple(setups),
        targets=targets,
        points=np.where(seen[..., None], scale * rng.normal(size=(n, n_targets, 3)), np.nan),
        shots=seen.astype(np.int64),
        sigma=None if sigma is None else np.where(seen[..., None], sigma, np.nan),
        noise_sigma=draw(st.sampled_from([None, 3e-5])),
        six_dof=draw(st.booleans()) and len({target.on for target in targets}) == 1,
        poses=Poses(
            ids=tuple(names),
            q=scale * rng.normal(size=(n, 3)),
            payload=rng.integers(0, n_loads + 1, n),
            wrench=scale * rng.normal(size=(n, 6)),
            side=np.sign(rng.integers(-1, 2, (n, 3))).astype(float) if draw(st.booleans()) else None,
            time=maybe(n),
            temperature=maybe(n),
            torque=maybe(n, 3),
            readback=maybe(n, 3),
            setup=setup,
        ),
    )


@settings(max_examples=60, deadline=None)
@given(data=st.data())
def test_what_is_written_is_loaded(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    folder = tmp_path_factory.mktemp("round")
    campaign = data.draw(campaigns(folder))
    path = write_campaign(folder / "out", campaign, comments=["made up"])
    assert path.read_text(encoding="utf-8").startswith("# made up\nschema = 1\n")
    assert 'robot = "robot.toml"' in path.read_text(encoding="utf-8")
    assert_same(campaign, load_campaign(path))


def test_single_shots_are_written(tmp_path: Path) -> None:
    campaign = load_campaign(write_example(tmp_path))
    shots = np.repeat(campaign.points[:, :, None, :], 3, axis=2) + np.arange(3)[:, None] * 1e-5
    again = load_campaign(write_campaign(tmp_path / "out", campaign, shots=shots))
    assert again.shots.tolist() == (3 * campaign.shots).tolist()
    assert again.shot_scatter == (pytest.approx(4 * 3 * 2e-10), 4 * 3 * 2)


def test_a_mean_of_shots_keeps_its_sigma(tmp_path: Path) -> None:
    path = write_example(
        tmp_path, TOML + "[noise]\nsigma_mm = 0.1\n", points=POINTS + "a,T1,1000,2000,3000\n"
    )
    again = load_campaign(write_campaign(tmp_path / "out", load_campaign(path)))
    assert again.sigma is not None
    np.testing.assert_allclose(again.sigma[:2, 0, 0], [1e-4 / 2**0.5, 1e-4])


def test_robots_that_come_along_are_written_by_name(tmp_path: Path) -> None:
    try:
        robot = load_robot("ur5")
    except InputError:
        pytest.skip("no model ur5")
    campaign = load_campaign(write_example(tmp_path))
    path = write_campaign(tmp_path / "out", replace(campaign.with_poses(q=np.zeros((3, 6))), robot=robot))
    assert 'robot = "ur5"\n' in path.read_text()
    assert load_campaign(path).robot.name == "ur5"


def test_a_campaign_appears_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    campaign = load_campaign(write_example(tmp_path))
    folder = write_campaign(tmp_path / "out", campaign).parent
    before = {file: file.read_bytes() for file in folder.rglob("*.*")}
    real = os.replace

    def failing(source: Path, target: Path) -> None:
        if target.name == "campaign.toml":
            raise OSError(28, "No space left on device")
        real(source, target)

    monkeypatch.setattr(os, "replace", failing)
    with pytest.raises(OSError, match="No space left"):
        write_campaign(folder, campaign.with_poses(q=campaign.poses.q + 0.1))
    assert {file: file.read_bytes() for file in folder.rglob("*.*")} == before


@pytest.mark.parametrize("text", ['quoted "so"', "a\\b", "tab\t, line\n", "größer ∆"])
def test_any_text_is_legal_toml(tmp_path: Path, text: str) -> None:
    campaign = load_campaign(write_example(tmp_path))
    path = write_campaign(tmp_path / "out", replace(campaign, title=text), comments=["two\nlines"])
    assert load_campaign(path).title == text


def test_what_would_act_in_a_terminal_is_no_title(tmp_path: Path) -> None:
    campaign = load_campaign(write_example(tmp_path))
    path = write_campaign(tmp_path / "out", replace(campaign, title="bell\x07, delete\x7f"))
    with pytest.raises(InputError, match="control characters"):
        load_campaign(path)
