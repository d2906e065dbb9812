"""A URDF as a tree of links, and the numbers of its attributes."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from xml.parsers import expat

from ..files.faults import BYTE_ORDER_MARKS, Fault, InputError, read_bytes, text_of
from ..files.measure import beyond

WORLD = "world"  # by convention the URDF's name for the ground, and Drake's own
MOVING = ("revolute", "continuous", "prismatic")
LOOSE = ("floating", "planar")
XACRO = "xacro:"  # prefix of the elements that xacro makes others of
BEYOND = "is not finite or beyond all measure"
DECLARED = re.compile(rb"""^\s*<\?xml[^>]*?\sencoding\s*=\s*["']([\w.:-]+)""")
UTF8 = ("utf-8", "utf8", "us-ascii", "ascii")
STAND_IN = "cp1252"  # for text that is not the UTF-8 that it should be: Latin-1 with quotation marks
NO_LIMIT = 1e6  # rad or m, rad/s or m/s, N·m or N: a farther limit holds nothing
Vector3 = tuple[float, float, float]


@dataclass(frozen=True)
class Urdf:
    """The elements of a URDF: links by name, joints by the link that they carry, colours by material; `notes`
    say how its text was taken where it is not as it should be."""

    path: Path
    links: dict[str, ET.Element]
    joints: dict[str, ET.Element]
    colours: dict[str, str]
    notes: tuple[str, ...] = ()

    def parent(self, link: str) -> str | None:
        """The link that carries this one; None for a root."""
        joint = self.joints.get(link)
        return None if joint is None else _named(joint, "parent")

    def children(self, link: str) -> list[str]:
        """The links that this one carries, in the file's order."""
        return [child for child, joint in self.joints.items() if _named(joint, "parent") == link]

    def above(self, link: str) -> Iterator[str]:
        """The link and those that carry it, up to the root."""
        here: str | None = link
        while here is not None:
            yield here
            here = self.parent(here)

    def below(self, link: str) -> list[str]:
        """The link and all that it carries, parents before children."""
        return [link] + [name for child in self.children(link) for name in self.below(child)]

    def kind(self, link: str) -> str:
        """Type of the joint that carries the link."""
        return self.joints[link].get("type", "")


def read_urdf(path: Path) -> Urdf:
    """The elements of a URDF. Raises `InputError` with every fault of its tree."""
    text, notes = read_xml(path)
    return parse_urdf(text, path, notes)


def parse_urdf(text: str, path: Path, notes: tuple[str, ...] = ()) -> Urdf:
    """The elements of a URDF's text; `path` is where it stands. See `read_urdf`."""
    root = xml_root(text, path)
    if any(item.tag.startswith(XACRO) for item in root.iter()):
        raise InputError(Fault(str(path), "is xacro, not yet a URDF", f"workbench init {path} expands it"))
    if root.tag != "robot":
        raise InputError(Fault(str(path), f"is <{root.tag}>, not a URDF's <robot>", "name the URDF"))
    _free_the_world(root)
    links: dict[str, ET.Element] = {}
    joints: dict[str, ET.Element] = {}
    names: set[str] = set()
    faults = []
    for link in root.findall("link"):
        if (name := link.get("name", "")) in links:
            faults.append(Fault(str(path), f"link {name!r} twice", "rename one"))
        links[name] = link
    for joint in root.findall("joint"):
        name, child = joint.get("name", ""), _named(joint, "child")
        ends = {"parent": _named(joint, "parent"), "child": child}
        faults += [
            Fault(f"{path}: joint {name!r}", f"no link {link!r}", f"mend its <{end}>")
            for end, link in ends.items()
            if link not in links
        ]
        if child in joints or name in names:
            what = f"joint {name!r} twice" if name in names else f"link {child!r} hangs on two joints"
            faults.append(Fault(str(path), what, "a robot is a tree: take one out"))
        names.add(name)
        joints[child] = joint
    colours = {item.get("name", ""): _colour(item) for item in root.findall("material")}
    urdf = Urdf(path, links, joints, {name: colour for name, colour in colours.items() if colour}, notes)
    faults += [] if faults else _circles(urdf)
    if faults:
        raise InputError(faults)
    return urdf


