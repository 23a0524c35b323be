"""Energy of a year: closed forms, limits, quadrature, and the IEA 3.4 MW."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.sim import DynamicTurbine
from pitchopt.sim.operation import Operation
from pitchopt.studies.tower.energy import (
    YEAR,
    annual_energy,
    annual_energy_by_bins,
    mean_wind_at,
)
from pitchopt.turbines import load_turbine

GWH = 3.6e12
SPEEDS = np.arange(3.0, 26.0, 2.0)
POWER = 1e6 * np.array([0.1, 0.46, 1.25, 2.6, 3.3, *[3.37] * 7])


def _exceeded(speed: float, mean: float, shape: float) -> float:
    scale = mean / math.gamma(1.0 + 1.0 / shape)
    return math.exp(-((speed / scale) ** shape))


@given(mean=st.floats(2.0, 20.0), shape=st.floats(1.0, 4.0), low=st.floats(0.0, 6.0))
def test_constant_power(mean: float, shape: float, low: float) -> None:
    speeds = low + np.array([0.0, 1.0, 7.5, 20.0])
    expected = YEAR * 2e6 * (_exceeded(low, mean, shape) - _exceeded(low + 20.0, mean, shape))
    energy = annual_energy(speeds, [2e6] * 4, mean, shape=shape)
    assert float(energy) == pytest.approx(expected, rel=1e-12, abs=1e-14 * YEAR * 2e6)


@pytest.mark.parametrize("mean", [5.0, 7.5, 12.0])
def test_linear_power_in_rayleigh_wind(mean: float) -> None:
    """Mean of c v is c V, and over v1 to v2 it is c times the integral by parts."""
    c = 3e5
    whole = annual_energy([0.0, 3.0, 12.0 * mean], c * np.array([0.0, 3.0, 12.0 * mean]), mean)
    assert float(whole) == pytest.approx(YEAR * c * mean, rel=1e-12)
    scale = 2.0 * mean / math.sqrt(math.pi)
    low, high = 3.0, 25.0
    part = low * math.exp(-((low / scale) ** 2)) - high * math.exp(-((high / scale) ** 2))
    part += mean * (math.erf(high / scale) - math.erf(low / scale))
    energy = annual_energy(SPEEDS, c * SPEEDS, mean)
    assert float(energy) == pytest.approx(YEAR * c * part, rel=1e-12)


@pytest.mark.parametrize(("mean", "shape"), [(4.0, 2.0), (7.5, 2.0), (8.5, 1.7), (10.0, 3.0)])
def test_quadrature(mean: float, shape: float) -> None:
    curve = PchipInterpolator(SPEEDS, POWER)
    scale = mean / math.gamma(1.0 + 1.0 / shape)

    def integrand(v: float) -> float:
        density = shape / scale * (v / scale) ** (shape - 1.0) * math.exp(-((v / scale) ** shape))
        return float(curve(v)) * density

    expected = sum(
        quad(integrand, low, high, epsabs=0.0, epsrel=1e-12)[0]
        for low, high in itertools.pairwise(SPEEDS)
    )
    energy = annual_energy(SPEEDS, POWER, mean, shape=shape)
    assert float(energy) == pytest.approx(YEAR * expected, rel=1e-12)


def test_bins_by_hand() -> None:
    power = [1e6, 2e6, 3e6]
    edges = [_exceeded(v, 7.5, 2.0) for v in (3.0, 5.0, 7.0, 9.0)]
    expected = YEAR * sum(
        p * (low - high) for p, low, high in zip(power, edges[:-1], edges[1:], strict=True)
    )
    assert float(annual_energy_by_bins([4.0, 6.0, 8.0], power, 7.5)) == pytest.approx(expected)


def test_bins_meet_the_integral() -> None:
    """Midpoint rule: the difference falls with the square of the step."""
    differences = []
    for step in (0.5, 0.25):
        v = np.arange(3.0 + step / 2.0, 25.0, step)
        p = 2e5 * v
        scale = 15.0 / math.sqrt(math.pi)
        exact = 3.0 * math.exp(-((3.0 / scale) ** 2)) - 25.0 * math.exp(-((25.0 / scale) ** 2))
        exact += 7.5 * (math.erf(25.0 / scale) - math.erf(3.0 / scale))
        differences.append(float(annual_energy_by_bins(v, p, 7.5)) / (YEAR * 2e5 * exact) - 1.0)
    assert abs(differences[1]) < 1e-3
    assert differences[0] / differences[1] == pytest.approx(4.0, rel=0.05)


@given(factor=st.floats(0.1, 10.0), mean=st.floats(3.0, 15.0))
def test_homogeneous(factor: float, mean: float) -> None:
    for function in (annual_energy, annual_energy_by_bins):
        once = float(function(SPEEDS, POWER, mean))
        assert float(function(SPEEDS, factor * POWER, mean)) == pytest.approx(factor * once)
        # the unit of speed does not matter
        assert float(function(factor * SPEEDS, POWER, factor * mean)) == pytest.approx(once)


@given(power=st.lists(st.floats(0.0, 5e6), min_size=12, max_size=12), mean=st.floats(1.0, 30.0))
def test_within_what_the_largest_power_gives(power: list[float], mean: float) -> None:
    share = _exceeded(3.0, mean, 2.0) - _exceeded(25.0, mean, 2.0)
    energy = float(annual_energy(SPEEDS, power, mean))
    assert -1e-6 <= energy <= YEAR * max(power) * share * (1.0 + 1e-9) + 1e-6


def test_limits_and_losses() -> None:
    whole = annual_energy(SPEEDS, POWER, 7.5)
    assert float(annual_energy(SPEEDS, POWER, 0.1)) < 1e-200  # never reaches cut-in
    assert float(annual_energy(SPEEDS, POWER, 1e4)) < 1e-4 * float(whole)  # beyond cut-out
    reduced = annual_energy(SPEEDS, POWER, 7.5, availability=0.97, losses=0.1)
    assert float(reduced) == pytest.approx(0.97 * 0.9 * float(whole), rel=1e-12)
    assert float(annual_energy(SPEEDS, POWER, 7.5, losses=1.0)) == 0.0
    means = np.array([[6.0, 7.5], [8.5, 10.0]])
    for function in (annual_energy, annual_energy_by_bins):
        grid = function(SPEEDS, POWER, means)
        assert grid.shape == (2, 2)
        assert grid[0, 1] == pytest.approx(float(function(SPEEDS, POWER, 7.5)), rel=1e-14)
        assert np.all(np.diff(grid.ravel()) > 0.0)


def test_wind_profile() -> None:
    wind = mean_wind_at([110.0, 220.0], reference_height=110.0, reference_speed=7.5)
    assert wind == pytest.approx([7.5, 7.5 * 2.0**0.2])
    flat = mean_wind_at(300.0, reference_height=110.0, reference_speed=7.5, exponent=0.0)
    assert flat.shape == ()
    assert float(flat) == 7.5


@pytest.fixture(scope="module")
def steady_power() -> tuple[FloatArray, FloatArray]:
    """Electrical power of the IEA 3.4 MW in steady wind, 0.25 m/s apart."""
    operation = Operation(DynamicTurbine(turbine=load_turbine("iea-3.4-130")))
    speeds = np.linspace(3.0, 25.0, 89)
    return speeds, operation.points(speeds).power * operation.dynamic.efficiency


def test_two_metres_per_second_are_enough(steady_power: tuple[FloatArray, FloatArray]) -> None:
    """A curve with a sharp knee is the worst case; turbulence rounds it."""
    speeds, power = steady_power
    for mean in (7.5, 8.5):
        fine = float(annual_energy(speeds, power, mean))
        for function in (annual_energy, annual_energy_by_bins):
            coarse = float(function(speeds[::8], power[::8], mean))
            assert coarse == pytest.approx(fine, rel=6e-3)


def test_published_energy(steady_power: tuple[FloatArray, FloatArray]) -> None:
    """14.955 GWh lies between class III and class II; a hub 1.5 % higher brings 0.4 %."""
    speeds, power = steady_power
    third, second = annual_energy(speeds, power, [7.5, 8.5]) / GWH
    assert third < 14.955 < second
    wind = mean_wind_at([110.0, 111.6], reference_height=110.0, reference_speed=7.5)
    energy = annual_energy(speeds[::8], power[::8], wind)
    assert energy[1] / energy[0] == pytest.approx(15.014 / 14.955, abs=2e-4)


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"speeds": [3.0]}, "speeds"),
        ({"speeds": SPEEDS[::-1]}, "speeds"),
        ({"speeds": SPEEDS - 4.0}, "speeds"),
        ({"power": POWER[:-1]}, "power"),
        ({"power": np.where(POWER > 3e6, np.nan, POWER)}, "power"),
        ({"mean_wind_speed": 0.0}, "mean_wind_speed"),
        ({"mean_wind_speed": [7.5, math.inf]}, "mean_wind_speed"),
        ({"mean_wind_speed": [[7.5], [7.5, 8.5]]}, "mean_wind_speed"),
        ({"mean_wind_speed": "strong"}, "mean_wind_speed"),
        ({"shape": 0.9}, "shape"),
        ({"availability": 1.1}, "availability"),
        ({"losses": -0.1}, "losses"),
    ],
)
def test_bad_energy(change: dict[str, object], name: str) -> None:
    arguments = {"speeds": SPEEDS, "power": POWER, "mean_wind_speed": 7.5, **change}
    for function in (annual_energy, annual_energy_by_bins):
        with pytest.raises(InputError, match=name):
            function(**arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"height": [110.0, 0.0]}, "height"),
        ({"reference_height": -1.0}, "reference_height"),
        ({"reference_speed": 0.0}, "reference_speed"),
        ({"exponent": 1.5}, "exponent"),
    ],
)
def test_bad_profile(change: dict[str, object], name: str) -> None:
    arguments = {"height": 110.0, "reference_height": 110.0, "reference_speed": 7.5, **change}
    with pytest.raises(InputError, match=name):
        mean_wind_at(**arguments)  # type: ignore[arg-type]
