"""The gas spring of the KUKA KR 210 R2700, which stands in for those of its larger and smaller relatives."""

from typing import Any


def gas_spring(joint_2_ahead: float, piston_area: float) -> dict[str, Any]:
    """Fixed pivot 800 mm behind and 67 mm below joint 2, moving pivot 200 mm from it.

    joint_2_ahead: [m] of joint 1. The link frames have x forward and z up at q = 0. Charge and gas length as
    measured on a KR 300 (163 bar, 0.547 m, isothermal); piston_area: [m²], there 1.67e-3.
    """
    return {
        "kind": "gas",
        "joint": "joint_2",
        "body": "link_1",
        "arm": "link_2",
        "body_pivot": (round(joint_2_ahead - 0.800, 3), 0.0, -0.067),
        "arm_pivot": (-0.01, 0.0, 0.200),
        "piston_area": piston_area,
        "precharge": 163e5,
        "gas_length": 0.547,
        "reference": 0.6026,
        "exponent": 1.0,
    }
