"""The linear quadratic regulator: Riccati equation, stability, tower damping, in operation."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from control_factories import (
    DENSITY,
    GEAR,
    INERTIA,
    RADIUS,
    RATED_SPEED,
    measured,
    pitches,
    run_rotor,
    table_estimator,
    torque,
    torque_of,
)
from scipy.linalg import solve_continuous_lyapunov
from scipy.optimize import brentq

from pitchopt.control import (
    GeneratorLag,
    LinearQuadratic,
    OperatingDerivatives,
    PitchActuator,
    QuadraticWeights,
    nrel_5mw_baseline,
)
from pitchopt.control import signals as s
from pitchopt.control.actuator_kernels import generator_torque, pitch_actuator
from pitchopt.errors import InputError

WINDS = np.arange(5.0, 25.0, 2.0)
RATED_POWER = 5.3e6
BEST_RATIO = 8.1


def thrust(omega: float, pitch: float, wind: float) -> float:
    """Made-up thrust [N] that falls with the pitch."""
    ct = 0.8 * np.exp(-4.0 * pitch) * min(1.0, omega * RADIUS / wind / 7.0)
    return float(0.5 * DENSITY * np.pi * RADIUS**2 * wind**2 * ct)


def surplus(pitch: float, omega: float, wind: float) -> float:
    """Power beyond the rated power [W]."""
    return torque(omega, pitch, wind) * omega - RATED_POWER


@cache
def points(pitch_time: float = 0.0, torque_time: float = 0.0) -> OperatingDerivatives:
    rows = []
    for wind in WINDS:
        omega, beta = min(BEST_RATIO * wind / RADIUS, RATED_SPEED), 0.0
        if torque(omega, beta, wind) * omega > RATED_POWER:
            beta = brentq(surplus, 0.0, 0.6, args=(omega, wind))
        at = np.array([omega, beta, wind])

        def slope(of: Any, k: int, at: Any = at) -> float:
            h = 1e-5 * np.eye(3)[k]
            return float((of(*(at + h)) - of(*(at - h))) / 2e-5)

        rows.append(
            [wind, omega, beta, torque(omega, beta, wind) / GEAR, thrust(omega, beta, wind) / 1.7e6]
            + [slope(of, k) for of in (torque, thrust) for k in range(3)]
        )
    columns = np.array(rows).T
    names = (
        "wind_speed",
        "rotor_speed",
        "pitch",
        "generator_torque",
        "tower_displacement",
        *(f"{of}_by_{x}" for of in ("torque", "thrust") for x in ("speed", "pitch", "wind")),
    )
    return OperatingDerivatives(
        **dict(zip(names, columns, strict=True)),
        inertia=INERTIA,
        gear_ratio=GEAR,
        tower_mass=4.3e5,
        tower_stiffness=1.7e6,
        tower_damping=1.7e4,
        pitch_time=pitch_time,
        torque_time=torque_time,
    )


def weights(c: float = 0.0) -> QuadraticWeights:
    return QuadraticWeights(tower_velocity=c, largest_pitch=float(np.max(points().pitch)))


@cache
def regulator(c: float = 0.0, lags: tuple[float, float] = (0.0, 0.0)) -> LinearQuadratic:
    return LinearQuadratic.designed(points(*lags), weights(c))


LAGS = [(0.0, 0.0), (0.3, 0.0), (0.3, 0.1)]


@pytest.mark.parametrize("k", [2, 6])
def test_the_linear_model_is_the_slope_of_the_equations_of_motion(k: int) -> None:
    of = points(0.3, 0.1)

    def motion(x: Any, u: Any) -> Any:
        omega, place, velocity, beta, share, _ = x
        wind = WINDS[k] - velocity  # a tower top that moves downwind feels less of it
        push = thrust(omega, beta, wind) - 1.7e6 * place - 1.7e4 * velocity
        return np.array(
            [
                (torque(omega, beta, wind) - GEAR * of.rated_torque * share) / INERTIA,
                velocity,
                push / 4.3e5,
                (u[0] - beta) / 0.3,
                (u[1] - share) / 0.1,
                omega - of.rotor_speed[k],
            ]
        )

    share = of.generator_torque[k] / of.rated_torque
    x = np.array([of.rotor_speed[k], of.tower_displacement[k], 0.0, of.pitch[k], share, 0.0])
    u = np.array([of.pitch[k], share])
    assert np.max(np.abs(motion(x, u))) < 1e-9
    a, b = of.linear_model(k)
    h = 1e-5
    for i, e in enumerate(h * np.eye(6)):
        slope = (motion(x + e, u) - motion(x - e, u)) / (2 * h)
        assert np.allclose(a[:, i], slope, rtol=1e-4, atol=1e-6)
    for i, e in enumerate(h * np.eye(2)):
        assert np.allclose(b[:, i], (motion(x, u + e) - motion(x, u - e)) / (2 * h), rtol=1e-6)


@pytest.mark.parametrize("c", [0.0, 0.03, 0.3])
@pytest.mark.parametrize("lags", LAGS)
def test_gains_solve_the_riccati_equation_and_stabilise(
    c: float, lags: tuple[float, float]
) -> None:
    of = points(*lags)
    for k in range(WINDS.size):
        a, b = of.linear_model(k)
        q, r = of.weights(k, weights(c))
        gain = regulator(c, lags).gains[k][:, of.states]
        closed = a - b @ gain
        assert np.max(np.linalg.eigvals(closed).real) < -0.01
        # cost of the closed loop by Lyapunov's equation: a Riccati solution is its own cost
        cost = solve_continuous_lyapunov(closed.T, -(q + gain.T @ r @ gain))
        assert np.allclose(np.linalg.solve(r, b.T @ cost), gain, rtol=1e-6, atol=1e-8)
        residual = a.T @ cost + cost @ a - cost @ b @ np.linalg.solve(r, b.T @ cost) + q
        assert np.max(np.abs(residual)) < 1e-7 * max(1.0, np.max(np.abs(a.T @ cost)))


@pytest.mark.parametrize("lags", LAGS)
def test_no_other_gain_costs_less(lags: tuple[float, float]) -> None:
    of = points(*lags)
    a, b = of.linear_model(6)
    q, r = of.weights(6, weights(0.1))
    gain = regulator(0.1, lags).gains[6][:, of.states]

    def cost(k: Any) -> float:
        return float(np.trace(solve_continuous_lyapunov((a - b @ k).T, -(q + k.T @ r @ k))))

    rng = np.random.default_rng(0)
    for _ in range(20):
        assert cost(gain * (1 + 0.02 * rng.standard_normal(gain.shape))) > cost(gain)


def test_short_lags_are_nearly_none() -> None:
    """With the pitch at once its weight is on the input: the limit of ever shorter lags."""
    ends = [
        np.sort_complex(
            np.linalg.eigvals(np.subtract(a, b @ regulator(0.1, lags).gains[6][:, of.states]))
        )[-4:]
        for lags in ((1e-3, 1e-3), (0.0, 0.0))
        for of in [points(*lags)]
        for a, b in [of.linear_model(6)]
    ]
    assert np.allclose(ends[0], ends[1], rtol=0.01)


def tower_damping(c: float, k: int, lags: tuple[float, float]) -> float:
    """Damping ratio of the mode nearest the tower's frequency."""
    of = points(*lags)
    a, b = of.linear_model(k)
    values = np.linalg.eigvals(a - b @ regulator(c, lags).gains[k][:, of.states])
    pairs = values[values.imag > 0.1]
    mode = pairs[np.argmin(np.abs(np.abs(pairs) - np.sqrt(1.7e6 / 4.3e5)))]
    return float(-mode.real / np.abs(mode))


