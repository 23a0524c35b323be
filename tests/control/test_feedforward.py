"""Profile feed-forward: the sum at each blade, exact tracking through actuators, schedules."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from control_factories import FloatArray, full_controller, measured, pitches, wide
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.control import PitchActuator, PitchProfile, nrel_5mw_baseline
from pitchopt.control.actuator_kernels import pitch_actuator
from pitchopt.errors import InputError

OMEGA = 1.267
THIRDS = 2 * np.pi / 3 * np.arange(3)
STATIONS = 2 * np.pi * np.arange(36) / 36
PROFILE = 0.04 * np.exp(np.cos(STATIONS - 2.8)) * np.cos(STATIONS)


def deviations(profile: PitchProfile, azimuth: float, collective: float = 0.2) -> FloatArray:
    """First command of the blades less the collective pitch."""
    base = wide(nrel_5mw_baseline())
    steady = replace(base.pitch, reference_speed=97.0 * OMEGA, proportional=0.0)
    controller = replace(base, pitch=steady, feedforward=profile)
    now = measured(rotor_speed=OMEGA, azimuth=azimuth, pitch=collective)
    controller.start(0.01, now)
    return pitches(controller.command(now)) - collective


@given(
    samples=st.lists(st.floats(-0.2, 0.2), min_size=3, max_size=40),
    azimuth=st.floats(0.0, 2 * np.pi),
)
def test_the_sum_of_the_kernel_is_the_series_of_the_profile(
    samples: list[float], azimuth: float
) -> None:
    profile = PitchProfile.from_samples(samples)
    expected = profile.deviation(azimuth + THIRDS)
    assert np.allclose(deviations(profile, azimuth), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("count", [3, 4, 24, 35])
def test_all_harmonics_pass_through_the_samples(count: int) -> None:
    samples = np.random.default_rng(count).standard_normal(count)
    profile = PitchProfile.from_samples(samples)
    azimuths = 2 * np.pi * np.arange(count) / count
    assert np.allclose(profile.deviation(azimuths), samples - np.mean(samples), atol=1e-12)
    few = PitchProfile.from_samples(samples, harmonics=1)
    assert few.cosine.size == 1 and np.isclose(
        few.cosine[0] if count > 2 else 0.0, 2 * np.mean(samples * np.cos(azimuths))
    )


class TestLead:
    @pytest.mark.parametrize(
        "actuator", [{"time_constant": 0.4}, {"frequency": 6.0, "damping": 0.7}]
    )
    @pytest.mark.parametrize("amplitude", [True, False])
    def test_the_blade_moves_as_the_profile_says(
        self, actuator: dict[str, float], amplitude: bool
    ) -> None:
        profile = PitchProfile.from_samples(PROFILE, harmonics=6, amplitude=amplitude, **actuator)
        base = wide(nrel_5mw_baseline())
        steady = replace(base.pitch, reference_speed=97.0 * OMEGA, proportional=0.0)
        controller = replace(base, pitch=steady, feedforward=profile)
        turn = 2480
        step = 2 * np.pi / OMEGA / turn
        numbers = PitchActuator(lowest=-3, highest=3, rate=1e3, **actuator).parameters(step)
        controller.start(step, measured(rotor_speed=OMEGA, pitch=0.2))
        position, velocity, moved, azimuths = np.full(3, 0.2), np.zeros(3), [], []
        for k in range(3 * turn):
            azimuth = OMEGA * step * k
            command = pitches(
                controller.command(measured(rotor_speed=OMEGA, azimuth=azimuth, pitch=position))
            )
            for b in range(3):
                position[b], velocity[b] = pitch_actuator(
                    numbers, position[b], velocity[b], command[b]
                )
            azimuths.append(azimuth + OMEGA * step + THIRDS)
            moved.append(position - 0.2)
        late = slice(2 * turn, None)
        wanted = profile.deviation(np.array(azimuths)[late])
        got = np.array(moved)[late]
        if amplitude:
            # a command that stands still over a step comes half a step late
            assert np.max(np.abs(got - wanted)) < 0.01 * np.max(np.abs(wanted))
        else:
            spectrum = np.fft.rfft(got[:turn, 0])[1:7]
            ideal = np.fft.rfft(wanted[:turn, 0])[1:7]
            assert np.max(np.abs(np.angle(spectrum / ideal))) < 0.02
            n = np.arange(1, 7)
            omega, zeta = actuator.get("frequency", np.inf), actuator.get("damping", 0.0)
            tau = actuator.get("time_constant", 2 * zeta / omega)
            answer = 1 / np.abs(1 - (n * OMEGA / omega) ** 2 + 1j * n * OMEGA * tau)
            assert np.allclose(np.abs(spectrum / ideal), answer, rtol=0.01)

    def test_without_lead_an_actuator_lags(self) -> None:
        plain, led = (
            PitchProfile(cosine=[0.1], sine=[0.0], time_constant=tau, amplitude=False)
            for tau in (0.0, 0.4)
        )
        lead = np.arctan(OMEGA * 0.4)
        for azimuth in (0.3, 2.0, 4.0):
            assert np.allclose(
                deviations(led, azimuth - lead), deviations(plain, azimuth), rtol=0, atol=1e-12
            )


class TestSchedule:
    def test_over_collective_pitch(self) -> None:
        whole = PitchProfile.from_samples(PROFILE)
        scaled = replace(whole, schedule_at=[0.1, 0.3], schedule=[0.0, 2.0])
        for collective, scale in ((0.05, 0.0), (0.15, 0.5), (0.4, 2.0)):
            assert np.allclose(
                deviations(scaled, 1.0, collective),
                scale * deviations(whole, 1.0, collective),
                rtol=0,
                atol=1e-12,
            )

    def test_over_wind(self) -> None:
        profile = PitchProfile.from_samples(
            PROFILE, schedule_at=[5.0, 25.0], schedule=[0.0, 2.0], over_wind=True
        )
        controller = replace(wide(full_controller()), individual=None, feedforward=profile)
        now = measured(azimuth=0.7, pitch=0.2, generator_torque=43000.0)
        controller.start(0.01, now)
        got = pitches(controller.command(now))
        scale = (controller.wind_speed - 5.0) / 10.0
        assert 0.2 < scale < 1.8
        expected = scale * profile.deviation(0.7 + THIRDS)
        assert np.allclose(got - np.mean(got), expected - np.mean(expected), rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: PitchProfile(cosine=[0.1], sine=[0.1, 0.2]), "sine: got shape"),
        (lambda: PitchProfile(cosine=[np.inf], sine=[0.1]), "cosine: got 1 NaN"),
        (lambda: PitchProfile(cosine=[0.1], sine=[0.1], time_constant=-1.0), "time_constant"),
        (lambda: PitchProfile(cosine=[0.1], sine=[0.1], frequency=3.0), "both or neither"),
        (
            lambda: PitchProfile(
                cosine=[0.1], sine=[0.1], frequency=3.0, damping=0.7, time_constant=0.1
            ),
            "of first or of second order",
        ),
        (
            lambda: PitchProfile(cosine=[0.1], sine=[0.1], frequency=0.0, damping=0.7),
            "frequency: got 0.0",
        ),
        (
            lambda: PitchProfile(cosine=[0.1], sine=[0.1], schedule_at=[1, 1], schedule=[1, 1]),
            "schedule_at: expected ascending",
        ),
        (
            lambda: PitchProfile(cosine=[0.1], sine=[0.1], schedule=[1, 1]),
            "schedule: got shape",
        ),
        (lambda: PitchProfile.from_samples([0.1, 0.2]), "expected three or more"),
        (lambda: PitchProfile.from_samples(PROFILE, harmonics=19), "harmonics: got 19"),
        (lambda: PitchProfile.from_samples(PROFILE, harmonics=0), "harmonics: got 0"),
    ],
)
def test_bad_input(make: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()