def read_xml(path: Path) -> tuple[str, tuple[str, ...]]:
    """The text of an XML file, in the encoding that its byte order mark or its declaration says, else UTF-8;
    and what is to be said of that. Raises `InputError`."""
    content = read_bytes(path)
    declared = DECLARED.match(content)
    encoding = "utf-8" if declared is None else declared[1].decode("ascii").lower()
    notes: tuple[str, ...] = ()
    if encoding in UTF8 and not content.startswith(tuple(BYTE_ORDER_MARKS)) and not _is_utf8(content):
        content = content.decode(STAND_IN, "replace").encode()
        notes = ("is not UTF-8, nor says what else: read as Latin-1, letters beyond ASCII may be wrong",)
    try:
        return text_of(content, path, encoding), notes
    except (LookupError, UnicodeError):
        what = f"says encoding {encoding!r}, which nobody knows"
        raise InputError(Fault(str(path), what, "save it as UTF-8 and say so in its first line")) from None


def _is_utf8(content: bytes) -> bool:
    try:
        content.decode()
    except UnicodeDecodeError:
        return False
    return True


def read_root(path: Path) -> ET.Element:
    """The root of an XML file. Raises `InputError`."""
    return xml_root(read_xml(path)[0], path)


def xml_root(text: str, path: Path) -> ET.Element:
    """The root of an XML text, its names with their prefixes as they are written: old URDFs have some that
    they never declare, and ROS reads them. Raises `InputError`."""
    tree, parser = ET.TreeBuilder(), expat.ParserCreate()
    parser.StartElementHandler = tree.start
    parser.EndElementHandler = tree.end
    parser.CharacterDataHandler = tree.data
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        mend = "mend it there, or take the file anew from where it is published"
        raise InputError(Fault(str(path), f"is not XML: {error}", mend)) from None
    return tree.close()


def _free_the_world(root: ET.Element) -> None:
    """A link called world that carries a moving joint is a base, not Drake's world: it gets a name."""
    ends = [end for end in root.findall("joint/parent") if end.get("link") == WORLD]
    if any(joint.get("type") in MOVING for joint in root.findall("joint") if joint.find("parent") in ends):
        for item in [*root.findall("link"), *ends]:
            key = "name" if item.tag == "link" else "link"
            if item.get(key) == WORLD:
                item.set(key, f"{WORLD}_link")


def _circles(urdf: Urdf) -> list[Fault]:
    for link in urdf.links:
        seen = set()
        for name in urdf.above(link):
            if name in seen:
                return [Fault(str(urdf.path), f"link {name!r} carries itself", "a robot is a tree")]
            seen.add(name)
    return []


def origin_of(element: ET.Element, place: str) -> tuple[Vector3, Vector3]:
    """xyz [m] and rpy [rad] of an element's `<origin>`; zero without one."""
    origin = element.find("origin")
    if origin is None:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    return vector(origin, "xyz", place), vector(origin, "rpy", place)


def vector(element: ET.Element | None, key: str, place: str, default: Vector3 = (0.0, 0.0, 0.0)) -> Vector3:
    """Three numbers of an attribute. Raises `InputError`."""
    text = None if element is None else element.get(key)
    if text is None:
        return default
    try:
        x, y, z = (float(word) for word in text.split())
    except ValueError:
        raise InputError(Fault(place, f"{key} = {text!r} is not three numbers", "mend the URDF")) from None
    if any(map(beyond, (x, y, z))):
        raise InputError(Fault(place, f"{key} = {text!r} {BEYOND}", "mend the URDF"))
    return x, y, z


def number(element: ET.Element | None, key: str, place: str) -> float:
    """A finite number of an attribute, 0 without it. Raises `InputError`."""
    text = None if element is None else element.get(key)
    if text is None:
        return 0.0
    try:
        value = float(text)
    except ValueError:
        raise InputError(Fault(place, f"{key} = {text!r} is not a number", "mend the URDF")) from None
    if beyond(value):
        raise InputError(Fault(place, f"{key} = {text!r} {BEYOND}", "mend the URDF"))
    return value


def limit(element: ET.Element | None, key: str, place: str) -> float:
    """A limit of a joint, infinite where it is so far that it is none: exporters write 1e+16 or the largest
    number that there is. 0 without one. Raises `InputError`."""
    text = None if element is None else element.get(key)
    try:
        value = float(text or 0.0)
    except ValueError:
        value = math.nan
    if math.isnan(value):
        raise InputError(Fault(place, f"{key} = {text!r} is not a number", "mend the URDF"))
    return math.copysign(math.inf, value) if abs(value) > NO_LIMIT else value


def _named(joint: ET.Element, end: str) -> str:
    """The link that a joint's <parent> or <child> names."""
    found = joint.find(end)
    return "" if found is None else found.get("link", "")


def _colour(material: ET.Element) -> str:
    """rgba of a material; "" where it has none."""
    colour = material.find("color")
    text = "" if colour is None else colour.get("rgba", "")
    return text if re.fullmatch(r"\s*([\d.eE+-]+\s+){3}[\d.eE+-]+\s*", text) else ""
