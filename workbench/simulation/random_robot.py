"""Arms that nobody tuned anything on: a URDF and a TOML drawn at random, for tests and the blind study."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..files.toml import toml_text
from ..files.whole import put_all

# joint origin directions (parent frame) and axes of a usual arm; lengths are drawn
_ARMS = {
    "6R": ("zyyxyx", ("z", "xz", "z", "zx", "x", "x")),
    "7R": ("zyzyzyz", ("z", "z", "z", "z", "z", "z", "z")),
    "PRRR": ("xzzy", ("z", "z", "x", "x")),
}


def write_random_robot(folder: Path, seed: int, kind: str = "6R", elastic: bool = True) -> Path:
    """Writes `<kind><seed>.urdf` and `.toml` into `folder` and returns the TOML's path.

    kind: "6R", "7R", or "PRRR" (a sliding first joint). Lengths 0.1–0.9 m, masses and stiffness
    that scale with them; every frame gets a small random turn, so that nothing is aligned by luck.
    """
    rng = np.random.default_rng(seed)
    axes, ways = _ARMS[kind]
    n = len(axes)
    size = rng.uniform(0.6, 1.2)
    name = f"{kind.lower()}_{seed}"
    parts = [
        f'<?xml version="1.0"?>\n<robot name="{name}">',
        _link("base_link", 100.0 * size, (0, 0, 0.1), size),
    ]
    joints = []
    for i in range(n):
        shrink = 0.75**i
        origin = np.zeros(3)
        for way in ways[i]:
            origin["xyz".index(way)] = rng.uniform(0.25, 0.9) * size * (0.8 if i else 0.9)
        turn = rng.uniform(-0.02, 0.02, 3)
        axis = np.eye(3)["xyz".index(axes[i])]
        sliding = kind.startswith("P") and i == 0
        joint = "prismatic" if sliding else "revolute"
        limit = 1.0 if sliding else rng.uniform(1.9, 3.0)
        mass = 120 * size**2 * shrink**2
        com = 0.5 * np.array([0.3, 0.05, 0.5]) * size * shrink
        parts.append(_joint(f"joint_{i + 1}", joint, i, origin, turn, axis, limit))
        parts.append(_link(f"link_{i + 1}", mass, com, size * shrink))
        stiffness = (2e7 if sliding else 5e6 * size**2 * shrink**3) * rng.uniform(0.7, 1.4)
        joints.append(
            {"name": f"joint_{i + 1}"}
            | ({"stiffness": float(f"{stiffness:.4e}")} if elastic else {})
            | ({} if sliding else {"gear_ratio": float(rng.integers(60, 180))})
        )
    parts.append(
        f'<joint name="flange_joint" type="fixed"><parent link="link_{n}"/><child link="flange"/>'
        f'<origin xyz="{0.12 * size:.4f} 0 0.02" rpy="0 0 0"/></joint><link name="flange"/></robot>'
    )
    table = {
        "schema": 1,
        "name": name,
        "title": f"Random {kind} arm, seed {seed}",
        "urdf": f"{name}.urdf",
        "flange": "flange",
        "joints": joints,
        "source": {"everything": "assumed: drawn at random"},
    }
    path = folder / f"{name}.toml"
    put_all({folder / f"{name}.urdf": "\n".join(parts), path: toml_text(table)})
    return path


def _link(name: str, mass: float, com: tuple[float, ...] | np.ndarray, size: float) -> str:
    inertia = 0.05 * mass * size**2
    return (
        f'<link name="{name}"><inertial><origin xyz="{com[0]:.5f} {com[1]:.5f} {com[2]:.5f}" rpy="0 0 0"/>'
        f'<mass value="{mass:.5f}"/><inertia ixx="{inertia:.6f}" iyy="{inertia:.6f}" izz="{inertia:.6f}"'
        ' ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )


def _joint(
    name: str, kind: str, i: int, origin: np.ndarray, turn: np.ndarray, axis: np.ndarray, limit: float
) -> str:
    parent = "base_link" if i == 0 else f"link_{i}"
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="link_{i + 1}"/>'
        f'<origin xyz="{origin[0]:.6f} {origin[1]:.6f} {origin[2]:.6f}" '
        f'rpy="{turn[0]:.6f} {turn[1]:.6f} {turn[2]:.6f}"/><axis xyz="{axis[0]:g} {axis[1]:g} {axis[2]:g}"/>'
        f'<limit lower="{-limit:.4f}" upper="{limit:.4f}" effort="10000" velocity="3"/></joint>'
    )
