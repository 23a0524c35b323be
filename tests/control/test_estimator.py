"""The wind-speed estimator on a rigid rotor: exact when steady, its bandwidth, turbulence."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from control_factories import (
    DENSITY,
    GEAR,
    INERTIA,
    PITCH,
    RADIUS,
    TSR,
    measured,
    power_coefficient,
    run_rotor,
    table_estimator,
    torque,
    torque_of,
)
from scipy.optimize import brentq

from pitchopt.control import WindEstimator, nrel_5mw_baseline
from pitchopt.errors import InputError


def controller(bandwidth: float = 0.5, **changes: float) -> Any:
    return replace(nrel_5mw_baseline(), estimator=table_estimator(bandwidth, **changes))


def test_torque_is_that_of_the_table() -> None:
    estimator = table_estimator()
    for i, j, wind in ((40, 10, 8.0), (60, 0, 11.0), (20, 40, 17.0)):
        omega = TSR[i] * wind / RADIUS
        cp = estimator.power_coefficient[i, j]
        power = 0.5 * DENSITY * np.pi * RADIUS**2 * wind**3 * cp
        got = estimator.torque(omega, float(estimator.pitch[j]), wind)
        assert np.isclose(got, power / omega, rtol=1e-12)
    # between the knots bilinear, beyond the edges held
    middle = estimator.torque(
        0.5 * (TSR[40] + TSR[41]) * 8.0 / RADIUS, float(np.mean(estimator.pitch[10:12])), 8.0
    )
    cp = np.mean(estimator.power_coefficient[40:42, 10:12])
    omega = 0.5 * (TSR[40] + TSR[41]) * 8.0 / RADIUS
    assert np.isclose(middle, 0.5 * DENSITY * np.pi * RADIUS**2 * 512.0 * cp / omega, rtol=1e-12)
    assert estimator.torque(1.2, -0.5, 9.0) == estimator.torque(1.2, 0.0, 9.0)


@pytest.mark.parametrize("wind", [6.0, 9.0, 12.0, 15.0, 18.0])
def test_the_start_is_exact_in_steady_operation(wind: float) -> None:
    one = controller()
    truth = torque_of(one.estimator)
    omega = min(8.0 * wind / RADIUS, 1.267)
    beta = 0.0
    if truth(omega, beta, wind) * omega > 5.3e6:
        beta = brentq(lambda b: truth(omega, b, wind) * omega - 5.3e6, 0.0, 0.5)
    held = truth(omega, beta, wind) / GEAR
    one.start(0.02, measured(rotor_speed=omega, pitch=beta, generator_torque=held))
    assert np.isclose(one.wind_speed, wind, rtol=1e-9)
    now = measured(rotor_speed=omega, pitch=beta, generator_torque=held)
    for _ in range(200):
        one.command(now)
    assert np.isclose(one.wind_speed, wind, rtol=1e-9)


@pytest.mark.parametrize(("held", "expected"), [(1e6, 20.0), (-1e6, 4.0)])
def test_the_start_without_a_steady_wind_takes_the_nearer_end(held: float, expected: float) -> None:
    one = controller(lowest=4.0, highest=20.0)
    truth = torque_of(one.estimator)
    assert truth(1.2, 0.0, 4.0) < truth(1.2, 0.0, 20.0) < 1e6 * GEAR
    one.start(0.02, measured(rotor_speed=1.2, pitch=0.0, generator_torque=held))
    assert one.wind_speed == expected


@pytest.mark.parametrize("bandwidth", [0.2, 0.5, 1.5])
@pytest.mark.parametrize("error", [-0.4, 0.4])
def test_a_wrong_estimate_decays_with_the_bandwidth(bandwidth: float, error: float) -> None:
    one = controller(bandwidth)
    truth = torque_of(one.estimator)
    held = truth(1.2, 0.0, 11.0) / GEAR
    now = measured(rotor_speed=1.2, pitch=0.0, generator_torque=held)
    step = 1e-3
    one.start(step, now)
    one._run.memory[8] += error
    times = np.arange(1, 4000) * step
    errors = []
    for _ in times:
        one.command(now)
        errors.append(one.wind_speed - 11.0)
    expected = error * np.exp(-bandwidth * times)
    # the torque's slope changes by some per cent within 0.4 m/s
    assert np.max(np.abs(np.array(errors) - expected)) < 0.06 * abs(error)
    assert np.all(np.diff(np.abs(errors)) < 0.0)


def rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def turbulent(seed: int, mean: float, deviation: float) -> Callable[[float], float]:
    """Ornstein-Uhlenbeck wind with the time scale of a rotor mean, sampled every 0.02 s."""
    rng = np.random.default_rng(seed)
    keep = math.exp(-0.02 / 15.0)
    values = [0.0]
    for push in rng.standard_normal(20000):
        values.append(keep * values[-1] + deviation * math.sqrt(1 - keep**2) * push)
    return lambda t: mean + values[round(t / 0.02)]


class TestInALoop:
    def test_a_step_is_followed(self) -> None:
        one = controller(1.0)
        run = run_rotor(
            one,
            lambda t: 14.0 if t < 40.0 else 16.0,
            duration=80.0,
            true_torque=torque_of(one.estimator),
        )
        late = run["time"] >= 40.0
        assert abs(run["estimate"][~late][-1] - 14.0) < 1e-3
        error = 16.0 - run["estimate"][late]
        assert np.min(error) > -0.01  # of first order, it does not overshoot
        # bandwidth (gamma/J) dT/dV by the chord between estimate and truth along the way
        truth, gain = torque_of(one.estimator), one.estimator.gain
        state = zip(
            run["rotor_speed"][late], run["pitch"][late], run["estimate"][late], strict=True
        )
        rates = [
            gain / INERTIA * (truth(w, b, 16.0) - truth(w, b, v)) / (16.0 - v)
            for w, b, v in list(state)[:250]
        ]
        expected = 2.0 * np.exp(-0.02 * np.concatenate([[0.0], np.cumsum(rates)]))[:250]
        assert expected[-1] < 0.3
        assert np.max(np.abs(error[:250] - expected)) < 0.04

    @pytest.mark.parametrize("mean", [8.0, 12.0, 18.0])
    def test_turbulence_is_followed_and_faster_with_more_bandwidth(self, mean: float) -> None:
        wind = turbulent(5, mean, 0.12 * mean)
        errors = []
        for bandwidth in (0.3, 1.0, 3.0):
            one = controller(bandwidth)
            run = run_rotor(
                one, wind, duration=150.0, true_torque=torque_of(one.estimator), rotor_speed=1.1
            )
            late = run["time"] > 30.0
            errors.append(rms((run["estimate"] - run["wind"])[late]) / np.std(run["wind"][late]))
        assert errors[0] > errors[1] > errors[2]
        assert errors[1] < 0.5 and errors[2] < 0.25

    def test_the_true_rotor_beside_its_table(self) -> None:
        run = run_rotor(controller(), lambda _: 15.0, duration=120.0, true_torque=torque)
        assert abs(run["estimate"][-1] - 15.0) < 0.1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"tsr": TSR[::-1]}, "tsr: got 105 values, expected two or more, ascending"),
        ({"tsr": TSR - 2.0}, "tsr: got -1.0"),
        ({"pitch": [0.1]}, "pitch"),
        ({"power_coefficient": np.zeros((3, 3))}, "power_coefficient: got shape"),
        ({"radius": 0.0}, "radius"),
        ({"air_density": np.nan}, "air_density"),
        ({"inertia": -1.0}, "inertia"),
        ({"gain": 0.0}, "gain"),
        ({"lowest": 0.0}, "lowest"),
        ({"highest": 1.0}, "highest"),
    ],
)
def test_bad_input(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(table_estimator(), **changes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"bandwidth": 0.0}, "bandwidth"),
        ({"wind_speed": 60.0}, "does not grow with the wind speed"),
    ],
)
def test_bad_tuning(changes: dict[str, float], message: str) -> None:
    numbers: dict[str, Any] = {
        "bandwidth": 0.5,
        "wind_speed": 11.0,
        "rotor_speed": 1.2,
        "at_pitch": 0.0,
        "tsr": TSR,
        "pitch": PITCH,
        # nothing is left of the power coefficient at low tip-speed ratios
        "power_coefficient": np.where(
            TSR[:, None] > 4.0, power_coefficient(TSR[:, None], PITCH), 0.0
        ),
        "radius": RADIUS,
        "air_density": DENSITY,
        "inertia": INERTIA,
        "gear_ratio": GEAR,
    }
    with pytest.raises(InputError, match=message):
        WindEstimator.tuned(**(numbers | changes))