@pytest.mark.parametrize("k", [5, 7, 9])
@pytest.mark.parametrize("lags", LAGS)
def test_weight_on_the_velocity_damps_the_tower(k: int, lags: tuple[float, float]) -> None:
    damping = [tower_damping(c, k, lags) for c in (0.0, 0.03, 0.1, 0.3)]
    assert np.all(np.diff(damping) > 0.0)
    assert damping[-1] > 1.25 * damping[0]


RPM, DEGREES = 30.0 / np.pi, 180.0 / np.pi  # in which the weights count


def test_schedules_of_the_weights() -> None:
    def parts(wind: float) -> tuple[float, float]:
        q, r = weights().matrices(wind)
        assert r[1, 1] == pytest.approx(0.1 * 100.0**2)
        return float(q[5, 5]) / RPM**2, float(r[0, 0]) / DEGREES**2

    assert np.allclose(parts(3.0), (0.01, 1.0))
    assert np.allclose(parts(9.0), (0.1, 1.0))
    assert np.allclose(parts(11.0), (0.1, 0.64))
    assert np.allclose(parts(25.0), (0.1, 0.1))
    q, _ = weights(0.2).matrices(12.0)
    assert np.allclose(
        np.diag(q), [RPM**2, 0.0, 0.2, 1 / np.max(points().pitch) ** 2, 0.0, 0.1 * RPM**2]
    )


