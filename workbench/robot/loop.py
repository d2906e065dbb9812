"""`[controller.loop]` of a robot's TOML: how its controller samples, what its drives bear, how they rub."""

from __future__ import annotations

from pydantic import ConfigDict, Field, ValidationInfo, field_validator

from ..files.measure import AboveZero
from ..files.section import Section


class Loop(Section):
    """A sampled cascade: position loop and velocity loop (PI) on the motor's encoder. SI units."""

    model_config = ConfigDict(allow_inf_nan=False)

    position_period: float = Field(default=0.004, ge=1e-4, le=0.05)
    """sampling of the position loop [s]"""
    drive_period: float = Field(default=0.0005, ge=1e-4, le=0.01)
    """sampling of the velocity loop [s]"""
    delay: float = Field(default=0.0005, ge=0, le=0.02)
    """from the sample to the torque, computation and bus together [s]"""
    velocity_filter: float = Field(default=0.00025, ge=0, le=0.02)
    """time constant of the measured velocity [s]"""
    encoder_steps: float = Field(default=0.0, ge=0)
    """per motor turn; 0: infinitely fine"""
    position_hz: AboveZero = 5.0
    """bandwidth asked of the position loop"""
    velocity_hz: AboveZero | None = None
    """bandwidth of the velocity loop, the drive alone on it; absent: what the phase margin allows"""
    phase_margin_deg: float = Field(default=45.0, ge=1, lt=80)
    """of the velocity loop on the drive alone"""
    gain_margin: float = Field(default=2.0, ge=1)
    """factor on all drives' gains that the whole arm has to bear"""
    delay_margin: float = Field(default=0.0005, ge=0)
    """more delay [s] that the whole arm has to bear"""
    gain_factor: float = Field(default=1.0, gt=0, le=10)
    """on all drives' gains once they are made: of drives that are tuned otherwise"""
    feed_forward_hz: AboveZero = 10.0
    """up to where the arm's inertia is fed forward"""
    friction_known: float = Field(default=0.9, ge=0, le=1.5)
    """share of the friction that is fed forward"""
    coulomb: float = Field(default=0.01, ge=0, le=0.5)
    """friction of a drive as a share of the weight of the arm that it moves, stretched as a path starts"""
    stiction: float = Field(default=1.2, ge=1, le=5)
    """how much higher friction is at rest"""
    stribeck_speed: AboveZero = 0.02
    """speed over which friction falls [rad/s, m/s]"""
    viscous: float = Field(default=0.01, ge=0, le=5)
    """friction at 1 rad/s, as a share like coulomb"""
    presliding: AboveZero = 2e-5
    """way over which friction builds up [rad, m]"""
    load_side: float = Field(default=0.1, ge=0, le=1)
    """share of coulomb that sits behind the gear's spring, and winds it up"""
    gas_exponent: float = Field(default=1.3, ge=1, le=1.4)
    """polytropic exponent of a gas compensator in a fast stroke"""
    gas_time: AboveZero = 60.0
    """time in which its heat leaves [s]"""

    @field_validator("drive_period")
    @classmethod
    def _not_longer(cls, period: float, info: ValidationInfo) -> float:
        outer = info.data.get("position_period")
        if outer is not None and period > outer:
            raise ValueError(f"should be no longer than position_period, {outer:g} s")
        return period

    @property
    def cycles(self) -> int:
        """Drive periods in a position period."""
        return max(1, round(self.position_period / self.drive_period))
