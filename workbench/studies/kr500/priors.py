"""What the paper does not give and every account is free to choose, with the ranges allowed."""

from __future__ import annotations

from workbench import Prior

# the middles of the classes: modal test of a KR 500 (public MATLAB model) and equation (19), both well inside
STIFFNESS = {1: (1e6, 2e7), 2: (3e6, 1.2e7), 3: (2e6, 8e6), 4: (2e5, 4e6), 5: (1e5, 5e5), 6: (2e5, 1.2e6)}
CLASS = "modal test of a KR 500 and equation (19) are well inside"
FREE_START = "the paper names no start; it may be any stiffness of the class"

SPRINGS = {
    f"k{j}": Prior(f"stiffness of joint {j}", *ends, "N·m/rad", log=True, why=CLASS)
    for j, ends in STIFFNESS.items()
}
STARTS = {
    f"start{j}": Prior(f"start of the solver, joint {j}", *ends, "N·m/rad", log=True, why=FREE_START)
    for j, ends in STIFFNESS.items()
}

CELL = {
    "near": Prior("box, from the nearest to the farthest in reach", 0.0, 1.0, why="not given"),
    "y": Prior("box, centre along y", -0.2, 0.2, "m", why="not given"),
    "z": Prior("box, centre along z", 0.75, 1.45, "m", why="not given; above the floor, within reach"),
    "along": Prior("long side along y (below 0.7) or x", 0.0, 1.0, why="not given"),
    "smr_x": Prior("SMR from the flange, x", -0.2, 0.2, "m", why="not given"),
    "smr_y": Prior("SMR from the flange, y", -0.2, 0.2, "m", why="not given"),
    "smr_z": Prior("SMR from the flange, z", 0.1, 0.35, "m", why="not given"),
    "mass_x": Prior("load from axis 6, x", -0.15, 0.15, "m", why="not given"),
    "mass_y": Prior("load from axis 6, y", -0.15, 0.15, "m", why="not given"),
    "mass_z": Prior("load before the flange", 0.1, 0.4, "m", why="not given"),
    "tool": Prior("mass of sensor and tool", 10.0, 60.0, "kg", why="not given"),
    "charge": Prior("gas pressure over the gauged one", 0.75, 1.25, why="gauged on another robot"),
    "gas": Prior("gas length over the gauged one", 0.8, 1.2, why="gauged on another robot"),
    "sigma": Prior("noise of a reading, per axis", 5e-6, 4e-5, "m", log=True, why="trackers at 2 to 5 m"),
    "scatter": Prior("repeatability over the robot's", 0.3, 2.0, log=True, why="data sheet: the worst"),
    "sensor": Prior("noise of the force sensor", 0.2, 3.0, "N", log=True, why="resolution to 10 times it"),
    "again": Prior("measured anew after calibration (above 0.5)", 0.0, 1.0, why="not said"),
}  # fmt: skip

SOLVER = STARTS | {
    "damping": Prior(
        "damping: noise that a doubled stiffness is worth", 1e-7, 1e-4, "m", log=True, why="not given"
    ),
}

SOFT = {
    "soft_joint": Prior("soft zone in joint 2 (below 0.5) or 3", 0.0, 1.0, why="not known"),
    "soft_size": Prior("soft zone, to either side", 3e-5, 5e-4, "rad", log=True,
                       why="an arcminute in all is 1.5 · 10⁻⁴ to either side; three times that"),
    "soft_width": Prior("soft zone, torque", 50.0, 1000.0, "N·m", log=True, why="friction of such a gear"),
}  # fmt: skip

VARYING = {
    **{f"swing{j}": Prior(f"ln K{j} swings by", -1.0, 1.0, why="no form is given; a factor of e")
       for j in STIFFNESS},
    **{f"phase{j}": Prior(f"phase of K{j}", 0.0, 6.283185, "rad", why="free") for j in STIFFNESS},
    "turns": Prior("swings per turn of the joint", 1.0, 4.0, why="“similar in close work spaces”"),
}  # fmt: skip

STRUCTURE = {
    "tilt": Prior("tilt of bearings 1 to 3", 2e-9, 3e-8, "rad/(N·m)", log=True,
                  why="catalogues: half to five times 6 · 10⁻⁹"),
    "tilt_wrist": Prior("tilt of bearings 4 to 6", 1e-8, 2e-7, "rad/(N·m)", log=True,
                        why="catalogues: up to 6 · 10⁻⁸, three times that"),
    "foundation": Prior("tilt of the foundation", 1e-10, 5e-9, "rad/(N·m)", log=True, why="plates, anchors"),
    "hand": Prior("tilt of sensor and tool", 1e-8, 2e-6, "rad/(N·m)", log=True, why="a steel bracket"),
}  # fmt: skip

BRACKET = {
    f"shift_{a}": Prior(f"50 kg shift the SMR along the flange's {a}", -1.5e-4, 1.5e-4, "m",
                        why="a bracket of 3 N/µm")
    for a in "xyz"
}  # fmt: skip

FORCE = {
    **{f"turn_{a}": Prior(f"force sensor turned about {a}", -3.0, 3.0, "°", why="mounted by hand")
       for a in "xyz"},
    "gain": Prior("force read over force", 0.95, 1.05, why="data sheet 1 to 1.5 % of the range"),
    **{f"drift_{a}": Prior(f"offset of the force, {a}", -15.0, 15.0, "N", why="1 % of the sensor's range")
       for a in "xyz"},
    "side_x": Prior("cables pull, x", -30.0, 30.0, "N", why="a hose package"),
    "side_y": Prior("cables pull, y", -30.0, 30.0, "N", why="a hose package"),
}  # fmt: skip