class TestInOperation:
    def controller(self) -> Any:
        return replace(nrel_5mw_baseline(), pitch=regulator(), estimator=table_estimator(1.0))

    @pytest.mark.parametrize("integral", [-0.4, 0.1])
    def test_a_run_goes_on_without_a_bump(self, integral: float) -> None:
        """Commands of a law whose integral is not zero, taken over by one that must find it."""
        controller = self.controller()
        k = 7
        lqr = regulator()
        held = lqr.reference[k, 3] - lqr.rated_torque * lqr.gains[k, 1, 5] * integral
        beta = lqr.reference[k, 2] - lqr.gains[k, 0, 5] * integral
        omega, place = lqr.reference[k, :2]
        # the wind whose steady torque is what the generator holds is read off the table
        estimator = controller.estimator
        cp = estimator.power_coefficient * (
            GEAR * held / estimator.torque(omega, beta, float(WINDS[k]))
        )
        controller = replace(controller, estimator=replace(estimator, power_coefficient=cp))
        now = measured(rotor_speed=omega, pitch=beta, generator_torque=held, tower_x=place)
        controller.start(0.02, now)
        assert np.isclose(controller.wind_speed, WINDS[k], rtol=1e-9)
        assert np.isclose(controller._run.memory[1], integral, rtol=1e-6)
        command = controller.command(now)
        assert np.allclose(pitches(command), beta, rtol=1e-8)
        assert np.isclose(command[s.TORQUE], held, rtol=1e-8)

    @pytest.mark.parametrize("wind", [7.0, 10.0, 13.0, 16.3, 21.0])
    def test_steady_wind_ends_at_rated_speed_or_the_best_ratio(self, wind: float) -> None:
        controller = self.controller()
        run = run_rotor(
            controller,
            lambda _: wind,
            duration=600.0,
            rotor_speed=1.1,
            pitch=0.05,
            true_torque=torque_of(controller.estimator),
        )
        lqr = regulator()
        speed, beta, held = (
            np.interp(wind, WINDS, lqr.reference[:, column]) for column in (0, 2, 3)
        )
        assert np.isclose(run["estimate"][-1], wind, rtol=1e-6)
        assert np.isclose(run["rotor_speed"][-1], speed, rtol=2e-3)
        # between the points the straight lines are off the true operating point
        assert np.isclose(run["pitch"][-1], beta, atol=0.014)
        assert np.isclose(run["generator_torque"][-1], held, rtol=0.08)
        assert np.ptp(run["rotor_speed"][-500:]) < 1e-4

    def test_a_gust_is_held(self) -> None:
        run = run_rotor(
            self.controller(),
            lambda t: 16.0 + (3.0 if t > 60.0 else 0.0),
            duration=150.0,
            pitch=float(np.interp(16.0, WINDS, points().pitch)),
        )
        assert np.max(run["rotor_speed"][2500:]) < 1.1 * RATED_SPEED
        assert np.isclose(run["rotor_speed"][-1], RATED_SPEED, rtol=2e-3)

    def test_pitch_works_against_the_motion_of_the_tower(self) -> None:
        # thrust pushes downwind, and more pitch means less of it
        controller = replace(self.controller(), pitch=regulator(0.3))
        k = 6
        point = {
            "rotor_speed": float(points().rotor_speed[k]),
            "pitch": float(points().pitch[k]),
            "generator_torque": float(points().generator_torque[k]),
            "tower_x": float(points().tower_displacement[k]),
        }
        first = {}
        for velocity in (-0.2, 0.0, 0.2):
            controller.start(0.02, measured(**point))
            first[velocity] = pitches(controller.command(measured(**point, tower_vx=velocity)))[0]
        assert first[-0.2] < first[0.0] < first[0.2]

    def test_lagging_actuators_of_the_design(self) -> None:
        lags, step, wind = (0.3, 0.1), 0.02, 17.0
        controller = replace(self.controller(), pitch=regulator(0.0, lags))
        truth = torque_of(controller.estimator)
        limits = PitchActuator(lowest=0.0, highest=1.5, rate=0.2, time_constant=lags[0])
        actuator, keep = limits.parameters(step), GeneratorLag(time_constant=lags[1]).keep(step)
        omega, beta, speed, held = 1.2, 0.3, 0.0, 4e4
        controller.start(step, measured(rotor_speed=omega, pitch=beta, generator_torque=held))
        for _ in range(8000):
            now = measured(rotor_speed=omega, pitch=beta, generator_torque=held)
            command = controller.command(now)
            beta, speed = pitch_actuator(actuator, beta, speed, pitches(command)[0])
            held = generator_torque(keep, held, command[s.TORQUE])
            omega += step / INERTIA * (truth(omega, beta, wind) - GEAR * held)
        assert np.isclose(omega, RATED_SPEED, rtol=1e-3)
        assert abs(speed) < 1e-6
        assert np.isclose(beta, np.interp(wind, WINDS, points().pitch), atol=1e-3)

    def test_one_absurd_speed_does_not_leave_an_endless_integral(self) -> None:
        controller = self.controller()
        now = measured(rotor_speed=RATED_SPEED, pitch=0.2)
        controller.start(0.02, now)
        for sign in (1.0, -1.0):
            controller.command(measured(rotor_speed=sign * 1e11, pitch=0.2))
            k = controller._run.parameters.linear_quadratic
            place = np.interp(controller.wind_speed, WINDS, np.arange(WINDS.size))
            gains = [np.interp(place, np.arange(WINDS.size), k.gains[:, i, 5]) for i in (0, 1)]
            torques = controller.torque.largest_torque / k.torque_scale
            bound = max(np.radians(90.0) / abs(gains[0]), torques / abs(gains[1]))
            assert abs(controller._run.memory[1]) <= bound * (1 + 1e-9)

    def test_a_step_too_long_for_the_lag_is_refused(self) -> None:
        controller = replace(self.controller(), pitch=regulator(0.0, (0.05, 0.0)))
        gain = 1.0 + np.max(regulator(0.0, (0.05, 0.0)).gains[:, 0, 3])
        longest = -0.05 * np.log(1.0 - 1.0 / gain)
        controller.parameters(0.999 * longest)
        with pytest.raises(InputError, match=r"step: got .* pitch_time of 0\.05 s"):
            controller.parameters(1.001 * longest)

    def test_integral_stands_still_beyond_both_ranges(self) -> None:
        controller = self.controller()
        slow = measured(rotor_speed=0.3, pitch=0.0, generator_torque=0.0)
        controller.start(0.02, slow)
        for _ in range(2000):
            command = controller.command(slow)
        first = controller._run.memory[1]
        for _ in range(2000):
            command = controller.command(slow)
        assert command[s.TORQUE] == 0.0 and np.all(pitches(command) == 0.0)
        assert controller._run.memory[1] == first


