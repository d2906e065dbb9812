"""xacro expanded to a URDF, by xacrodoc where it is installed: it needs no ROS."""

from __future__ import annotations

import glob
import importlib.util
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import escape

from ..files.faults import Fault, InputError
from .meshes import HOW
from .packages import Given, finder
from .urdf import XACRO, read_xml, xml_root

COMMENT = re.compile("<!--.*?-->", re.DOTALL)
ASKED = re.compile(r"Undefined substitution argument ([\w.-]+)")
LACKING = re.compile(r"Package not found: ([\w.-]+)")


def is_xacro(path: Path, text: str) -> bool:
    """By its name, or by its elements: many a file that is called .urdf is xacro."""
    return path.suffix == ".xacro" or f"<{XACRO}" in COMMENT.sub("", text)


def expanded(path: Path, text: str, arguments: Mapping[str, str], given: Given | None = None) -> str:
    """The URDF that a xacro file of that text makes with these arguments. Raises `InputError`."""
    root = xml_root(text, path)  # says where it is none: xacro does not
    if importlib.util.find_spec("xacrodoc") is None:
        raise InputError(Fault(str(path), "is xacro", f"{HOW}, or in ROS: xacro {path} > robot.urdf"))
    import xacrodoc
    from xacrodoc import packages

    find = finder(path.resolve().parent, given)

    def place(name: str) -> str:
        if (folder := find(name)) is None:
            raise LookupError(f"Package not found: {name}")
        return folder.as_posix()

    packages.get_path = place  # what xacrodoc gives to xacro's $(find NAME)
    try:
        # included where it is: names of files in it count from there, wherever one stands
        document = xacrodoc.XacroDoc.from_includes(
            [escape(glob.escape(path.resolve().as_posix()))], subargs=dict(arguments), resolve_packages=False
        )
        urdf = str(document.to_urdf_string())
    except UnicodeDecodeError:
        mend = "save the file, and those that it includes, as UTF-8"
        raise InputError(Fault(str(path), "is not all UTF-8, and xacro reads nothing else", mend)) from None
    except Exception as error:  # xacro raises what it likes
        message = " ".join(str(error).split()) or type(error).__name__
        if (lacking := LACKING.search(message)) is not None:
            mend = f"say --package {lacking[1]}=DIR, or set ROS_PACKAGE_PATH"
            raise InputError(Fault(str(path), f"needs the package {lacking[1]!r}", mend)) from None
        name = asked[1] if (asked := ASKED.search(message)) else "NAME"
        mend = f"arguments are given as {name}:=VALUE behind the file" + _own_arguments(root)
        raise InputError(Fault(str(path), f"xacro says: {message}", mend)) from None
    if "<link" not in urdf:
        others = (other for other in sorted(path.parent.glob("*.xacro")) if other != path)
        callers = [other.name for other in others if path.name in read_xml(other)[0]]
        mend = f"name the file that calls its macros{': ' if callers else ''}{', '.join(callers)}"
        raise InputError(Fault(str(path), "makes no link by itself", mend))
    return urdf


def _own_arguments(root: ET.Element) -> str:
    """Which arguments the file itself says that it takes."""
    found = [item.get("name", "") for item in root.iter(f"{XACRO}arg")]
    return f"; it takes {', '.join(found)}" if found else ""
