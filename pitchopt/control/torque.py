"""Generator torque over the filtered generator speed.

With omega on the high-speed side and all torques there,

    region 1      omega <= cut-in            0
    region 1.5    up to region 2             slope_15 (omega - cut_in)
    region 2      up to the transition       k omega^2
    region 2.5    up to region 3             slope_25 (omega - synchronous)
    region 3      above, or with pitch       P / omega (constant power) or P / rated speed

where slope_15 makes region 1.5 end on k omega^2, and slope_25 is that of an induction generator
whose rated slip s reaches the rated torque at the rated speed:

    synchronous = rated / (1 + s),       slope_25 = (P / rated) / (rated - synchronous).

"With pitch" means a collective command of one degree above the lowest pitch; the report says one
degree, with a lowest pitch of zero, and where a table raises the lowest pitch in partial load
that must not bring constant power.

The transition is where region 2.5 meets k omega^2; if it meets it only above the rated speed, or
nowhere, because k is large, or if there is no region 2.5, then region 2 ends where k omega^2
reaches the torque of region 3, and region 3 begins there.  So the law is continuous in the
speed for every k.  A command keeps below the largest torque and within the rate.

Source: J. Jonkman, S. Butterfield, W. Musial, G. Scott, "Definition of a 5-MW Reference Wind
Turbine for Offshore System Development", NREL/TP-500-38060, 2009, section 7.1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from pitchopt.checks import finite_number
from pitchopt.control.parameters import TorqueParameters
from pitchopt.errors import InputError

__all__ = ["TorqueLaw"]


@dataclass(frozen=True, kw_only=True)
class TorqueLaw:
    """Torque law with the regions above; speeds and torques of the generator.

    Parameters
    ----------
    gain : float
        k of region 2 [N m s^2/rad^2].
    rated_power : float
        Mechanical, into the generator [W].
    rated_speed : float
        Where region 3 begins [rad/s].
    largest_torque : float
        [N m].
    largest_rate : float
        Of the torque [N m/s].
    cut_in_speed, region2_speed : float, optional
        Ends of region 1.5 [rad/s]; both 0 for k omega^2 down to standstill.
    slip : float or None, optional
        Rated slip of region 2.5 [-]; None for a law without this region.
    factor : float, optional
        Multiplies the gain [-].
    constant_power : bool, optional
        Region 3 with constant power, otherwise with constant torque.
    region3_pitch : float, optional
        Collective pitch above the lowest one from which on region 3 holds at any speed [rad];
        infinite for never.

    Raises
    ------
    InputError
        If a number is out of range or the regions are out of order.
    """

    gain: float
    rated_power: float
    rated_speed: float
    largest_torque: float
    largest_rate: float
    cut_in_speed: float = 0.0
    region2_speed: float = 0.0
    slip: float | None = 0.1
    factor: float = 1.0
    constant_power: bool = True
    region3_pitch: float = math.inf

    def __post_init__(self) -> None:
        for name in (
            "gain",
            "rated_power",
            "rated_speed",
            "largest_torque",
            "largest_rate",
            "factor",
        ):
            finite_number(name, getattr(self, name), above=0.0)
        finite_number("cut_in_speed", self.cut_in_speed, at_least=0.0)
        finite_number("region2_speed", self.region2_speed, at_least=self.cut_in_speed)
        if self.slip is not None:
            finite_number("slip", self.slip, above=0.0)
        if math.isnan(self.region3_pitch):
            raise InputError("region3_pitch: got nan, expected an angle in radians, or infinity")
        if self.region2_speed > 0.0 and self.cut_in_speed == self.region2_speed:
            raise InputError(
                f"region2_speed: got {self.region2_speed} rad/s, the cut-in speed as well; "
                "expected a larger speed, for region 1.5 to have a width"
            )
        if self.largest_torque < self.rated_torque:
            raise InputError(
                f"largest_torque: got {self.largest_torque} N m, expected at least the rated "
                f"torque, rated_power / rated_speed = {self.rated_torque:.6g} N m"
            )
        if self.region2_speed >= self.transition_speed:
            raise InputError(
                f"region2_speed: got {self.region2_speed} rad/s, expected a speed below the end "
                f"of region 2 at {self.transition_speed:.6g} rad/s"
            )

    @property
    def rated_torque(self) -> float:
        """Torque at rated power and speed [N m]."""
        return self.rated_power / self.rated_speed

    @property
    def optimal_gain(self) -> float:
        """Gain of region 2 with its factor [N m s^2/rad^2]."""
        return self.factor * self.gain

    @property
    def synchronous_speed(self) -> float:
        """Speed without torque of region 2.5 [rad/s]; the rated speed without the region."""
        return self.rated_speed / (1.0 + (self.slip or 0.0))

    @property
    def _slope_25(self) -> float:
        width = self.rated_speed - self.synchronous_speed
        return self.rated_torque / width if width > 0.0 else 0.0

    @property
    def _crossing(self) -> float | None:
        """Where region 2.5 meets k omega^2 below the rated speed, or None."""
        slope, k = self._slope_25, self.optimal_gain
        root = slope * (slope - 4.0 * k * self.synchronous_speed)
        if self.slip is None or root < 0.0:
            return None
        crossing = (slope - math.sqrt(root)) / (2.0 * k)
        return crossing if crossing < self.rated_speed else None

    @property
    def _meeting(self) -> float:
        """Where k omega^2 has the torque of region 3."""
        if self.constant_power:
            return math.cbrt(self.rated_power / self.optimal_gain)
        return math.sqrt(self.rated_torque / self.optimal_gain)

    @property
    def transition_speed(self) -> float:
        """End of region 2 [rad/s]."""
        crossing = self._crossing
        return self._meeting if crossing is None else crossing

    @property
    def region3_speed(self) -> float:
        """Start of region 3 [rad/s]."""
        return self._meeting if self._crossing is None else self.rated_speed

    def parameters(self) -> TorqueParameters:
        """Numbers for the compiled law."""
        width = self.region2_speed - self.cut_in_speed
        start = self.optimal_gain * self.region2_speed**2
        return TorqueParameters(
            cut_in=float(self.cut_in_speed),
            region2=float(self.region2_speed),
            transition=self.transition_speed,
            region3=self.region3_speed,
            synchronous=self.synchronous_speed,
            slope_15=start / width if width > 0.0 else 0.0,
            slope_25=self._slope_25,
            gain=self.optimal_gain,
            constant_power=int(self.constant_power),
            power=float(self.rated_power),
            rated=self.rated_torque,
            region3_pitch=float(self.region3_pitch),
            largest=float(self.largest_torque),
            rate=float(self.largest_rate),
        )

    def torque(self, speed: float, pitch: float = 0.0) -> float:
        """Torque [N m] at a filtered generator speed [rad/s] and a pitch above the lowest [rad].

        The static law, without the limit of the rate.
        """
        from pitchopt.control.kernels import static_torque

        return float(static_torque(self.parameters(), float(speed), float(pitch)))

    @classmethod
    def from_turbine_numbers(
        cls,
        *,
        gain: float,
        rated_power: float,
        rated_speed: float,
        least_speed: float,
        constant_power: bool = True,
        factor: float = 1.0,
    ) -> TorqueLaw:
        """Law of another turbine with the proportions of the NREL 5 MW.

        Parameters
        ----------
        gain : float
            k of region 2, of the best tip-speed ratio [N m s^2/rad^2].
        rated_power : float
            Mechanical [W].
        rated_speed : float
            Speed that the pitch regulator holds [rad/s]; region 3 begins at 99 % of it.
        least_speed : float
            Cut-in speed [rad/s].  Region 2 begins at 1.3 times this speed, or at 90 % of where
            region 2 ends if that is less.
        constant_power : bool, optional
        factor : float, optional
            Multiplies the gain [-].

        Notes
        -----
        The largest torque is 1.1 times that at rated power and speed, and the rate lets the
        torque rise from nothing to this largest torque in 3.16 s, as for the NREL 5 MW.
        """
        rated_speed = finite_number("rated_speed", rated_speed, above=0.0)
        rated_power = finite_number("rated_power", rated_power, above=0.0)
        least_speed = finite_number("least_speed", least_speed, at_least=0.0)
        largest = 1.1 * rated_power / rated_speed
        numbers = {
            "gain": gain,
            "factor": factor,
            "rated_power": rated_power,
            "rated_speed": 0.99 * rated_speed,
            "largest_torque": largest,
            "largest_rate": largest / 3.16,
        }
        end = cls(constant_power=constant_power, **numbers).transition_speed
        return cls(
            **numbers,
            constant_power=constant_power,
            cut_in_speed=least_speed,
            region2_speed=min(1.3 * least_speed, 0.9 * end),
            region3_pitch=math.radians(1.0),
        )
