"""The table of lowest pitch: monotone interpolation, the compiled table, its effect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from control_factories import measured, pitches, run_rotor, table_estimator
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.control import MinimumPitchTable, nrel_5mw_baseline
from pitchopt.control.part_kernels import lowest_pitch
from pitchopt.errors import InputError

PAPER = MinimumPitchTable(
    wind_speed=[5.0, 14.0, 18.0, 24.0, 50.0], pitch=np.radians([0.0, 1.0, 9.0, 19.0, 90.0])
)


def test_the_points_are_met_and_the_ends_held() -> None:
    assert np.allclose(PAPER.lowest(PAPER.wind_speed), PAPER.pitch, rtol=0, atol=1e-15)
    assert PAPER.lowest(0.0) == PAPER.pitch[0] and PAPER.lowest(99.0) == PAPER.pitch[-1]


@given(
    steps=st.lists(st.floats(0.0, 0.2), min_size=2, max_size=8),
    gaps=st.lists(st.floats(0.5, 6.0), min_size=8, max_size=8),
)
def test_a_rising_table_rises_everywhere(steps: list[float], gaps: list[float]) -> None:
    pitch = np.cumsum(steps)
    wind = 3.0 + np.cumsum(gaps[: pitch.size])
    table = MinimumPitchTable(wind_speed=wind, pitch=pitch)
    fine = table.lowest(np.linspace(wind[0], wind[-1], 400))
    assert np.all(np.diff(fine) >= -1e-12)
    assert fine[0] >= pitch[0] - 1e-12 and fine[-1] <= pitch[-1] + 1e-12


def test_the_compiled_table_is_as_the_curve() -> None:
    p = PAPER.parameters()
    assert p.spacing <= 0.05
    winds = np.linspace(0.0, 60.0, 2001)
    compiled = np.array([lowest_pitch(p, wind) for wind in winds])
    assert np.max(np.abs(compiled - PAPER.lowest(winds))) < 1e-5
    assert compiled[0] == PAPER.pitch[0] and compiled[-1] == PAPER.pitch[-1]


def test_the_lowest_pitch_holds_in_partial_load_and_is_left_without_windup() -> None:
    controller = replace(
        nrel_5mw_baseline(),
        estimator=table_estimator(1.0),
        minimum_pitch=MinimumPitchTable(
            wind_speed=[5.0, 9.0, 12.0, 25.0], pitch=[0.0, 0.03, 0.1, 0.12]
        ),
    )
    run = run_rotor(
        controller,
        lambda t: 9.0 if t < 150.0 else 20.0,
        duration=400.0,
        rotor_speed=1.1,
        pitch=0.03,
        generator_torque=25000.0,
    )
    held = float(controller.minimum_pitch.lowest(run["estimate"][7400]))
    assert np.isclose(run["pitch"][7400], held, atol=1e-4) and held > 0.02
    assert np.all(run["pitch"] >= -1e-15)
    # rated speed again at 20 m/s, well above the lowest pitch
    assert run["pitch"][-1] > 0.2
    assert abs(run["rotor_speed"][-1] - 122.9096 / 97.0) < 1e-5


def test_the_table_stays_within_the_range_of_pitch() -> None:
    controller = replace(
        nrel_5mw_baseline(),
        estimator=table_estimator(),
        minimum_pitch=MinimumPitchTable(wind_speed=[5.0, 6.0], pitch=[-0.2, -0.1]),
    )
    controller.start(0.02, measured(rotor_speed=0.9, pitch=0.0, generator_torque=5000.0))
    assert np.all(pitches(controller.command(measured(rotor_speed=0.9, pitch=0.0))) == 0.0)


@pytest.mark.parametrize(
    ("wind", "pitch", "message"),
    [
        ([5.0], [0.0], r"wind_speed: got \[5.0\], expected two or more"),
        ([5.0, 5.0], [0.0, 0.1], "ascending"),
        ([5.0, 6.0], [0.0], "pitch: got shape"),
        ([5.0, 6.0], [0.0, np.nan], "pitch: got 1 NaN"),
    ],
)
def test_bad_input(wind: list[float], pitch: list[float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        MinimumPitchTable(wind_speed=wind, pitch=pitch)
