"""Gains from the regulator mode: the report's numbers, the closed loop, the fit, bad input."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from control_factories import GEAR, INERTIA, RATED_SPEED, measured, pitches
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.control import (
    PitchRange,
    PitchRegulator,
    TorqueLaw,
    fit_sensitivity,
    nrel_5mw_baseline,
)
from pitchopt.errors import InputError

# fit of NREL/TP-500-38060, section 7.2: -25.52e6 W/rad at zero pitch, doubled at 6.302336 deg
AT_ZERO, DOUBLES = -25.52e6, np.radians(6.302336)
ANGLES = np.radians(np.linspace(0.0, 23.0, 12))
SENSITIVITY = AT_ZERO * (1.0 + ANGLES / DOUBLES)


def tuned(**changes: Any) -> PitchRegulator:
    numbers: dict[str, Any] = {
        "frequency": 0.6,
        "damping": 0.7,
        "pitch": ANGLES,
        "sensitivity": SENSITIVITY,
        "rotor_speed": 12.1 * np.pi / 30,
        "inertia": INERTIA,
        "gear_ratio": GEAR,
    }
    return PitchRegulator.tuned(**(numbers | changes))


def test_numbers_of_the_report() -> None:
    regulator = tuned()
    assert np.isclose(regulator.proportional, 0.01882681, rtol=2e-4)
    assert np.isclose(regulator.integral, 0.008068634, rtol=2e-4)
    assert np.isclose(1.0 / regulator.linear, 0.1099965, rtol=1e-6)
    assert np.isclose(regulator.reference_speed, 122.9096, rtol=1e-6)


@given(
    frequency=st.floats(0.05, 2.0),
    damping=st.floats(0.1, 2.0),
    beta=st.floats(0.0, 0.4),
    power=st.sampled_from([0.0, 5.3e6]),
    curve=st.floats(-1.0, 3.0),
)
def test_the_linear_rotor_has_the_mode_asked_for(
    frequency: float, damping: float, beta: float, power: float, curve: float
) -> None:
    # J d omega/dt = (dP/dbeta) beta / Omega - G T_g, with T_g = P0 / omega_g if power is held
    sensitivity = SENSITIVITY + AT_ZERO * curve * ANGLES**2
    regulator = tuned(
        frequency=frequency,
        damping=damping,
        sensitivity=sensitivity,
        degree=2,
        constant_power=power,
    )
    speed = 12.1 * np.pi / 30
    slope = AT_ZERO * (1.0 + beta / DOUBLES + curve * beta**2) / speed
    proportional, integral = regulator.gains(beta)
    damper = -slope * GEAR * float(proportional) - power / speed**2
    assert np.isclose(damper, 2 * INERTIA * frequency * damping, rtol=1e-8)
    assert np.isclose(-slope * GEAR * float(integral), INERTIA * frequency**2, rtol=1e-8)


@pytest.mark.parametrize("beta", [0.02, 0.12, 0.35])
def test_the_compiled_loop_answers_as_the_mode_does(beta: float) -> None:
    frequency, damping, step = 0.6, 0.7, 2e-3
    speed = RATED_SPEED
    regulator = tuned(frequency=frequency, damping=damping, rotor_speed=speed)
    # nearly no filter, and schedule, range and rate out of the way
    fixed = replace(
        regulator,
        proportional=float(regulator.gains(beta)[0]),
        integral=float(regulator.gains(beta)[1]),
        linear=0.0,
    )
    controller = replace(
        nrel_5mw_baseline(),
        pitch=fixed,
        pitch_range=PitchRange(lowest=-1.0, highest=1.5, rate=100.0),
        speed_corner=1e4,
    )
    slope = AT_ZERO * (1.0 + beta / DOUBLES) / speed
    omega = start = 0.02
    controller.start(step, measured(rotor_speed=speed, pitch=beta))
    times = np.arange(0.0, 12.0, step)
    history = []
    for _ in times:
        history.append(omega)
        command = pitches(controller.command(measured(rotor_speed=speed + omega, pitch=beta)))
        omega += step / INERTIA * slope * (command[0] - beta)
    damped = frequency * np.sqrt(1 - damping**2)
    decay = np.exp(-damping * frequency * times)
    exact = (
        start
        * decay
        * (np.cos(damped * times) - damping * frequency / damped * np.sin(damped * times))
    )
    assert np.max(np.abs(np.array(history) - exact)) < 3e-3 * start


def test_pitch_saturates_without_winding_up() -> None:
    controller = nrel_5mw_baseline()
    step = 0.0125
    slow, fast = measured(rotor_speed=0.9, pitch=0.0), measured(rotor_speed=1.3, pitch=0.0)
    controller.start(step, slow)
    for _ in range(8000):
        assert np.all(pitches(controller.command(slow)) == 0.0)
    # pitch moves as soon as the filter passes the reference, and not a call later
    keep, filtered, calls = np.exp(-1.570796 * step), 0.9 * GEAR, 0
    while filtered <= 122.9096:
        filtered = (1 - keep) * 1.3 * GEAR + keep * filtered
        calls += 1
    commands = [pitches(controller.command(fast))[0] for _ in range(calls)]
    assert np.all(np.array(commands[:-1]) == 0.0) and commands[-1] > 0.0


def test_range_and_rate_hold() -> None:
    controller = replace(
        nrel_5mw_baseline(), pitch_range=PitchRange(lowest=0.05, highest=0.4, rate=0.1)
    )
    controller.start(0.01, measured(pitch=0.1))
    last = np.full(3, 0.1)
    for speed in (5.0, 0.1, 5.0):
        for _ in range(1000):
            now = pitches(controller.command(measured(rotor_speed=speed)))
            assert np.all(np.abs(now - last) <= 0.001 + 1e-15)
            assert np.all((now >= 0.05) & (now <= 0.4))
            last = now
        assert np.all(last == (0.4 if speed > 1.0 else 0.05))


class TestFit:
    def test_linear_is_least_squares(self) -> None:
        rng = np.random.default_rng(1)
        noisy = SENSITIVITY * (1 + 0.05 * rng.standard_normal(ANGLES.size))
        at_zero, linear, quadratic = fit_sensitivity(ANGLES, noisy)
        expected = np.linalg.lstsq(np.vander(ANGLES, 2), noisy, rcond=None)[0]
        assert np.allclose([at_zero * linear, at_zero], expected, rtol=1e-9)
        assert quadratic == 0.0

    def test_quadratic_is_exact_for_a_parabola(self) -> None:
        parabola = -2e7 * (1 + 7 * ANGLES - 3 * ANGLES**2)
        assert np.allclose(fit_sensitivity(ANGLES, parabola, degree=2), (-2e7, 7.0, -3.0))

    @pytest.mark.parametrize(
        ("pitch", "sensitivity", "degree", "message"),
        [
            ([0.1, 0.1], [-1.0, -1.0], 1, "different angles"),
            ([0.1, 0.2], [-1.0, -1.0], 2, "different angles"),
            ([0.1, 0.2], [-1.0, 1.0], 1, "not negative"),
            ([0.1, 0.2], [-1.0, -3.0], 1, "not negative"),
            ([0.1, 0.2], [-1.0], 1, "sensitivity: got shape"),
            ([0.1, 0.2], [-1.0, -1.9], 1, "would be 10 times as large"),
            ([0.1, 0.2], [-1.0, -1.0], 3, "degree"),
        ],
    )
    def test_bad_input(
        self, pitch: list[float], sensitivity: list[float], degree: int, message: str
    ) -> None:
        with pytest.raises(InputError, match=message):
            fit_sensitivity(pitch, sensitivity, degree=degree)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"frequency": 0.0}, "frequency"),
        ({"damping": -1.0}, "damping"),
        ({"rotor_speed": np.nan}, "rotor_speed"),
        ({"inertia": 0.0}, "inertia"),
        ({"gear_ratio": 0.0}, "gear_ratio"),
        ({"constant_power": -1.0}, "constant_power"),
    ],
)
def test_bad_tuning(changes: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        tuned(**changes)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ({"lowest": 0.2, "highest": 0.1, "rate": 0.1}, "highest"),
        ({"lowest": 0.0, "highest": 0.1, "rate": 0.0}, "rate"),
        ({"lowest": 0.0, "highest": 0.1, "rate": 0.1, "blade_lowest": 0.05}, "blade_lowest"),
        ({"lowest": 0.0, "highest": 0.1, "rate": 0.1, "blade_highest": 0.05}, "blade_highest"),
    ],
)
def test_bad_range(numbers: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        PitchRange(**numbers)


@pytest.mark.parametrize(("linear", "quadratic"), [(-1.0, 0.0), (-3.0, 2.0)])
def test_a_schedule_that_changes_sign_is_refused(linear: float, quadratic: float) -> None:
    regulator = PitchRegulator(
        proportional=0.02, integral=0.01, reference_speed=120.0, linear=linear, quadratic=quadratic
    )
    with pytest.raises(InputError, match="changed sign"):
        replace(nrel_5mw_baseline(), pitch=regulator)


def test_wrong_kind_of_part_is_named() -> None:
    baseline = nrel_5mw_baseline()
    with pytest.raises(InputError, match="torque: got PitchRegulator, expected TorqueLaw"):
        replace(baseline, torque=baseline.pitch)
    with pytest.raises(InputError, match="individual: got TorqueLaw, expected IndividualPitch or"):
        replace(baseline, individual=baseline.torque)
    assert isinstance(baseline.torque, TorqueLaw)
