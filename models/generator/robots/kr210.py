"""The gas spring of the KUKA KR 210 R2700, which stands in for those of its larger and smaller relatives."""

from typing import Any

GAUGED = {"precharge": 163e5, "gas_length": 0.547}  # Pa, m: nine pressures of a KR 300, isothermal
GAUGED_AREA = 1.669e-3  # m²: piston of 55 mm, rod of 30 mm, of the same KR 300


def gas_spring(
    joint_2_ahead: float, piston_area: float, precharge: float, gas_length: float
) -> dict[str, Any]:
    """Fixed pivot 800 mm behind and 67 mm below joint 2, moving pivot 200 mm from it.

    joint_2_ahead: [m] of joint 1. The link frames have x forward and z up at q = 0. piston_area: [m²],
    precharge: [Pa] absolute, gas_length: [m].
    """
    return {
        "kind": "gas",
        "joint": "joint_2",
        "body": "link_1",
        "arm": "link_2",
        "body_pivot": (round(joint_2_ahead - 0.800, 3), 0.0, -0.067),
        "arm_pivot": (-0.01, 0.0, 0.200),
        "piston_area": piston_area,
        "precharge": precharge,
        "gas_length": gas_length,
        "reference": 0.6026,
        "exponent": 1.0,
    }
