"""The compiled controller: one path, bad measurements, start, memory."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numba as nb
import numpy as np
import pytest
from control_factories import (
    RATED_SPEED,
    FloatArray,
    full_controller,
    measured,
    pitches,
    table_estimator,
)
from hypothesis import given
from hypothesis import strategies as st
from test_lqr import regulator

from pitchopt.control import (
    IndividualPitch,
    MinimumPitchTable,
    PitchProfile,
    TurbineController,
    kernels,
    nrel_5mw_baseline,
)
from pitchopt.control import signals as s
from pitchopt.errors import InputError

STEP = 0.02

BASELINE = nrel_5mw_baseline()
CONTROLLERS = {
    "baseline": BASELINE,
    "full": full_controller(),
    "individual": replace(BASELINE, individual=IndividualPitch(gain=[1e-9])),
    "quadratic": replace(BASELINE, pitch=regulator(), estimator=table_estimator()),
}


def course(calls: int = 1500) -> FloatArray:
    """Signals (calls, MEASURED) of a turbine in some turbulent wind."""
    rng = np.random.default_rng(7)
    t = STEP * np.arange(calls)
    speed = RATED_SPEED * (1 + 0.05 * np.sin(0.3 * t) + 0.002 * rng.standard_normal(calls))
    rows = [
        measured(
            rotor_speed=speed[k],
            azimuth=float(np.mod(RATED_SPEED * t[k], 2 * np.pi)),
            pitch=0.1 + 0.03 * np.sin(0.3 * t[k]),
            out_of_plane=1e6 * (5 + rng.standard_normal(3)),
            generator_torque=43000.0 * (1 - 0.05 * np.sin(0.3 * t[k])),
            tower_x=0.3 + 0.1 * np.sin(2 * t[k]),
            tower_vx=0.2 * np.cos(2 * t[k]),
        )
        for k in range(calls)
    ]
    return np.array(rows)


@nb.njit
def _loop(p, memory, signals, commands):  # type: ignore[no-untyped-def]
    for k in range(signals.shape[0]):
        kernels.update(p, memory, signals[k], commands[k])


def commands_of_loop(controller: TurbineController, signals: FloatArray) -> FloatArray:
    """Commands (calls, COMMANDS) of a compiled time loop."""
    p, memory = controller.parameters(STEP), np.zeros(controller.memory_size)
    commands = np.empty((signals.shape[0], s.COMMANDS))
    kernels.start(p, memory, signals[0].copy())
    _loop(p, memory, signals, commands)
    return commands


def commands_of_calls(controller: TurbineController, signals: FloatArray) -> FloatArray:
    """The same by the protocol."""
    controller.start(STEP, signals[0])
    return np.array([controller.command(row) for row in signals])


@pytest.mark.parametrize("name", CONTROLLERS)
def test_protocol_and_loop_agree_to_the_last_bit(name: str) -> None:
    signals = course()
    loop = commands_of_loop(CONTROLLERS[name], signals)
    assert np.array_equal(loop, commands_of_calls(CONTROLLERS[name], signals))
    assert np.all(np.isfinite(loop)) and np.all(np.std(loop, axis=0) > 0.0)


def test_plain_python_agrees_with_the_compiled_code() -> None:
    """The same source without compilation, in a process of its own."""
    code = (
        "import json, sys; sys.path.insert(0, sys.argv[1]); import test_kernels as t\n"
        "signals = t.course(300)\n"
        "out = {n: t.commands_of_calls(c, signals).tolist() for n, c in t.CONTROLLERS.items()}\n"
        "print(json.dumps(out))"
    )
    folder = os.path.dirname(__file__)  # noqa: PTH120
    done = subprocess.run(
        [sys.executable, "-c", code, folder],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    signals = course(300)
    for name, plain in json.loads(done.stdout).items():
        compiled = commands_of_calls(CONTROLLERS[name], signals)
        assert np.allclose(np.array(plain), compiled, rtol=1e-12, atol=1e-15), name


def test_nothing_heavy_loads_before_it_is_used() -> None:
    code = (
        "import sys, pitchopt.control as c; c.nrel_5mw_baseline().parameters(0.01)\n"
        "print([m for m in ('numba', 'scipy') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_one_compilation_serves_all_controllers() -> None:
    for controller in CONTROLLERS.values():
        commands_of_calls(controller, course(2))
    assert len(kernels.update.signatures) == 1


def test_calls_allocate_nothing() -> None:
    from numba.core.runtime import _nrt_python, rtsys

    controller = full_controller()
    p, memory, signals = controller.parameters(STEP), np.zeros(controller.memory_size), course(200)
    kernels.start(p, memory, signals[0].copy())
    commands = np.empty((200, s.COMMANDS))
    _nrt_python.memsys_enable_stats()
    try:
        allocated = []
        for calls in (1, 200):  # a call from Python allocates for its arguments alone
            before = rtsys.get_allocation_stats().alloc
            _loop(p, memory, signals[:calls], commands[:calls])
            allocated.append(rtsys.get_allocation_stats().alloc - before)
    finally:
        _nrt_python.memsys_disable_stats()
    assert allocated[0] == allocated[1] > 0


class TestBadMeasurements:
    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e13])
    @pytest.mark.parametrize("place", [0, s.GENERATOR_SPEED, s.OUT_OF_PLANE + 1, s.POWER])
    def test_the_last_command_stands_and_the_memory_too(self, bad: float, place: int) -> None:
        signals = course(40)
        controller = full_controller()
        clean = commands_of_calls(controller, signals)
        controller.start(STEP, signals[0])
        for k, row in enumerate(signals):
            if k == 20:
                broken = row.copy()
                broken[place] = bad
                for _ in range(3):
                    assert np.array_equal(controller.command(broken), clean[19])
            assert np.array_equal(controller.command(row), clean[k])
        assert controller.held_calls == 3

    def test_at_the_start_they_are_refused(self) -> None:
        with pytest.raises(InputError, match="got 1 NaN or infinite"):
            nrel_5mw_baseline().start(STEP, measured(rotor_speed=1.2, power=np.nan))

    @given(
        st.lists(
            st.lists(
                st.floats(allow_nan=True, allow_infinity=True),
                min_size=s.MEASURED,
                max_size=s.MEASURED,
            ),
            min_size=1,
            max_size=6,
        ),
        st.sampled_from(sorted(CONTROLLERS)),
    )
    def test_whatever_is_measured_commands_keep_their_limits(
        self, rows: list[list[float]], name: str
    ) -> None:
        controller = CONTROLLERS[name]
        controller.start(STEP, measured())
        last = controller.command(measured())
        limits = controller.pitch_range.parameters()
        for row in rows:
            command = controller.command(np.array(row))
            change = np.abs(command - last)
            assert np.all(np.isfinite(command))
            assert change[s.TORQUE] <= controller.torque.largest_rate * STEP * (1 + 1e-9)
            assert np.all(pitches(change) <= limits.rate * STEP * (1 + 1e-9))
            assert command[s.TORQUE] <= controller.torque.largest_torque
            assert np.all(pitches(command) >= limits.blade_lowest)
            assert np.all(pitches(command) <= limits.blade_highest)
            last = command


class TestStart:
    @pytest.mark.parametrize("beta", [0.02, 0.1, 0.4])
    @pytest.mark.parametrize("speed", [1.24, RATED_SPEED, 1.29])
    def test_the_first_pitch_is_the_measured_one(self, beta: float, speed: float) -> None:
        controller = nrel_5mw_baseline()
        now = measured(rotor_speed=speed, pitch=beta)
        controller.start(STEP, now)
        # too fast for so little pitch: no integral within the range brings that down
        factor = float(controller.pitch.gain_factor(beta))
        least = factor * controller.pitch.proportional * (97.0 * speed - 122.9096)
        first = pitches(controller.command(now))
        most = beta + np.radians(8.0) * STEP
        assert np.allclose(first, min(max(beta, least), most), rtol=0, atol=1e-14)

    def test_the_first_torque_starts_from_the_measured_one(self) -> None:
        controller = nrel_5mw_baseline()
        now = measured(rotor_speed=1.1, pitch=0.0, generator_torque=10000.0)
        controller.start(STEP, now)
        assert controller.command(now)[s.TORQUE] == 10000.0 + 15000.0 * STEP

    def test_a_pitch_below_the_range_comes_in(self) -> None:
        controller = nrel_5mw_baseline()
        controller.start(STEP, measured(pitch=-0.05))
        assert np.all(pitches(controller.command(measured())) >= 0.0)

    def test_a_second_run_forgets_the_first(self) -> None:
        signals = course(50)
        controller = full_controller()
        first = commands_of_calls(controller, signals)
        assert np.array_equal(first, commands_of_calls(controller, signals))


class TestCalls:
    def test_command_before_start(self) -> None:
        with pytest.raises(InputError, match="called before start"):
            nrel_5mw_baseline().command(measured())

    def test_wrong_length(self) -> None:
        controller = nrel_5mw_baseline()
        controller.start(STEP, measured())
        with pytest.raises(InputError, match=r"measured: got shape \(3,\)"):
            controller.command(np.zeros(3))

    @pytest.mark.parametrize("step", [0.0, -1.0, np.nan])
    def test_step(self, step: float) -> None:
        with pytest.raises(InputError, match="step"):
            nrel_5mw_baseline().parameters(step)

    def test_speed_corner(self) -> None:
        with pytest.raises(InputError, match="speed_corner"):
            replace(nrel_5mw_baseline(), speed_corner=0.0)

    @pytest.mark.parametrize(
        "part",
        [
            {"pitch": regulator()},
            {"minimum_pitch": MinimumPitchTable(wind_speed=[5.0, 9.0], pitch=[0.0, 0.1])},
            {"feedforward": PitchProfile(cosine=[0.1], sine=[0.0], over_wind=True)},
        ],
    )
    def test_a_wind_schedule_needs_an_estimator(self, part: dict[str, Any]) -> None:
        (name,) = part
        with pytest.raises(InputError, match=f"{name}: scheduled over the wind speed without"):
            replace(nrel_5mw_baseline(), **part)

    def test_memory_grows_with_the_harmonics(self) -> None:
        base = nrel_5mw_baseline()
        two = replace(base, individual=IndividualPitch(gain=[1e-9, 1e-9]))
        assert two.memory_size == base.memory_size + 4
