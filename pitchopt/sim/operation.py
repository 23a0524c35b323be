"""Steady operation of a dynamic turbine, and the controllers that follow from it.

Below rated power the rotor runs at its best tip-speed ratio within its speed limits and at fine
pitch, above it at rated speed with the pitch that gives rated power (`pitchopt.aero.steady`).
Pitch moves faster than the wake settles, so the schedule takes the sensitivity with the induced
velocities of the operating point; in momentum balance it is smaller, near rated wind by far.
From these points come

    k = 1/2 rho pi R^5 C_P / (lambda^3 G^3)     gain of the torque law, generator side,
    dP/dbeta over pitch, wake held still         for the gain schedule of the pitch regulator,
    derivatives of torque and thrust             for the linear quadratic regulator,
    C_P over tip-speed ratio and pitch           for the wind estimator.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pitchopt.aero.static_rotor import StaticRotor
from pitchopt.aero.steady import (
    OperatingPoints,
    Surfaces,
    UniformInflow,
    mean_loads,
    operating_points,
    performance,
)
from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.control import (
    LinearQuadratic,
    OperatingDerivatives,
    PitchRange,
    PitchRegulator,
    QuadraticWeights,
    TorqueLaw,
    TurbineController,
    WindEstimator,
    nrel_5mw_baseline,
)
from pitchopt.errors import InputError
from pitchopt.sim.simulate import Start
from pitchopt.sim.turbine import DynamicTurbine

__all__ = ["FrozenSlopes", "Operation"]

_SPEED_CORNER = 0.25 / (12.1 * math.pi / 30.0) * 2.0 * math.pi  # over rated rotor speed
_QUADRATIC_CORNER = 3.0 * _SPEED_CORNER  # the gains know no filter, so it has to be fast
_FREQUENCY = 0.6 / (12.1 * math.pi / 30.0)
_FULL_LOAD_PITCH = math.radians(0.5)  # operating points above it are in full load
_PITCH_STEP = math.radians(0.1)  # of a central difference
_AZIMUTHS = 8


class FrozenSlopes(NamedTuple):
    """Derivatives of one blade's mean loads by pitch, (W,).

    Attributes
    ----------
    torque, bending : ndarray (W,)
        About the shaft, and out of plane about the rotor apex [N m/rad].
    """

    torque: FloatArray
    bending: FloatArray


@dataclass(frozen=True)
class Operation:
    """What a turbine does in steady wind.

    Parameters
    ----------
    dynamic : DynamicTurbine

    Raises
    ------
    InputError
        If the turbine's data lack a speed or the best tip-speed ratio.
    """

    dynamic: DynamicTurbine

    def __post_init__(self) -> None:
        if self.dynamic.turbine.optimal_tip_speed_ratio is None:
            raise InputError(
                f"turbine {self.dynamic.turbine.name!r}: its best tip-speed ratio is not known"
            )

    @property
    def _ratio(self) -> float:
        ratio = self.dynamic.turbine.optimal_tip_speed_ratio
        assert ratio is not None  # checked
        return ratio

    @property
    def mechanical_power(self) -> float:
        """Rated, into the generator [W]."""
        return self.dynamic.turbine.rated_power / self.dynamic.efficiency

    @cached_property
    def surfaces(self) -> Surfaces:
        """C_P and C_T in uniform wind over tip-speed ratio and pitch."""
        turbine = self.dynamic.turbine
        return performance(
            turbine.rotor,
            np.arange(1.5, max(1.6 * self._ratio, 13.0), 0.5),
            np.deg2rad(np.concatenate([np.arange(-4.0, 4.0), np.arange(4.0, 32.0, 2.0)])),
            azimuths=6,
            air_density=turbine.air_density,
        )

    @cached_property
    def fine_pitch(self) -> float:
        """Pitch below rated power [rad].

        The turbine's own, unless it costs more than 5 % of the largest C_P at the best tip-speed
        ratio (some files give the lower end of the actuator's range): then that of the largest.
        """
        surfaces, own = self.surfaces, self.dynamic.turbine.fine_pitch
        row = int(np.argmin(np.abs(surfaces.tip_speed_ratio - self._ratio)))
        power = surfaces.cp[row]
        best = int(np.argmax(power))
        if own is not None and np.interp(own, surfaces.pitch, power) >= 0.95 * power[best]:
            return own
        return float(surfaces.pitch[best])

    @cached_property
    def full_load(self) -> NDArray[np.intp]:
        """Places of `curve` at which pitch limits the power."""
        return np.flatnonzero(self.curve.pitch > self.fine_pitch + _FULL_LOAD_PITCH)

    @cached_property
    def frozen_slopes(self) -> FrozenSlopes:
        """Derivatives of blade loads by pitch over `curve`, rotor speed and wake held still."""
        turbine, curve = self.dynamic.turbine, self.curve
        azimuth = 2.0 * np.pi * np.arange(_AZIMUTHS) / _AZIMUTHS
        torque, bending = np.empty((2, curve.wind_speed.size))
        for i, (wind, omega, pitch) in enumerate(
            zip(curve.wind_speed, curve.rotor_speed, curve.pitch, strict=True)
        ):
            model = StaticRotor(
                rotor=turbine.rotor,
                wind=UniformInflow(float(wind)),
                rotor_speed=float(omega),
                air_density=turbine.air_density,
                induction="frozen",
            )
            low, high = (
                model.blade_loads(
                    azimuth, np.full(_AZIMUTHS, pitch + side), mean_pitch=float(pitch)
                )
                for side in (-_PITCH_STEP, _PITCH_STEP)
            )
            torque[i] = (high.torque - low.torque).mean() / (2.0 * _PITCH_STEP)
            bending[i] = (high.bending - low.bending).mean() / (2.0 * _PITCH_STEP)
        return FrozenSlopes(torque=torque, bending=bending)

    def points(self, wind_speed: ArrayLike) -> OperatingPoints:
        """Operating points in uniform wind at hub speeds (W,) [m/s]."""
        turbine = self.dynamic.turbine
        return operating_points(
            turbine.rotor,
            wind_speed,
            rated_power=self.mechanical_power,
            optimal_tip_speed_ratio=self._ratio,
            rated_rotor_speed=turbine.rated_rotor_speed,
            min_rotor_speed=turbine.min_rotor_speed,
            fine_pitch=self.fine_pitch,
            air_density=turbine.air_density,
        )

    @cached_property
    def curve(self) -> OperatingPoints:
        """Operating points over the turbine's range of wind speeds, a metre per second apart."""
        return self.points(self._speeds)

    @cached_property
    def _speeds(self) -> FloatArray:
        turbine = self.dynamic.turbine
        low = turbine.cut_in_wind_speed or 3.0
        high = turbine.cut_out_wind_speed or 25.0
        return np.linspace(low, high, max(round(high - low), 2) + 1)

    @cached_property
    def _parts(self) -> dict[int, OperatingPoints]:
        """Pairs of neighbours on the curve, as far as they were asked for."""
        return {}

    def _around(self, speed: float) -> OperatingPoints:
        """The curve, or the two points of it about a speed while it has not been computed."""
        if "curve" in vars(self):
            return self.curve
        k = int(np.clip(np.searchsorted(self._speeds, speed) - 1, 0, self._speeds.size - 2))
        if k not in self._parts:
            self._parts[k] = self.points(self._speeds[k : k + 2])
        return self._parts[k]

    def start(self, wind_speed: float, *, azimuth: float = 0.0) -> Start:
        """State near steady operation at a hub wind speed [m/s], held outside of the range."""
        speed = finite_number("wind_speed", wind_speed, at_least=0.0)
        curve = self._around(speed)
        rotor_speed = float(np.interp(speed, curve.wind_speed, curve.rotor_speed))
        power = float(np.interp(speed, curve.wind_speed, curve.power))
        gear = self.dynamic.turbine.drivetrain.gear_ratio
        return Start(
            rotor_speed=rotor_speed,
            pitch=float(np.interp(speed, curve.wind_speed, curve.pitch)),
            torque=power / (rotor_speed * gear),
            azimuth=azimuth,
        )

    def torque_law(self, *, factor: float = 1.0, constant_power: bool = True) -> TorqueLaw:
        """Torque law with the gain of the best tip-speed ratio.

        Parameters
        ----------
        factor : float
            Multiplies the gain.
        constant_power : bool
            Above rated speed, otherwise constant torque.
        """
        turbine = self.dynamic.turbine
        rotor, gear = turbine.rotor, turbine.drivetrain.gear_ratio
        speed = 0.6 * turbine.rated_rotor_speed * rotor.radius / self._ratio
        omega = self._ratio * speed / rotor.radius
        torque, _ = mean_loads(
            rotor,
            UniformInflow(speed),
            omega,
            self.fine_pitch,
            air_density=turbine.air_density,
        )
        return TorqueLaw.from_turbine_numbers(
            gain=float(torque) / omega**2 / gear**3,
            rated_power=self.mechanical_power,
            rated_speed=turbine.rated_rotor_speed * gear,
            least_speed=turbine.min_rotor_speed * gear,
            constant_power=constant_power,
            factor=factor,
        )

    def pitch_regulator(
        self, *, frequency: float | None = None, damping: float = 0.7, degree: int = 1
    ) -> PitchRegulator:
        """Pitch regulator of a mode of the rotor speed.

        Parameters
        ----------
        frequency : float, optional
            [rad/s]; 0.6 rad/s times rated rotor speed over 12.1 rpm if absent.
        damping : float
            Fraction of critical.
        degree : {1, 2}
            Of the fit of dP/dbeta over pitch, 1 as in the NREL 5 MW report.
        """
        turbine = self.dynamic.turbine
        curve = self.curve
        full = self.full_load
        power = turbine.rotor.blades * curve.rotor_speed * self.frozen_slopes.torque
        return PitchRegulator.tuned(
            frequency=_FREQUENCY * turbine.rated_rotor_speed if frequency is None else frequency,
            damping=damping,
            pitch=curve.pitch[full],
            sensitivity=power[full],
            rotor_speed=turbine.rated_rotor_speed,
            inertia=self.dynamic.rotor_inertia,
            gear_ratio=turbine.drivetrain.gear_ratio,
            degree=degree,
        )

    @cached_property
    def estimator(self) -> WindEstimator:
        """Estimator of the rotor-effective wind speed."""
        turbine, surfaces, curve = self.dynamic.turbine, self.surfaces, self.curve
        middle = int(self.full_load[0]) if self.full_load.size else 0
        return WindEstimator.tuned(
            bandwidth=0.5 * turbine.rated_rotor_speed,
            wind_speed=float(curve.wind_speed[middle]),
            rotor_speed=float(curve.rotor_speed[middle]),
            at_pitch=float(curve.pitch[middle]),
            tsr=surfaces.tip_speed_ratio,
            pitch=surfaces.pitch,
            power_coefficient=surfaces.cp,
            radius=turbine.rotor.radius,
            air_density=turbine.air_density,
            inertia=self.dynamic.rotor_inertia,
            gear_ratio=turbine.drivetrain.gear_ratio,
        )

    @property
    def pitch_range(self) -> PitchRange:
        """Range of the commands: collective from fine pitch on, blades from the actuator's."""
        actuator = self.dynamic.actuator
        assert actuator is not None  # set by DynamicTurbine
        return PitchRange(
            lowest=max(self.fine_pitch, actuator.lowest),
            highest=actuator.highest,
            rate=actuator.rate,
            blade_lowest=actuator.lowest,
        )

    def controller(
        self,
        *,
        frequency: float | None = None,
        damping: float = 0.7,
        factor: float = 1.0,
        constant_power: bool = True,
        estimator: bool = False,
    ) -> TurbineController:
        """Torque law and pitch regulator from the turbine's own steady operation.

        Parameters are those of `torque_law` and `pitch_regulator`; `estimator` adds the wind
        estimator, which a table of lowest pitch or a schedule over the wind needs.
        """
        return TurbineController(
            torque=self.torque_law(factor=factor, constant_power=constant_power),
            pitch=self.pitch_regulator(frequency=frequency, damping=damping),
            pitch_range=self.pitch_range,
            speed_corner=_SPEED_CORNER * self.dynamic.turbine.rated_rotor_speed,
            estimator=self.estimator if estimator else None,
        )

    def baseline(self) -> TurbineController:
        """The published baseline controller of the NREL 5 MW, `controller` for other turbines."""
        if self.dynamic.turbine.name == "nrel-5mw":
            return nrel_5mw_baseline()
        return self.controller()

    def derivatives(self, wind_speed: ArrayLike) -> OperatingDerivatives:
        """Steady points (W,) and derivatives of torque and thrust there, for `LinearQuadratic`."""
        turbine, dynamic = self.dynamic.turbine, self.dynamic
        speeds = finite_array("wind_speed", wind_speed)
        points, columns = self._linearised(speeds)
        gear = turbine.drivetrain.gear_ratio
        tower = dynamic.tower
        stiffness = float(tower.stiffness[0] - dynamic.body_tables.tower_weight[0])
        mass = stiffness / float(tower.frequency[0]) ** 2
        actuator, lag = dynamic.actuator, dynamic.generator_lag
        assert actuator is not None and lag is not None  # set by DynamicTurbine
        pitch_time = actuator.time_constant or 0.0
        if actuator.frequency is not None and actuator.damping is not None:
            pitch_time = 2.0 * actuator.damping / actuator.frequency
        return OperatingDerivatives(
            wind_speed=speeds,
            rotor_speed=points.rotor_speed,
            pitch=points.pitch,
            generator_torque=points.torque / gear,
            tower_displacement=points.thrust / stiffness,
            torque_by_wind=columns[0, 0],
            torque_by_speed=columns[1, 0],
            torque_by_pitch=columns[2, 0],
            thrust_by_wind=columns[0, 1],
            thrust_by_speed=columns[1, 1],
            thrust_by_pitch=columns[2, 1],
            inertia=dynamic.rotor_inertia,
            gear_ratio=gear,
            tower_mass=mass,
            tower_stiffness=stiffness,
            tower_damping=float(tower.damping[0]),
            pitch_time=pitch_time,
            torque_time=lag.time_constant,
        )

    def _linearised(self, speeds: FloatArray) -> tuple[OperatingPoints, FloatArray]:
        """Points (W,), and derivatives by wind, speed and pitch of torque and thrust (3, 2, W)."""
        key = speeds.tobytes()
        if key in self._known:
            return self._known[key]
        turbine = self.dynamic.turbine
        points = self.curve if np.array_equal(speeds, self._speeds) else self.points(speeds)

        def loads(wind: float, omega: float, pitch: float) -> FloatArray:
            return np.array(
                mean_loads(
                    turbine.rotor,
                    UniformInflow(wind),
                    omega,
                    pitch,
                    air_density=turbine.air_density,
                )
            )

        columns = np.empty((3, 2, speeds.size))
        for i, (wind, omega, pitch) in enumerate(
            zip(speeds, points.rotor_speed, points.pitch, strict=True)
        ):
            at = np.array([wind, omega, pitch], dtype=np.float64)
            for j, step in enumerate((0.02 * wind, 0.01 * omega, _PITCH_STEP)):
                side = np.zeros(3)
                side[j] = step
                columns[j, :, i] = (loads(*(at + side)) - loads(*(at - side))) / (2.0 * step)
        self._known[key] = points, columns
        return self._known[key]

    @cached_property
    def _known(self) -> dict[bytes, tuple[OperatingPoints, FloatArray]]:
        """Points and derivatives by wind speeds, as far as they were asked for."""
        return {}

    def on(self, dynamic: DynamicTurbine) -> Operation:
        """Operation of the same rotor and drivetrain on another tower.

        What has been computed for the rotor is kept: steady points, power coefficients, slopes and
        the wind estimator do not know the tower.

        Raises
        ------
        InputError
            If more than tower and hub height differ.
        """
        ours, theirs = self.dynamic.turbine, dynamic.turbine
        parts: tuple[tuple[object, object, tuple[str, ...]], ...] = (
            (ours, theirs, ("rated_power", "rated_rotor_speed", "min_rotor_speed", "air_density")),
            (ours, theirs, ("fine_pitch", "optimal_tip_speed_ratio", "drivetrain", "hub")),
            (ours, theirs, ("blade_structure", "cut_in_wind_speed", "cut_out_wind_speed")),
            (self.dynamic, dynamic, ("generator_inertia",)),
            (
                ours.rotor,
                theirs.rotor,
                ("blade", "blades", "hub_radius", "tilt", "cone", "overhang"),
            ),
        )
        for mine, other, keys in parts:
            for key in keys:
                if getattr(mine, key) != getattr(other, key):
                    raise InputError(f"dynamic: its {key} is another, expected another tower only")
        moved = Operation(dynamic)
        names = ("surfaces", "fine_pitch", "curve", "full_load", "frozen_slopes", "estimator")
        for name in (*names, "_known", "_parts"):
            if name in vars(self):
                vars(moved)[name] = vars(self)[name]
        return moved

    def linear_quadratic(self, *, tower_velocity: float = 0.0) -> TurbineController:
        """Linear quadratic regulator with weight `tower_velocity` on the tower top [s^2/m^2]."""
        turbine = self.dynamic.turbine
        low = max(turbine.cut_in_wind_speed or 3.0, 3.0)
        high = turbine.cut_out_wind_speed or 25.0
        derivatives = self.derivatives(np.linspace(low, high, max(round(high - low), 2) + 1))
        weights = QuadraticWeights(
            largest_pitch=float(derivatives.pitch.max()), tower_velocity=tower_velocity
        )
        return TurbineController(
            torque=self.torque_law(),
            pitch=LinearQuadratic.designed(derivatives, weights),
            pitch_range=self.pitch_range,
            speed_corner=_QUADRATIC_CORNER * turbine.rated_rotor_speed,
            estimator=self.estimator,
        )
