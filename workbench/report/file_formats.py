"""docs/files: a page and a JSON schema for each format, out of the models that read them.

`python -m workbench.report.file_formats` writes them.
"""

from __future__ import annotations

import ast
import inspect
import json
import re
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel

from ..campaign.exports import EXPORTS, PROGRAM_EXPORTS
from ..campaign.file import ANGLES, QUATERNION, CampaignFile, point_columns, pose_columns
from ..correction.path_table import path_columns
from ..files.tables import UNITS, Column
from ..files.whole import put_all
from ..robot.description import load_robot
from ..robot.schema import RobotFile

Part = dict[str, Any]
FOLDER = Path(__file__).resolve().parents[2] / "docs" / "files"
MADE = "<!-- written by `python -m workbench.report.file_formats` -->"
SCHEMA_LINE = "#:schema"  # what editors with Taplo or Even Better TOML read in the first line


def pages() -> dict[str, str]:
    """File name → text, for docs/files."""
    robot = load_robot("kr500")
    bare = CampaignFile.model_validate(
        {"schema": 1, "robot": "kr500", "poses": {"file": "poses.csv"}, "points": {"file": "points.csv"}}
    )
    poses, points, path = pose_columns(robot), point_columns(bare), path_columns(robot)
    return {
        "robot.md": _toml_page("A robot: `robot.toml` beside its URDF", _ROBOT, RobotFile, "robot"),
        "campaign.md": _toml_page("A campaign: `campaign.toml`", _CAMPAIGN, CampaignFile, "campaign")
        + _exports(),
        "poses.md": _table_page("What the controller was told: `poses.csv`", _POSES, poses),
        "points.md": _table_page("What the instrument saw: `points.csv`", _POINTS, points),
        "path.md": _table_page("A path: `path.csv`", _PATH, path),
        "robot.schema.json": _schema(RobotFile),
        "campaign.schema.json": _schema(CampaignFile),
    }


def _schema(model: type[BaseModel]) -> str:
    return json.dumps(_described(model), indent=1, ensure_ascii=False) + "\n"


def _described(model: type[BaseModel]) -> Part:
    """The JSON schema with what stands below each field. Pydantic reads that as well, but whenever a model is
    loaded, which takes long."""
    schema: Part = model.model_json_schema(by_alias=True)
    for one in set(_models(model)):
        fields = (schema if one is model else schema["$defs"][one.__name__])["properties"]
        words = _below(one)
        for name, field in one.model_fields.items():
            if name in words:
                key = field.alias or name
                fields[key] = dict(sorted((fields[key] | {"description": words[name]}).items()))
    return schema


def _models(model: Any) -> Iterator[type[BaseModel]]:
    """A model and those that its fields are made of."""
    if isinstance(model, type) and issubclass(model, BaseModel):
        yield model
        for field in model.model_fields.values():
            yield from _models(field.annotation)
    for part in get_args(model):
        yield from _models(part)


@cache
def _below(model: type[BaseModel]) -> dict[str, str]:
    """The texts below the fields of a model and of those that it extends."""
    found = dict[str, str]()
    for one in reversed(model.__mro__):
        if not issubclass(one, BaseModel) or one is BaseModel:
            continue
        body = ast.parse(inspect.getsource(one)).body[0]
        assert isinstance(body, ast.ClassDef)
        for field, text in pairwise(body.body):
            if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr):
                assert isinstance(field.target, ast.Name)
                assert isinstance(text.value, ast.Constant)
                found[field.target.id] = inspect.cleandoc(str(text.value.value))
    return found


def _toml_page(title: str, words: str, model: type[BaseModel], name: str) -> str:
    schema = _described(model)
    lines = [f"# {title}", "", MADE, "", words.strip(), ""]
    lines += [f"Editors check it with `{SCHEMA_LINE} {name}.schema.json` in the first line.", ""]
    for heading, part in _tables(schema, schema, ""):
        lines += [f"## {heading or 'At the top'}", ""]
        if heading and part.get("description"):
            lines += [str(part["description"]).strip(), ""]
        lines += ["| key | kind | default | meaning |", "|---|---|---|---|"]
        required = part.get("required", [])
        for key, value in part.get("properties", {}).items():
            default = "needed" if key in required else _default(value)
            lines.append(
                f"| `{key}` | {_kind(value, schema)} | {default} | {_cell(value.get('description', ''))} |"
            )
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def _tables(part: Part, schema: Part, heading: str) -> Iterator[tuple[str, Part]]:
    """The tables of a TOML in the order of its keys, with the heading that each has there."""
    yield heading, part
    for key, value in part.get("properties", {}).items():
        place = f"{heading.strip('[]`')}.{key}".strip(".")
        for one in (value, *value.get("anyOf", ())):
            inner, shape = one, f"[{place}]"
            if one.get("type") == "array":
                inner, shape = one.get("items", {}), f"[[{place}]]"
            elif isinstance(one.get("additionalProperties"), dict):
                inner, shape = one["additionalProperties"], f"[{place}.NAME]"
            if "$ref" in inner:
                yield from _tables(_ref(inner, schema), schema, f"`{shape}`")


def _ref(value: Part, schema: Part) -> Part:
    found: Part = schema["$defs"][value["$ref"].rpartition("/")[2]]
    return found


