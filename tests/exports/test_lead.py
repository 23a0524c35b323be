"""Commands that lead an actuator: closed form, the actuator itself, limits, bad input."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lsim

from pitchopt.errors import InputError
from pitchopt.exports import ActuatorLag, harmonics, led_command, truncated
from pitchopt.exports.harmonics import Harmonics
from pitchopt.exports.lead import harmonics_within

OMEGA = 1.267
FIRST = ActuatorLag(time_constant=0.4)
SECOND = ActuatorLag(frequency=6.0, damping=0.8)


def stations(count):
    return 2 * np.pi * np.arange(count) / count


def rough(count, seed=0):
    return harmonics(stations(count), 0.1 + 0.01 * np.random.default_rng(seed).normal(size=count))


@pytest.mark.parametrize("count", [3, 24, 25, 72])
@pytest.mark.parametrize("lag", [FIRST, SECOND], ids=["first", "second"])
def test_every_harmonic_carries_the_inverse_of_the_actuator(count, lag):
    series = rough(count)
    led = led_command(series, lag, OMEGA)
    behind = (led.cosine - 1j * led.sine) * lag.answer(OMEGA * np.arange(led.cosine.size))
    assert np.abs(behind - (series.cosine - 1j * series.sine)).max() < 1e-15
    assert led.mean == series.mean


def test_first_order_by_hand():
    led = led_command(Harmonics(cosine=[0.2, 0.03], sine=[0.0, 0.0]), FIRST, OMEGA)
    # beta + tau dbeta/dt of 0.03 cos(psi), psi = omega t
    assert led.cosine == pytest.approx([0.2, 0.03])
    assert led.sine == pytest.approx([0.0, -0.03 * 0.4 * OMEGA])


@pytest.mark.parametrize(
    ("lag", "system"),
    [
        (FIRST, ([1.0], [0.4, 1.0])),
        (SECOND, ([36.0], [1.0, 2 * 0.8 * 6.0, 36.0])),
    ],
    ids=["first", "second"],
)
def test_an_actuator_that_gets_the_command_moves_as_the_profile_says(lag, system):
    series = truncated(rough(24), 5)
    led = led_command(series, lag, OMEGA)
    time = np.arange(0.0, 30.0, 1e-3)
    blade = lsim(system, led(OMEGA * time) - led.mean, time)[1] + led.mean
    unled = lsim(system, series(OMEGA * time) - led.mean, time)[1] + led.mean
    wanted = series(OMEGA * time)
    late = time > 15.0
    assert np.abs(blade - wanted)[late].max() < 1e-6
    assert np.abs(unled - wanted)[late].max() > 5e-3


def test_phase_alone_leaves_amplitudes():
    series = rough(24)
    lag = ActuatorLag(time_constant=0.4, amplitude=False)
    led = led_command(series, lag, OMEGA)
    assert led.amplitude[1:-1] == pytest.approx(series.amplitude[1:-1])
    n = np.arange(1, 12)
    turned = np.angle((led.cosine - 1j * led.sine) / (series.cosine - 1j * series.sine))[1:12]
    assert turned == pytest.approx(np.arctan(n * 0.4 * OMEGA))


def test_a_constant_profile_needs_no_lead():
    series = harmonics([0.0], [0.1])
    assert led_command(series, FIRST, OMEGA) is series


def test_number_of_harmonics_within_limits():
    series = Harmonics(cosine=[0.2, 0.02, 0.0, 0.01], sine=np.zeros(4))
    first = 0.02 * OMEGA * np.hypot(1, 0.4 * OMEGA)  # rate of the led first harmonic
    third = 0.03 * OMEGA * np.hypot(1, 3 * 0.4 * OMEGA)
    assert harmonics_within(series, FIRST, OMEGA, rate=first + third + 1e-9) == 3
    assert harmonics_within(series, FIRST, OMEGA, rate=first * 1.01) == 2
    assert harmonics_within(series, FIRST, OMEGA, rate=first * 0.9) == 0
    assert harmonics_within(series, FIRST, OMEGA, rate=9.0, highest=0.2 + 0.0225) == 2
    assert harmonics_within(series, FIRST, OMEGA, rate=9.0, lowest=0.199) == 0


def test_truncated_keeps_the_first():
    series = rough(24)
    assert truncated(series, None) is series
    assert truncated(series, 12).cosine == pytest.approx(series.cosine)
    assert truncated(series, 3).sine == pytest.approx(series.sine[:4])


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({}, "time_constant"),
        ({"time_constant": 0.4, "frequency": 5.0, "damping": 0.7}, "time_constant"),
        ({"frequency": 5.0}, "frequency, damping"),
        ({"damping": 0.7}, "frequency, damping"),
        ({"time_constant": 0.0}, "time_constant"),
        ({"time_constant": np.nan}, "time_constant"),
        ({"frequency": -1.0, "damping": 0.7}, "frequency"),
        ({"frequency": 1.0, "damping": 0.0}, "damping"),
    ],
)
def test_bad_actuators(given, field):
    with pytest.raises(InputError, match=f"^{field}"):
        ActuatorLag(**given)


@pytest.mark.parametrize("kept", [0, 13, 2.5, -1])
def test_bad_numbers_of_harmonics(kept):
    with pytest.raises(InputError, match=r"^keep_harmonics"):
        truncated(rough(24), kept)


def test_bad_rotor_speed():
    with pytest.raises(InputError, match=r"^rotor_speed"):
        led_command(rough(24), FIRST, 0.0)
