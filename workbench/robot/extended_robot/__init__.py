"""The extended robot for Drake: `AddExtendedRobot(builder)`. It needs pydrake and NumPy alone.

Beside this package stand the robot as SDF (springs, dampers, rotors, coil compensator), `package.xml`, the
model directives, and `effects.npz` with what SDF cannot say: gas compensator, gears' errors, hoses' torques.
"""

from .diagram import AddExtendedRobot, Settle

__all__ = ["AddExtendedRobot", "Settle"]
