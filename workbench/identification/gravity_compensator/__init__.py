"""A gravity compensator by itself: its torque, its stiffness, and its identification."""