def _kind(value: Part, schema: Part) -> str:
    """What a value may be, in a word or two."""
    if "$ref" in value:
        return "table"
    if "anyOf" in value:
        kinds = dict.fromkeys(_kind(one, schema) for one in value["anyOf"] if one.get("type") != "null")
        return " or ".join(kinds)
    if "const" in value or "enum" in value:
        return ", ".join(f"`{json.dumps(one)}`" for one in value.get("enum", [value.get("const")]))
    kind = value.get("type", "any")
    if kind == "array":
        count = value.get("minItems")
        items = value.get("items") or (value.get("prefixItems") or [{}])[0]
        return "tables" if "$ref" in items else f"{count or 'list of'} {_kind(items, schema)}s"
    return {"object": "table", "string": "text", "boolean": "true or false"}.get(kind, str(kind))


def _default(value: Part) -> str:
    default = value.get("default")
    return "" if default is None or isinstance(default, dict | list) else f"`{json.dumps(default)}`"


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def _exports() -> str:
    lines = ["", "## Templates", "", "| `template` | stands for |", "|---|---|"]
    for name, keys in {**EXPORTS, **PROGRAM_EXPORTS}.items():
        said = "; ".join(f"{key} = {json.dumps(value)}" for key, value in keys.items())
        lines.append(f"| `{name}` | {_cell(said)} |")
    return "\n".join(lines) + "\n"


def _table_page(title: str, words: str, columns: Sequence[Column]) -> str:
    units = {
        dim: ", ".join(f"`{unit}`" for unit in UNITS if UNITS[unit].dimension == dim)
        for dim in _dimensions(columns)
    }
    lines = [f"# {title}", "", MADE, "", words.strip(), ""]
    lines += ["| column | | what |", "|---|---|---|"]
    for column in columns:
        stem, number = re.fullmatch(r"([a-z_]+?)(\d*)", column.name).groups()  # type: ignore[union-attr]
        if number in ("", "1"):
            need = "needed" if column.required else ""
            more = " ..." if number else ""
            lines.append(f"| `{_written(column)}`{more} | {need} | {_MEANINGS[stem]} |")
    lines += ["", "Units that a name may end in:", "", "| of a | units |", "|---|---|"]
    lines += [f"| {dimension} | {names} |" for dimension, names in units.items()]
    return "\n".join(lines) + "\n"


def _dimensions(columns: Sequence[Column]) -> list[str]:
    return list(dict.fromkeys(dimension for column in columns for dimension in column.dimensions))


def _written(column: Column) -> str:
    return column.usual.replace(" or ", "`, `")


_FORCE = "external force on the robot (what acts on it) at the flange's origin, in the base frame"
_TORQUE = "external torque, likewise; a force at another point makes one too: lever × force"
_SIGMA = "uncertainty of the point, one sigma"
_MEANINGS = {
    **dict(payload="what the arm carries, by its name under `[payloads]`; empty: nothing"),
    "pose_id": "name of the pose",
    "setup": "the instrument's stand: its frame and the targets are fitted anew for each",
    "t": "time from any beginning; `t_clock`: times of day, dated or not; of poses, or else of points",
    "temp": "temperature of the arm; 20 °C is nominal",
    **dict.fromkeys(("fx", "fy", "fz"), _FORCE),
    **dict.fromkeys(("mx", "my", "mz"), _TORQUE),
    "q": "commanded joint, from base to flange",
    "r": "read-back joint",
    "tau": "torque that the drive exerts on the joint, behind the gear (force of a sliding one): it holds up "
    "what the loads pull down, so its sign is opposite to theirs",
    "dir": "sign of the joint's last motion: -1, 1, or 0 where it is not known; without these columns it is "
    "taken from the order of poses that follow each other along a path",
    "target": "name of the target",
    **dict.fromkeys("xyz", "place"),
    **dict.fromkeys(("sx", "sy", "sz"), _SIGMA),
    **dict.fromkeys(QUATERNION, "orientation as a quaternion, qw its scalar"),
    **dict.fromkeys(ANGLES, "or as angles, or a rotation vector: `turns` in [campaign.toml](campaign.md)"),
    **dict.fromkeys("abc", "orientation as KUKA's A B C: Rz(A) Ry(B) Rx(C)"),
    "dwell": "rest at this sample; `t_s` counts it: the next row comes later by as much",
}

_ROBOT = """
The URDF says lengths, axes, limits, masses and looks; this file what URDF cannot say. `workbench init URDF`
writes one, `workbench check robot.toml` tests it. Numbers are in SI units. A `model.toml`, which a diagnosis
writes, is the same format with `[geometry]`, `[[effects]]` and the campaign's loads.
"""
_CAMPAIGN = """
Two tables, joined on `pose_id`, and what is known of the measurement. `workbench check campaign.toml` reads
it, tells every fault with its line, and shows the points beside the robot before anything is fitted.
"""
_POSES = """
A row per pose, here for a robot with six joints. Poses with equal joints,
payload, wrench and setup are repeats; on end, within two minutes, they are shots of one standstill: what the
arm is off by there is the same in all. Without `pose_id` the rows are numbered from 1. Columns of other
names are mapped in [campaign.toml](campaign.md).
"""
_POINTS = """
A row per shot of a target, in the instrument's frame. Several rows of one pose and target are shots of one
standstill; a row with x, y and z empty is a point that was not seen. With a single target its column may be
left out; without `pose_id` the points are joined to the poses in order, if there are as many. Targets side by
side are read with `wide`, a 6-D measurement with `turned_mm` in [campaign.toml](campaign.md).
"""
_PATH = """
A row per sample: time, and either joints, or tool poses in the base frame as quaternion `qw` ... or as KUKA's
A B C. From row to row the tool runs straight. A controller's program has a circular move where five rows or
more lie on a circle, no farther apart than 15°. Rows are corrected, what lies between them is not: where they
are far apart `compensate` says how much is left there.
"""


if __name__ == "__main__":
    put_all({FOLDER / name: text for name, text in pages().items()})
