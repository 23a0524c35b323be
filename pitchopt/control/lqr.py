"""Linear quadratic regulator with integral action, scheduled over the wind speed.

About an operating point, with the deviations x = (rotor speed, tower-top displacement, its
velocity, pitch, generator torque / rated torque, integral of the rotor speed) and the inputs
u = (pitch, generator torque / rated torque),

    J domega/dt   = T_omega omega + T_beta beta - T_V v - G T_rated t
    m dv/dt       = F_omega omega + F_beta beta - F_V v - d v - k s,        ds/dt = v
    dbeta/dt      = (u_1 - beta) / tau_beta,         dt/dt = (u_2 - t) / tau_t
    dz/dt         = omega

where T_x and F_x are the derivatives of rotor torque and thrust, and a tower top that moves
downwind takes wind off the rotor.  An actuator whose time constant is zero is no state: its input
stands where its state stood, and the state's weight goes to the input.  The gain u = -K x
minimises the integral of x'Qx + u'Ru: K = R^-1 B'S with A'S + SA - S B R^-1 B'S + Q = 0.  The
weights follow equation (13) of the paper,

    Q = diag(1/delta_f^2, 0, c, 1/beta_max^2, 0, q),      R = diag(r, 0.1),
    q = min(0.1, 0.015 (V - 3) + 0.01),    r = min(1, max(0.1, 1 - 0.18 (V - 9))),

V in m/s, c the weight on the tower-top velocity in m/s.  There Q is printed for seven states, with
the pitch rate, and its third entry is not legible; delta_f and the units of the others are not
stated.  Here the pitch actuator is of first order, and the weights count rotor speed in rpm, pitch
in degrees and torque in per cent of rated, with delta_f = 1 rpm.  In these units c from 0 to 0.3
takes load off the tower at little cost in power, as in the paper; with radians and shares of the
rated torque pitch is so cheap that the tower loop, which knows nothing of the blades' own motion,
was unstable on the dynamic turbine, on the IEA 3.4 MW from c = 0.03, on the NREL 5 MW from 0.1.

In operation the rotor speed, the tower top, pitch and torque are measured; the gains and the
operating point are interpolated over the estimated wind speed.  Rotor speed and wind speed pass a
low pass each: both hold the rotor's own swinging at the blades' collective edge mode, which
actuators that follow at once would feed.  Commands keep range and rate, and the integral stands
still while both commands are out of range and it would push both further.

Source: J. Iori, C. Bottasso, M. McWilliam, "A sensitivity-based estimation method for
investigating control co-design relevance", 2024, section 3.2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.control.parameters import LinearQuadraticParameters, table
from pitchopt.errors import ComputationError, InputError

__all__ = ["LinearQuadratic", "OperatingDerivatives", "QuadraticWeights"]

_RPM = 30.0 / math.pi
_DEGREES = 180.0 / math.pi
_PER_CENT = 100.0

_POINT_FIELDS = (
    "wind_speed",
    "rotor_speed",
    "pitch",
    "generator_torque",
    "tower_displacement",
    "torque_by_speed",
    "torque_by_pitch",
    "torque_by_wind",
    "thrust_by_speed",
    "thrust_by_pitch",
    "thrust_by_wind",
)


@dataclass(frozen=True, kw_only=True, eq=False)
class OperatingDerivatives:
    """Steady operating points over the wind speed and the turbine's derivatives there.

    Parameters
    ----------
    wind_speed : array_like (W,)
        Ascending, two or more [m/s].
    rotor_speed, pitch, generator_torque, tower_displacement : array_like (W,)
        [rad/s], [rad], [N m] on the high-speed side, [m] downwind.
    torque_by_speed, torque_by_pitch, torque_by_wind : array_like (W,)
        Derivatives of the rotor torque [N m s/rad], [N m/rad], [N s].
    thrust_by_speed, thrust_by_pitch, thrust_by_wind : array_like (W,)
        Derivatives of the thrust [N s/rad], [N/rad], [N s/m].
    inertia : float
        Rotor and generator about the low-speed shaft [kg m^2].
    gear_ratio : float
        [-].
    tower_mass, tower_stiffness, tower_damping : float
        Of the first fore-aft mode, per tower-top displacement [kg], [N/m], [N s/m].
    pitch_time, torque_time : float
        Time constants of pitch actuator and generator [s], those of the turbine that is steered;
        0 for one that follows at once.

    Raises
    ------
    InputError
        If a number or a length is out of range.
    """

    wind_speed: FloatArray
    rotor_speed: FloatArray
    pitch: FloatArray
    generator_torque: FloatArray
    tower_displacement: FloatArray
    torque_by_speed: FloatArray
    torque_by_pitch: FloatArray
    torque_by_wind: FloatArray
    thrust_by_speed: FloatArray
    thrust_by_pitch: FloatArray
    thrust_by_wind: FloatArray
    inertia: float
    gear_ratio: float
    tower_mass: float
    tower_stiffness: float
    tower_damping: float
    pitch_time: float
    torque_time: float

    def __post_init__(self) -> None:
        wind = finite_array("wind_speed", self.wind_speed)
        if wind.size < 2 or np.any(np.diff(wind) <= 0.0):
            raise InputError(f"wind_speed: got {wind.size} values, expected two or more, ascending")
        for name in _POINT_FIELDS:
            array = finite_array(name, getattr(self, name), shape=wind.shape)
            object.__setattr__(self, name, array)
        if float(np.max(self.generator_torque)) <= 0.0:
            raise InputError("generator_torque: got none above 0 N m, expected a rated torque")
        for name in ("inertia", "gear_ratio", "tower_mass", "tower_stiffness"):
            finite_number(name, getattr(self, name), above=0.0)
        for name in ("tower_damping", "pitch_time", "torque_time"):
            finite_number(name, getattr(self, name), at_least=0.0)

    @property
    def rated_torque(self) -> float:
        """Largest generator torque of the points [N m]."""
        return float(np.max(self.generator_torque))

    @property
    def states(self) -> list[int]:
        """Which of the six states there are; an actuator that follows at once has none."""
        lags = {3: self.pitch_time, 4: self.torque_time}
        return [state for state in range(6) if lags.get(state, 1.0) > 0.0]

    def linear_model(self, point: int) -> tuple[FloatArray, FloatArray]:
        """A (n, n) and B (n, 2) of dx/dt = A x + B u at a point, n the number of `states`."""
        j, m = self.inertia, self.tower_mass
        a, b = np.zeros((6, 6)), np.zeros((6, 2))
        a[0, 0] = self.torque_by_speed[point] / j
        a[0, 2] = -self.torque_by_wind[point] / j
        a[0, 3] = self.torque_by_pitch[point] / j
        a[0, 4] = -self.gear_ratio * self.rated_torque / j
        a[1, 2] = 1.0
        a[2, 0] = self.thrust_by_speed[point] / m
        a[2, 1] = -self.tower_stiffness / m
        a[2, 2] = -(self.tower_damping + self.thrust_by_wind[point]) / m
        a[2, 3] = self.thrust_by_pitch[point] / m
        a[5, 0] = 1.0
        for k, lag in enumerate((self.pitch_time, self.torque_time)):
            if lag > 0.0:
                a[3 + k, 3 + k], b[3 + k, k] = -1.0 / lag, 1.0 / lag
            else:
                b[:, k] = a[:, 3 + k]
        return a[np.ix_(self.states, self.states)], b[self.states]

    def weights(self, point: int, weights: QuadraticWeights) -> tuple[FloatArray, FloatArray]:
        """Q (n, n) and R (2, 2) at a point for its `states`."""
        q, r = weights.matrices(float(self.wind_speed[point]))
        for k, lag in enumerate((self.pitch_time, self.torque_time)):
            if lag == 0.0:
                r[k, k] += q[3 + k, 3 + k]
        return q[np.ix_(self.states, self.states)], r


@dataclass(frozen=True, kw_only=True)
class QuadraticWeights:
    """Weights of equation (13).

    Parameters
    ----------
    tower_velocity : float, optional
        c [s^2/m^2], 0 to 0.3 in the paper.
    largest_pitch : float
        beta_max, highest pitch of the operating points [rad].
    speed_deviation : float, optional
        delta_f [rad/s], 1 rpm.

    Raises
    ------
    InputError
        If a number is out of range.
    """

    largest_pitch: float
    tower_velocity: float = 0.0
    speed_deviation: float = 1.0 / _RPM

    def __post_init__(self) -> None:
        finite_number("largest_pitch", self.largest_pitch, above=0.0)
        finite_number("tower_velocity", self.tower_velocity, at_least=0.0)
        finite_number("speed_deviation", self.speed_deviation, above=0.0)

    def matrices(self, wind_speed: float) -> tuple[FloatArray, FloatArray]:
        """Q (6, 6) and R (2, 2) at a wind speed of 3 m/s or more.

        For states and inputs in rad/s, m, m/s, rad and shares of the rated torque.

        Raises
        ------
        InputError
            At less than 3 m/s, where the schedule of q soon leaves the positive numbers.
        """
        v = finite_number("wind_speed", wind_speed, at_least=3.0)
        q = min(0.1, 0.015 * (v - 3.0) + 0.01)
        r = min(1.0, max(0.1, 1.0 - 0.18 * (v - 9.0)))
        states = [
            1.0 / self.speed_deviation**2,
            0.0,
            self.tower_velocity,
            1.0 / self.largest_pitch**2,
            0.0,
            q * _RPM**2,
        ]
        return np.diag(states), np.diag([r * _DEGREES**2, 0.1 * _PER_CENT**2])


@dataclass(frozen=True, kw_only=True, eq=False)
class LinearQuadratic:
    """Scheduled gains and operating points; takes the place of a `PitchRegulator`.

    Parameters
    ----------
    wind_speed : array_like (W,)
        Ascending, two or more [m/s].
    gains : array_like (W, 2, 6)
        K of pitch [rad] and generator torque [shares of the rated torque].
    reference : array_like (W, 4)
        Rotor speed [rad/s], tower-top displacement [m], pitch [rad] and generator torque [N m].
    rated_torque : float
        [N m].
    pitch_time, torque_time : float
        Time constants of the actuators that the gains are for [s].
    schedule_time : float, optional
        Time constant of the low pass on the wind speed that schedules [s].

    Raises
    ------
    InputError
        If a number or a shape is out of range.
    """

    wind_speed: FloatArray
    gains: FloatArray
    reference: FloatArray
    rated_torque: float
    pitch_time: float
    torque_time: float
    schedule_time: float = 3.0

    def __post_init__(self) -> None:
        wind = finite_array("wind_speed", self.wind_speed)
        if wind.size < 2 or np.any(np.diff(wind) <= 0.0):
            raise InputError(f"wind_speed: got {wind.size} values, expected two or more, ascending")
        object.__setattr__(self, "wind_speed", wind)
        gains = finite_array("gains", self.gains, shape=(wind.size, 2, 6))
        object.__setattr__(self, "gains", gains)
        reference = finite_array("reference", self.reference, shape=(wind.size, 4))
        object.__setattr__(self, "reference", reference)
        finite_number("rated_torque", self.rated_torque, above=0.0)
        finite_number("pitch_time", self.pitch_time, at_least=0.0)
        finite_number("torque_time", self.torque_time, at_least=0.0)
        finite_number("schedule_time", self.schedule_time, above=0.0)

    @classmethod
    def designed(cls, points: OperatingDerivatives, weights: QuadraticWeights) -> LinearQuadratic:
        """Regulator with the gains of every operating point.

        Raises
        ------
        ComputationError
            If a Riccati equation has no stabilising solution.
        """
        from scipy.linalg import LinAlgError, solve_continuous_are

        gains = np.zeros((points.wind_speed.size, 2, 6))
        for point, wind in enumerate(points.wind_speed):
            a, b = points.linear_model(point)
            q, r = points.weights(point, weights)
            try:
                riccati = solve_continuous_are(a, b, q, r)
            except LinAlgError as error:
                raise ComputationError(
                    f"the Riccati equation at {wind} m/s has no stabilising solution; check that "
                    "pitch or torque moves the rotor there"
                ) from error
            gains[point][:, points.states] = np.linalg.solve(r, b.T @ riccati)
        columns = (
            points.rotor_speed,
            points.tower_displacement,
            points.pitch,
            points.generator_torque,
        )
        return cls(
            wind_speed=points.wind_speed,
            gains=gains,
            reference=np.stack(columns, axis=1),
            rated_torque=points.rated_torque,
            pitch_time=points.pitch_time,
            torque_time=points.torque_time,
        )

    def parameters(self, step: float) -> LinearQuadraticParameters:
        """Numbers for the compiled regulator, called every `step` seconds.

        Raises
        ------
        InputError
            If the step is too long for the feedback of an actuator's own state.
        """
        for k, (name, lag) in enumerate(
            (("pitch_time", self.pitch_time), ("torque_time", self.torque_time))
        ):
            if lag == 0.0:
                continue
            # sampled, the actuator's own loop turns by 1 - (1 - exp(-step/lag)) (1 + K) a step
            fastest = 1.0 + float(np.max(self.gains[:, k, 3 + k]))
            if -math.expm1(-step / lag) * fastest > 1.0:
                longest = -lag * math.log1p(-1.0 / fastest)
                raise InputError(
                    f"step: got {step} s, expected at most {longest:.3g} s for a regulator "
                    f"designed for a {name} of {lag} s; use a shorter step, or 0 for an actuator "
                    "that follows at once"
                )
        return LinearQuadraticParameters(
            on=1,
            keep=math.exp(-step / self.schedule_time),
            wind=table(self.wind_speed),
            gains=table(self.gains),
            reference=table(self.reference),
            torque_scale=float(self.rated_torque),
        )