def changed(**changes: Any) -> OperatingDerivatives:
    return replace(points(), **changes)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: changed(wind_speed=WINDS[::-1]), "wind_speed"),
        (lambda: changed(pitch=[0.1]), "pitch: got shape"),
        (lambda: changed(inertia=0.0), "inertia"),
        (lambda: changed(pitch_time=-0.1), "pitch_time"),
        (lambda: changed(tower_damping=-1.0), "tower_damping"),
        (lambda: changed(generator_torque=0.0 * WINDS), "generator_torque"),
        (lambda: QuadraticWeights(largest_pitch=0.0), "largest_pitch"),
        (lambda: QuadraticWeights(largest_pitch=0.4, tower_velocity=-0.1), "tower_velocity"),
        (lambda: QuadraticWeights(largest_pitch=0.4, speed_deviation=0.0), "speed_deviation"),
        (lambda: QuadraticWeights(largest_pitch=0.4).matrices(2.0), "wind_speed"),
        (lambda: replace(regulator(), gains=np.zeros((3, 2, 6))), "gains: got shape"),
        (lambda: replace(regulator(), reference=np.zeros((3, 4))), "reference: got shape"),
        (lambda: replace(regulator(), rated_torque=0.0), "rated_torque"),
        (lambda: replace(regulator(), wind_speed=[5.0]), "wind_speed"),
    ],
)
def test_bad_input(make: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()
