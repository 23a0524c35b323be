"""Controllers from a turbine's own steady operation, on the turbine itself."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from pitchopt.control import IndividualPitch, PitchRegulator, TurbineController
from pitchopt.errors import InputError
from pitchopt.sim import (
    DynamicTurbine,
    Operation,
    average,
    simulate,
    simulate_many,
    statistics,
)
from pitchopt.turbines import load_turbine, names
from windfield import PowerLaw, StaticField, TurbulentField, kaimal_box


@pytest.fixture(scope="module")
def operation(dynamic) -> Operation:
    return Operation(dynamic)


@pytest.fixture(scope="module")
def turbulent(nrel):
    def fields(speed: float, seeds: int) -> list[TurbulentField]:
        mean = StaticField(speed=speed, hub_height=90.0, vertical=PowerLaw(exponent=0.2))
        return [
            TurbulentField(
                mean=mean,
                box=kaimal_box(
                    speed, 180.0, 0.2, hub_height=90.0, width=144.0, points=(9, 9), seed=seed
                ),
            )
            for seed in range(seeds)
        ]

    return fields


def test_gains_of_the_nrel_5mw(operation) -> None:
    """From our own sensitivities, near those of the report (Kp 0.0188 s, Ki 0.0081, 6.3 deg)."""
    regulator = operation.pitch_regulator(frequency=0.6, damping=0.7)
    assert isinstance(regulator, PitchRegulator)
    assert regulator.proportional == pytest.approx(0.01882681, rel=0.12)
    assert regulator.integral == pytest.approx(0.008068634, rel=0.12)
    assert math.degrees(1.0 / regulator.linear) == pytest.approx(6.302336, rel=0.15)
    law = operation.torque_law()
    assert law.gain == pytest.approx(2.332287, rel=0.03)


@pytest.mark.parametrize("key", names()[1:])
def test_every_turbine_holds_its_rated_power(key) -> None:
    turbine = load_turbine(key)
    dynamic = DynamicTurbine(turbine=turbine)
    operation = Operation(dynamic)
    mean = StaticField(
        speed=16.0, hub_height=turbine.rotor.hub_height, vertical=PowerLaw(exponent=0.2)
    )
    result = simulate(dynamic, mean, operation.baseline(), 150.0, start=operation.start(16.0))
    assert result.status == "finished"
    lines = statistics(result, skip=100.0, names=["GenPwr", "RotSpeed", "BldPitch1"])
    assert lines["GenPwr"].mean == pytest.approx(turbine.rated_power, rel=0.002)
    assert lines["RotSpeed"].mean == pytest.approx(turbine.rated_rotor_speed, rel=0.002)
    expected = float(operation.points([16.0]).pitch[0])
    assert lines["BldPitch1"].mean == pytest.approx(expected, abs=math.radians(1.0))


@pytest.mark.parametrize("speed", [8.0, 18.0])
def test_estimated_wind(operation, dynamic, turbulent, speed) -> None:
    """Against the mean relative wind over the rotor: exact to 3 % in the mean, and it follows."""

    class Watched:
        def __init__(self) -> None:
            self.inner = operation.controller(estimator=True)
            self.seen: list[float] = []

        def start(self, step, measured):
            self.inner.start(step, measured)

        def command(self, measured):
            command = self.inner.command(measured)
            self.seen.append(self.inner.wind_speed)
            return command

    watched = Watched()
    (field,) = turbulent(speed, 1)
    result = simulate(
        dynamic, field, watched, 170.0, start=operation.start(speed), interval=dynamic.step
    )
    seen = np.array(watched.seen)
    window = round(2.0 / dynamic.step)
    wind = np.convolve(result["RtVAvgxh"][1:], np.ones(window) / window, mode="same")
    part, lag = slice(2000, -200), round(1.0 / dynamic.step)
    seen, wind = seen[part], np.roll(wind, lag)[part]
    assert seen.mean() == pytest.approx(wind.mean(), rel=0.03)
    assert np.corrcoef(seen, wind)[0, 1] > 0.94
    assert (seen - wind).std() < 0.35 * wind.std()


def test_weight_on_the_tower_takes_load_off_it(operation, dynamic, turbulent) -> None:
    loads, powers = [], []
    for weight in (0.0, 0.1, 0.3):
        controller = operation.linear_quadratic(tower_velocity=weight)
        runs = simulate_many(
            dynamic, turbulent(18.0, 2), controller, 170.0, start=operation.start(18.0)
        )
        assert [run.status for run in runs] == ["finished", "finished"]
        mean = average([statistics(run, skip=50.0, names=["TwrBsMyt", "GenPwr"]) for run in runs])
        loads.append(mean["TwrBsMyt"].equivalent_load)
        powers.append(mean["GenPwr"].mean)
    assert loads[0] > 1.03 * loads[1] > 1.03 * loads[2]
    assert powers[2] == pytest.approx(powers[0], rel=1e-3)


def test_individual_pitch_takes_the_1p_load_away(operation, dynamic, nrel, controller) -> None:
    mean = StaticField(speed=16.0, hub_height=90.0, vertical=PowerLaw(exponent=0.3))
    swings = []
    for gain in (0.0, 4e-9):
        used: TurbineController = dataclasses.replace(
            controller, individual=IndividualPitch(gain=[gain], offset=[0.0])
        )
        result = simulate(dynamic, mean, used, 150.0, start=operation.start(16.0))
        rows = result.after(120.0)
        series = rows[:, result.place("RootMyc1")]
        azimuth = rows[:, result.place("Azimuth")]
        swings.append(2.0 * abs(np.mean((series - series.mean()) * np.exp(1j * azimuth))))
    assert swings[1] < 0.1 * swings[0]


def test_missing_operation_data(nrel) -> None:
    turbine = dataclasses.replace(nrel, optimal_tip_speed_ratio=None)
    with pytest.raises(InputError, match="best tip-speed ratio is not known"):
        Operation(DynamicTurbine(turbine=turbine))
