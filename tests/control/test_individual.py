"""Individual pitch control on a rigid rotor that answers at once, with lagging actuators."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from control_factories import FloatArray, measured, pitches, wide

from pitchopt.control import (
    IndividualPitch,
    PitchActuator,
    PitchRange,
    TurbineController,
    decoupling_offset,
    from_fixed_frame,
    nrel_5mw_baseline,
    to_fixed_frame,
)
from pitchopt.control.actuator_kernels import pitch_actuator
from pitchopt.errors import InputError

OMEGA = 1.267
TURN = 496  # calls in a turn
STEP = 2 * np.pi / OMEGA / TURN
SLOPE = 4e7  # moment that a radian of pitch takes off [N m/rad]
LOADS = {1: np.array([2e6, -1e6]), 2: np.array([-4e5, 6e5])}


def run(
    individual: IndividualPitch,
    *,
    tau: float = 0.0,
    duration: float = 60.0,
    controller: TurbineController | None = None,
    collective: float = 0.2,
) -> dict[str, FloatArray]:
    """Fixed-frame loads (T, 2) of each order while the control works, and the commands."""
    base = controller or wide(nrel_5mw_baseline())
    # the regulator stands still at the collective pitch asked for
    steady = replace(base.pitch, reference_speed=97.0 * OMEGA, proportional=0.0)
    whole = replace(base, pitch=steady, individual=individual)
    actuator = PitchActuator(
        lowest=-3.0, highest=3.0, rate=1e3, time_constant=tau if tau > 0.0 else None
    ).parameters(STEP)
    blades, speeds = np.full(3, collective), np.zeros(3)
    whole.start(STEP, measured(rotor_speed=OMEGA, pitch=collective))
    loads: dict[int, list[FloatArray]] = {1: [], 2: []}
    commands = []
    for k in range(round(duration / STEP)):
        azimuth = OMEGA * STEP * k
        moments = 6e6 - SLOPE * (blades - collective)
        for n, part in LOADS.items():
            moments = moments + from_fixed_frame(part, azimuth, n)
        for n in LOADS:
            loads[n].append(to_fixed_frame(moments, azimuth, n))
        now = measured(
            rotor_speed=OMEGA,
            azimuth=float(np.mod(azimuth, 2 * np.pi)),
            pitch=blades,
            out_of_plane=moments,
        )
        command = pitches(whole.command(now))
        commands.append(command)
        for b in range(3):
            blades[b], speeds[b] = pitch_actuator(actuator, blades[b], speeds[b], command[b])
    out = {f"load{n}": np.array(values) for n, values in loads.items()}
    return out | {"command": np.array(commands)}


def turn_mean(values: FloatArray) -> FloatArray:
    """Mean over the last whole turn."""
    return np.asarray(np.mean(values[-TURN:], axis=0))


class TestPositiveGainReducesTheLoad:
    @pytest.mark.parametrize("tau", [0.0, 0.4])
    def test_both_harmonics_vanish(self, tau: float) -> None:
        offsets = [decoupling_offset(n, OMEGA, tau) for n in (1, 2)]
        seen = run(IndividualPitch(gain=[5e-9, 5e-9], offset=offsets), tau=tau, duration=80.0)
        for n, part in LOADS.items():
            assert np.linalg.norm(turn_mean(seen[f"load{n}"])) < 1e-3 * np.linalg.norm(part)
        # the pitch that does it is the load over the slope
        assert np.all(np.ptp(seen["command"][-500:], axis=0) > 2e6 / SLOPE)

    def test_negative_gain_raises_it(self) -> None:
        seen = run(IndividualPitch(gain=[-2e-9]), duration=15.0)
        assert np.linalg.norm(turn_mean(seen["load1"])) > 2.0 * np.linalg.norm(LOADS[1])

    def test_the_mean_pitch_is_left_alone(self) -> None:
        seen = run(IndividualPitch(gain=[5e-9, 5e-9]), duration=20.0)
        assert np.allclose(np.mean(seen["command"], axis=1), 0.2, rtol=0, atol=1e-9)

    def test_order_two_alone_leaves_order_one(self) -> None:
        seen = run(IndividualPitch(gain=[5e-9], order=[2]))
        assert np.linalg.norm(turn_mean(seen["load2"])) < 1e-3 * np.linalg.norm(LOADS[2])
        # loads of order one turn three times a revolution in the frame of order two
        leak = 5e-9 * SLOPE / (3 * OMEGA) * np.linalg.norm(LOADS[1])
        change = np.linalg.norm(turn_mean(seen["load1"]) - LOADS[1])
        assert np.isclose(change, leak, rtol=0.1)


@pytest.mark.parametrize("n", [1, 2])
@pytest.mark.parametrize("tau", [0.2, 0.4, 0.8])
def test_the_offset_of_the_closed_form_decouples(n: int, tau: float) -> None:
    """Slow integral control acts through the actuator's steady answer at n omega, a turn."""

    def coupling(offset: float) -> float:
        """Largest load across the first direction while the load along it is taken off."""
        seen = run(
            IndividualPitch(gain=[1.2e-9], order=[n], offset=[offset]), tau=tau, duration=60.0
        )[f"load{n}"]
        unit = LOADS[n] / np.linalg.norm(LOADS[n])
        mean = np.full(TURN, 1.0 / TURN)
        smooth = np.stack([np.convolve(part, mode="valid", v=mean) for part in seen.T], axis=1)
        across = smooth @ np.array([-unit[1], unit[0]])
        return float(across[np.argmax(np.abs(across))] / np.linalg.norm(LOADS[n]))

    best = decoupling_offset(n, OMEGA, tau)
    assert np.isclose(np.tan(n * best), n * OMEGA * tau)
    at_best, without, beyond = coupling(best), coupling(0.0), coupling(2.0 * best)
    assert abs(at_best) < 0.03
    assert abs(without) > 3 * abs(at_best) and abs(beyond) > 3 * abs(at_best)
    assert without * beyond < 0.0  # the coupling changes sign at the closed form


