"""`init --poses` with a table that names payloads: the campaign declares them, and says what it lacks."""

from campaign_example import POINTS, POSES, write_robot

from workbench.campaign import load_campaign
from workbench.cli.main import main

CARRYING = "\n".join(
    line + end
    for line, end in zip(POSES.splitlines(), (",payload", ",heavy", ",", ",light one"), strict=True)
)


def made(tmp_path, capsys, poses):
    """The folder that init makes of a table of poses, and what it says on standard error."""
    urdf = write_robot(tmp_path).with_suffix(".urdf")
    (tmp_path / "told.csv").write_text(poses + "\n")
    (tmp_path / "seen.csv").write_text(POINTS)
    tables = "--poses", str(tmp_path / "told.csv"), "--points", str(tmp_path / "seen.csv")
    status = main(["init", str(urdf), *tables, "--out", str(tmp_path / "made")])
    assert status == 0
    return tmp_path / "made", capsys.readouterr().err


def test_payloads_of_the_poses_are_declared_as_unknown(tmp_path, capsys):
    folder, err = made(tmp_path, capsys, CARRYING)
    assert "NOT FOUND: what heavy, light one weigh: 0 kg until you say it here" in err
    campaign = load_campaign(folder)
    assert campaign.payload_names == ("", "heavy", "light one")
    assert campaign.load_mass.tolist() == [0.0, 0.0, 0.0]
    text = (folder / "campaign.toml").read_text()
    assert text.count("# TODO") == 4
    assert '[payloads."light one"]' in text


def test_without_payloads_the_template_shows_one(tmp_path, capsys):
    folder, err = made(tmp_path, capsys, POSES)
    assert "NOT FOUND: what" not in err
    text = (folder / "campaign.toml").read_text()
    assert "# [payloads.heavy]" in text
    assert "TODO" not in text
    assert load_campaign(folder).payload_names == ("",)
