"""A study's campaigns for others to diagnose blind: a zip with the data in the open and the truth apart."""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from pathlib import Path

from ..campaign import load_campaign
from ..files.faults import Fault, InputError
from ..files.whole import put
from ..report.study_page import TRUTH

SEALED = "truth.zip"
TOLD = (TRUTH, "result.json", "index.html", "report.pdf", "model.toml")  # what says or shows what was hidden
MOMENT = (1980, 1, 1, 0, 0, 0)  # of all files: the same study, the same bytes

README = """# {title}

Simulated measurements of a published study, to be diagnosed without knowing what was hidden in them.

{campaigns}

Each folder has `campaign.toml`, `poses.csv` and `points.csv`; every column says its unit. The robot as the
measurements' owner knows it lies in `robots/`: a URDF, and a TOML with what a URDF cannot say.

    workbench diagnose CAMPAIGN/campaign.toml --out my-diagnosis

or any program of your own. Write down what is wrong with each robot, how large, and how sure you are. Only
then open `{sealed}`: `truth.json` says what was hidden, `index.html` what the study says of it.

SHA-256 of `{sealed}`: {digest}
"""


def archive(folder: Path, out: Path) -> Path:
    """Writes the zip of a study that was run into `folder`; its path.

    Raises InputError where no study was run there, or where it hides nothing in its campaigns.
    """
    try:
        sealed = json.loads((folder / TRUTH).read_text(encoding="utf-8"))["campaigns"]
        result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        missing = Path(error.filename).name
        raise InputError(
            Fault(str(folder), f"has no {missing}", "run `workbench study NAME` first")
        ) from None
    inner = _zip({name: (folder / name).read_bytes() for name in TOLD if (folder / name).is_file()})
    files: dict[str, bytes] = {SEALED: inner}
    for link in sealed:
        files |= _campaign(folder / link)
    readme = README.format(
        title=f"Study {result['study']}, robot {result['robot']}",
        campaigns="\n".join(f"- `{Path(link).parent.name}/`" for link in sealed),
        sealed=SEALED,
        digest=hashlib.sha256(inner).hexdigest(),
    )
    put(out, _zip({"README.md": readme.encode(), **files}))
    return out


def _campaign(path: Path) -> dict[str, bytes]:
    """A campaign's files and its robot's, by their places in the archive."""
    robot, name = load_campaign(path).robot, path.parent.name
    stated = (robot.path or robot.urdf.with_suffix(".toml")).resolve()
    place = f"robots/{stated.parent.name}"
    return {
        **{f"{name}/{table}": (path.parent / table).read_bytes() for table in ("poses.csv", "points.csv")},
        f"{name}/campaign.toml": _pointing(path, "robot", f"../{place}/{stated.name}"),
        f"{place}/{stated.name}": _pointing(stated, "urdf", robot.urdf.name),
        f"{place}/{robot.urdf.name}": robot.urdf.read_bytes(),
    }


def _pointing(path: Path, key: str, place: str) -> bytes:
    """A TOML file whose `key` is another path."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return "\n".join(
        [f'{key} = "{place}"' if line.split("=")[0].strip() == key else line for line in lines]
    ).encode()


def _zip(files: dict[str, bytes]) -> bytes:
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in files.items():
            packed.writestr(zipfile.ZipInfo(name, MOMENT), data, zipfile.ZIP_DEFLATED)
    return made.getvalue()