def settle(limit: float, **others: Any) -> dict[str, FloatArray]:
    return run(IndividualPitch(gain=[5e-9], limit=limit, **others), duration=40.0)


class TestLimits:
    def test_the_amplitude_keeps_within_its_limit(self) -> None:
        limit = 0.5 * np.linalg.norm(LOADS[1]) / SLOPE
        seen = settle(limit)
        deviation = seen["command"] - 0.2
        assert np.max(np.abs(deviation)) <= limit * (1 + 1e-9)
        assert np.max(np.abs(deviation)) > 0.99 * limit
        # in the direction of the load: half of it is left
        rest = turn_mean(seen["load1"]) - 0.5 * LOADS[1]
        assert np.linalg.norm(rest) < 0.02 * np.linalg.norm(LOADS[1])

    def test_no_windup_at_the_limit(self) -> None:
        controller = replace(
            wide(nrel_5mw_baseline()), individual=IndividualPitch(gain=[5e-9], limit=0.01)
        )
        controller.start(STEP, measured(rotor_speed=OMEGA))
        tilt = from_fixed_frame([5e6, 0.0], 0.0)
        for sign, calls in ((1.0, 5000), (-1.0, 1)):
            for _ in range(calls):
                last = pitches(controller.command(measured(out_of_plane=sign * tilt)))
        # one step of -5e-9 * 5e6 * 0.01 back from the limit
        assert np.isclose(last[0] - np.mean(last), 0.01 - 5e-9 * 5e6 * STEP, rtol=1e-6)

    def test_no_growth_while_a_blade_is_cut(self) -> None:
        controller = replace(
            nrel_5mw_baseline(),
            pitch_range=PitchRange(lowest=0.0, highest=1.5, rate=1e3),
            individual=IndividualPitch(gain=[5e-9]),
        )
        controller.start(STEP, measured(rotor_speed=0.9, pitch=0.0))
        tilt = from_fixed_frame([5e6, 0.0], 0.0)
        for _ in range(5000):
            command = pitches(
                controller.command(measured(rotor_speed=0.9, pitch=0.0, out_of_plane=tilt))
            )
        # collective at its lowest: the first cut ends the growth
        assert np.all(command >= 0.0)
        assert np.max(command) <= 2 * 5e-9 * 5e6 * STEP

    def test_fade_over_collective_pitch(self) -> None:
        fade = {"fade_from": 0.1, "fade_to": 0.3}
        individual = IndividualPitch(gain=[5e-9], limit=0.02, **fade)
        for collective, share in ((0.05, 0.0), (0.2, 0.5), (0.35, 1.0)):
            seen = run(individual, duration=20.0, collective=collective)
            assert np.isclose(
                np.max(np.abs(seen["command"] - collective)), 0.02 * share, rtol=1e-3, atol=1e-12
            )

    def test_fade_over_time(self) -> None:
        seen = run(IndividualPitch(gain=[1e-6], limit=0.02, fade_time=10.0), duration=20.0)
        size = np.max(np.abs(seen["command"] - 0.2), axis=1)
        times = STEP * np.arange(size.size)
        assert np.all(size <= 0.02 * np.minimum(times / 10.0, 1.0) + 1e-12)
        assert np.max(size[(times > 9.0) & (times < 10.0)]) > 0.017


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: IndividualPitch(gain=[]), "gain: got shape"),
        (lambda: IndividualPitch(gain=[np.nan]), "gain: got 1 NaN"),
        (lambda: IndividualPitch(gain=[1.0], offset=[0.0, 0.1]), "offset: got shape"),
        (lambda: IndividualPitch(gain=[1.0], order=[3]), "multiple of three"),
        (lambda: IndividualPitch(gain=[1.0, 1.0, 1.0]), "multiple of three"),
        (lambda: IndividualPitch(gain=[1.0, 1.0], order=[1, 1]), "different harmonics"),
        (lambda: IndividualPitch(gain=[1.0, 1.0], order=[1]), "order: got shape"),
        (lambda: IndividualPitch(gain=[1.0], limit=0.0), "limit"),
        (lambda: IndividualPitch(gain=[1.0], fade_from=0.2, fade_to=0.1), "fade_to"),
        (lambda: IndividualPitch(gain=[1.0], fade_time=-1.0), "fade_time"),
        (lambda: decoupling_offset(3, 1.0, 0.4), "multiple of three"),
        (lambda: decoupling_offset(1, -1.0, 0.4), "rotor_speed"),
        (lambda: decoupling_offset(1, 1.0, -0.4), "time_constant"),
    ],
)
def test_bad_input(make: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()
