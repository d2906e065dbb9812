"""xacro expanded to a URDF, by xacrodoc where it is installed: it needs no ROS."""

from __future__ import annotations

import glob
import importlib.util
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import escape

from ..files.faults import Fault, InputError, read_text
from .meshes import HOW
from .packages import Given, package_folder
from .urdf import XACRO, xml_root

COMMENT = re.compile("<!--.*?-->", re.DOTALL)
ASKED = re.compile(r"Undefined substitution argument ([\w.-]+)")
LACKING = re.compile(r"Package not found: ([\w.-]+)")


def is_xacro(path: Path) -> bool:
    """By its name, or by its elements: many a file that is called .urdf is xacro."""
    return path.suffix == ".xacro" or f"<{XACRO}" in COMMENT.sub("", read_text(path))


def expanded(path: Path, arguments: Mapping[str, str], given: Given | None = None) -> str:
    """The URDF that a xacro file makes with these arguments. Raises `InputError`."""
    xml_root(read_text(path), path)  # says where it is none: xacro does not
    if importlib.util.find_spec("xacrodoc") is None:
        raise InputError(Fault(str(path), "is xacro", f"{HOW}, or in ROS: xacro {path} > robot.urdf"))
    import xacrodoc
    from xacrodoc import packages

    packages.reset()
    found: set[str] = set()
    while True:
        try:
            # included where it is: names of files in it count from there, wherever one stands
            document = xacrodoc.XacroDoc.from_includes(
                [escape(glob.escape(path.resolve().as_posix()))],
                subargs=dict(arguments),
                resolve_packages=False,
            )
            text = str(document.to_urdf_string())
            break
        except Exception as error:  # xacro raises what it likes
            message = " ".join(str(error).split()) or type(error).__name__
            lacking = LACKING.search(message)
            if lacking is None:
                name = asked[1] if (asked := ASKED.search(message)) else "NAME"
                mend = f"arguments are given as {name}:=VALUE behind the file" + _own_arguments(path)
                raise InputError(Fault(str(path), f"xacro says: {message}", mend)) from None
            name = lacking[1]
            folder = package_folder(name, path.resolve().parent, given)
            if folder is None or name in found:
                mend = f"say --package {name}=DIR, or set ROS_PACKAGE_PATH"
                raise InputError(Fault(str(path), f"needs the package {name!r}", mend)) from None
            found.add(name)
            packages.update_package_cache({name: folder})
    if "<link" not in text:
        others = (other for other in sorted(path.parent.glob("*.xacro")) if other != path)
        callers = [other.name for other in others if path.name in read_text(other)]
        mend = f"name the file that calls its macros{': ' if callers else ''}{', '.join(callers)}"
        raise InputError(Fault(str(path), "makes no link by itself", mend))
    return text


def _own_arguments(path: Path) -> str:
    """Which arguments the file itself says that it takes."""
    try:
        found = [item.get("name", "") for item in ET.parse(path).iter() if item.tag.endswith("}arg")]
    except (ET.ParseError, OSError):
        return ""
    return f"; it takes {', '.join(found)}" if found else ""
