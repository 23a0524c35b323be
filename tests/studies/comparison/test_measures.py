"""Measures of runs against closed forms, and cuts with their intervals."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from pitchopt.errors import InputError
from pitchopt.sim import DynamicTurbine, Simulation
from pitchopt.studies.comparison.measures import RunMeasures, cut, measure
from pitchopt.studies.tuning import PlantRun
from pitchopt.turbines import load_turbine

SPEED, AMPLITUDE, RATE = 1.2, math.radians(2.0), math.radians(8.0)


@pytest.fixture(scope="module")
def run():
    """A made-up run: pitch once a turn, loads that are sines."""
    channels = DynamicTurbine(turbine=load_turbine("nrel-5mw")).channels
    interval = 0.05
    turns = 20
    time = np.arange(0.0, turns * 2.0 * np.pi / SPEED + 30.0, interval)
    values = np.zeros((time.size, len(channels)))
    place = {channel.name: i for i, channel in enumerate(channels)}
    values[:, 0] = time
    values[:, place["RotSpeed"]] = SPEED
    values[:, place["GenPwr"]] = 5e6
    for k in (1, 2, 3):
        psi = SPEED * time + 2.0 * np.pi * (k - 1) / 3.0
        values[:, place[f"BldPitch{k}"]] = AMPLITUDE * np.cos(psi)
        values[:, place[f"RootMyc{k}"]] = 1e6 * k * np.sin(psi)
    values[:, place["LSSTipMys"]] = 3e5 * np.sin(3.0 * SPEED * time)
    simulation = Simulation(
        turbine="made up", channels=channels, values=values, status="finished", message="",
        diverged_at=None, interval=interval, step=0.025, duration=float(time[-1]), label="",
        error=np.zeros(1), evaluations=1.0, seconds=0.0,
    )  # fmt: skip
    return PlantRun(wind_speed=15.0, seed=7, skip=30.0, simulation=simulation)


def test_pitch_figures_of_a_sine(run):
    """Path 4 A a turn; mean rate 2 A omega / pi; largest A omega."""
    found = measure(run, RATE)
    assert found.travel == pytest.approx(4.0 * AMPLITUDE, rel=2e-3)
    assert found.rate_use == pytest.approx(2.0 * AMPLITUDE * SPEED / math.pi / RATE, rel=2e-3)
    assert found.rate_peak == pytest.approx(AMPLITUDE * SPEED / RATE, rel=2e-3)
    assert found.seed == 7


def test_loads_of_sines(run):
    """RMS amplitude / sqrt 2; n full cycles of range 2 A in T s: DEL = 2 A (n / T)^(1/m)."""
    found = measure(run, RATE)
    assert found.power == pytest.approx(5e6)
    assert found.rms["blade"] == pytest.approx(2e6 / math.sqrt(2.0), rel=2e-3)
    assert found.rms["tilt"] == pytest.approx(3e5 / math.sqrt(2.0), rel=2e-3)
    cycles = SPEED / (2.0 * math.pi)
    assert found.equivalent_load["blade"] == pytest.approx(4e6 * cycles**0.1, rel=5e-3)
    assert found.equivalent_load["tilt"] == pytest.approx(6e5 * (3.0 * cycles) ** 0.25, rel=2e-2)
    assert found.equivalent_load["torque"] == 0.0


def _made(seed: int, value: float) -> RunMeasures:
    loads = dict.fromkeys(("blade", "tower", "tilt", "yaw", "torque"), value)
    return RunMeasures(
        seed=seed, power=1.0, power_std=0.0, generator_speed_std=0.0, rms=loads,
        equivalent_load=loads, travel=0.0, rate_use=0.0, rate_peak=0.0,
    )  # fmt: skip


@given(
    st.lists(st.tuples(st.floats(1.0, 10.0), st.floats(1.0, 10.0)), min_size=2, max_size=8),
    st.floats(1e-3, 1e3),
)
def test_a_cut_is_the_mean_of_paired_shares_with_students_interval(pairs, scale):
    mine = [_made(i, a * scale) for i, (a, _) in enumerate(pairs)]
    other = [_made(i, b * scale) for i, (_, b) in enumerate(pairs)]
    found = cut(mine, other, "del", "tilt")
    shares = np.array([1.0 - a / b for a, b in pairs])
    assert found.mean == pytest.approx(shares.mean(), rel=1e-9, abs=1e-12)
    if shares.std() > 1e-9:
        low, high = stats.t.interval(
            0.95, shares.size - 1, loc=shares.mean(), scale=stats.sem(shares)
        )
        assert found.least == pytest.approx(low, rel=1e-7, abs=1e-9)
        assert found.most == pytest.approx(high, rel=1e-7, abs=1e-9)


def test_one_run_has_no_interval():
    found = cut([_made(1, 3.0)], [_made(1, 4.0)], "rms", "yaw")
    assert (found.mean, found.half_width) == (0.25, None)
    assert found.least == found.most == 0.25


def test_cuts_need_the_same_seeds():
    with pytest.raises(InputError, match="seeds"):
        cut([_made(1, 3.0)], [_made(2, 4.0)], "del", "yaw")
    with pytest.raises(InputError, match="seeds"):
        cut([], [], "del", "yaw")


def test_measures_are_plain():
    assert dataclasses.asdict(_made(1, 2.0))["rms"]["tilt"] == 2.0
