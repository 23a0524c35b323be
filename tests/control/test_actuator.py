"""Actuators: closed-form step answers whatever the step, limits, bad input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from pitchopt.control import GeneratorLag, PitchActuator
from pitchopt.control.actuator_kernels import generator_torque, pitch_actuator
from pitchopt.errors import InputError

KINDS: list[dict[str, float]] = [
    {},
    {"time_constant": 0.4},
    {"frequency": 6.0, "damping": 0.7},
    {"frequency": 6.0, "damping": 1.0},
    {"frequency": 6.0, "damping": 1.8},
]


def actuator(rate: float = 1e3, **kind: float) -> PitchActuator:
    return PitchActuator(lowest=-0.1, highest=1.5, rate=rate, **kind)


def march(
    one: PitchActuator, step: float, commands: Any, position: float = 0.0, velocity: float = 0.0
) -> Any:
    p, rows = one.parameters(step), []
    for command in commands:
        position, velocity = pitch_actuator(p, position, velocity, command)
        rows.append((position, velocity))
    return np.array(rows)


class TestStepAnswer:
    @pytest.mark.parametrize("step", [0.01, 0.3])
    def test_first_order(self, step: float) -> None:
        times = step * np.arange(1, 21)
        got = march(actuator(time_constant=0.4), step, np.ones(20))
        assert np.allclose(got[:, 0], 1 - np.exp(-times / 0.4), rtol=0, atol=1e-13)
        assert np.allclose(got[:, 1], np.exp(-times / 0.4) / 0.4, rtol=0, atol=1e-12)

    @pytest.mark.parametrize("step", [0.01, 0.3])
    @pytest.mark.parametrize("zeta", [0.7, 1.0, 1.8])
    def test_second_order(self, step: float, zeta: float) -> None:
        omega, times = 6.0, step * np.arange(1, 21)
        got = march(actuator(frequency=omega, damping=zeta), step, 0.5 * np.ones(20))
        root = np.sqrt(complex(zeta**2 - 1)) if zeta != 1.0 else 1e-5
        fast, slow = (-omega * (zeta + sign * root) for sign in (1, -1))
        answer = 1 + (fast * np.exp(slow * times) - slow * np.exp(fast * times)) / (slow - fast)
        assert np.allclose(got[:, 0], 0.5 * answer.real, rtol=0, atol=1e-9)

    def test_immediate(self) -> None:
        got = march(actuator(), 0.01, [0.5, 0.4])
        assert np.allclose(got, [[0.5, 50.0], [0.4, -10.0]])

    @pytest.mark.parametrize("step", [0.01, 0.4])
    def test_first_order_at_its_rate_has_a_closed_form(self, step: float) -> None:
        # 0.2 rad/s until the distance is 0.2 * 0.4 rad, an exponential from there
        count = round(8.0 / step)
        got = march(actuator(rate=0.2, time_constant=0.4), step, np.ones(count))
        times = step * np.arange(1, count + 1)
        bend = (1.0 - 0.08) / 0.2
        exact = np.where(
            times < bend, 0.2 * times, 1 - 0.08 * np.exp(-np.maximum(times - bend, 0.0) / 0.4)
        )
        assert np.allclose(got[:, 0], exact, rtol=0, atol=1e-12)

    def test_second_order_at_its_rate_converges_to_the_limited_motion(self) -> None:
        omega, zeta, rate = 6.0, 0.7, 0.3

        def motion(_: float, y: Any) -> Any:
            push = omega**2 * (1.0 - y[0]) - 2 * zeta * omega * y[1]
            held = (y[1] >= rate and push > 0) or (y[1] <= -rate and push < 0)
            return [np.clip(y[1], -rate, rate), 0.0 if held else push]

        times = np.linspace(0.5, 6.0, 12)
        exact = solve_ivp(motion, (0, 6), [0, 0], t_eval=times, max_step=1e-3, rtol=1e-8).y[0]
        errors = []
        for step in (0.02, 0.01, 0.005):
            got = march(
                actuator(rate=rate, frequency=omega, damping=zeta), step, np.ones(round(6 / step))
            )
            at = np.rint(times / step).astype(int) - 1
            errors.append(np.max(np.abs(got[at, 0] - exact)))
        assert errors[0] < 0.01 and errors[2] < 0.5 * errors[0]


commands = st.lists(st.floats(-10.0, 10.0), min_size=1, max_size=30)


@given(
    wanted=commands,
    kind=st.sampled_from(KINDS),
    rate=st.floats(0.01, 5.0),
    step=st.floats(0.001, 0.5),
    position=st.floats(-0.1, 1.5),
)
def test_range_and_rate_always_hold(
    wanted: list[float], kind: dict[str, float], rate: float, step: float, position: float
) -> None:
    got = march(actuator(rate=rate, **kind), step, wanted, position)
    travel = np.diff(np.concatenate([[position], got[:, 0]]))
    assert np.all((got[:, 0] >= -0.1) & (got[:, 0] <= 1.5))
    assert np.all(np.abs(travel) <= rate * step * (1 + 1e-9) + 1e-15)
    assert np.all(np.abs(got[:, 1]) <= rate * (1 + 1e-9))


@given(
    kind=st.sampled_from(KINDS),
    rate=st.floats(0.1, 5.0),
    step=st.floats(0.01, 0.1),
    target=st.floats(-0.1, 1.5),
    position=st.floats(-0.1, 1.5),
)
def test_a_command_that_stands_is_reached(
    kind: dict[str, float], rate: float, step: float, target: float, position: float
) -> None:
    got = march(actuator(rate=rate, **kind), step, np.full(round(40.0 / step), target), position)
    assert np.isclose(got[-1, 0], target, rtol=0, atol=1e-6)
    assert abs(got[-1, 1]) < 1e-5


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_command_that_is_no_number_leaves_the_blade(kind: dict[str, float], bad: float) -> None:
    assert np.array_equal(march(actuator(**kind), 0.01, [bad], 0.3), [[0.3, 0.0]])


def test_generator_lag() -> None:
    keep = GeneratorLag(time_constant=0.1).keep(0.02)
    torque, rows = 0.0, []
    for _ in range(20):
        torque = generator_torque(keep, torque, 4e4)
        rows.append(torque)
    assert np.allclose(rows, 4e4 * (1 - np.exp(-0.2 * np.arange(1, 21))), rtol=1e-12)
    assert GeneratorLag().keep(0.02) == 0.0 and generator_torque(0.0, 5.0, 7.0) == 7.0


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PitchActuator(lowest=0.0, highest=0.0, rate=1.0), "highest"),
        (lambda: PitchActuator(lowest=0.0, highest=1.0, rate=0.0), "rate"),
        (lambda: actuator(time_constant=0.0), "time_constant"),
        (lambda: actuator(frequency=1.0), "frequency, damping: got 1.0 and None"),
        (lambda: actuator(frequency=0.0, damping=0.7), "frequency: got 0.0"),
        (lambda: actuator(frequency=1.0, damping=0.0), "damping: got 0.0"),
        (lambda: actuator(frequency=1.0, damping=0.7, time_constant=0.1), "beside frequency"),
        (lambda: actuator().parameters(0.0), "step"),
        (lambda: GeneratorLag(time_constant=-1.0), "time_constant"),
        (lambda: GeneratorLag().keep(-1.0), "step"),
    ],
)
def test_bad_input(make: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()
