"""Runs: convergence with the step, determinism, controllers, limits, bad input."""

from __future__ import annotations

import dataclasses
import math
import pickle

import numpy as np
import pytest

from pitchopt.control import PitchActuator, TurbineController
from pitchopt.control.signals import COMMANDS, GENERATOR_SPEED, PITCH_COMMAND, TORQUE
from pitchopt.errors import InputError
from pitchopt.sim import (
    FREEDOMS,
    DynamicTurbine,
    Operation,
    Start,
    TurbineRun,
    simulate,
    simulate_many,
    statistics,
)
from windfield import StaticField, TransientField, TurbulenceBox, TurbulentField, kaimal_box

START = Start(rotor_speed=1.267, pitch=math.radians(3.0), torque=43e3)


@pytest.fixture(scope="module")
def turbulent(sheared):
    fields = {}

    def field(seed: int) -> TurbulentField:
        if seed not in fields:
            box = kaimal_box(
                12.0,
                60.0,
                0.25,
                hub_height=90.0,
                width=144.0,
                points=(7, 7),
                seed=seed,
            )
            fields[seed] = TurbulentField(mean=sheared(12.0), box=box)
        return fields[seed]

    return field


def test_python_and_compiled_controller_agree(dynamic, turbulent, controller) -> None:
    """The controller in Python is the compiled one, called from outside.

    The compiler fuses operations of the whole loop in another way than those of one step, so the
    two differ by rounding.
    """

    class Outside:
        def __init__(self) -> None:
            self.calls = 0

        def start(self, step, measured):
            controller.start(step, measured)

        def command(self, measured):
            self.calls += 1
            return controller.command(measured)

    outside = Outside()
    a = simulate(dynamic, turbulent(1), controller, 5.0, start=START)
    b = simulate(dynamic, turbulent(1), outside, 5.0, start=START)
    assert outside.calls == 200
    scale = np.abs(a.values).max(axis=0)
    assert np.abs(a.values - b.values).max(axis=0) == pytest.approx(0.0, abs=1e-9 * scale.max())
    assert np.all(np.abs(a.values - b.values) <= 1e-8 * np.maximum(scale, 1e-9))


def test_same_result_whatever_the_number_of_threads(dynamic, turbulent, controller) -> None:
    winds = [turbulent(seed) for seed in (1, 2, 3)]
    seen = []
    one, two = (
        simulate_many(
            dynamic,
            winds,
            controller,
            20.0,
            start=START,
            workers=workers,
            labels=["1", "2", "3"],
            on_result=lambda s: seen.append(s.label),
        )
        for workers in (1, 3)
    )
    assert seen == ["1", "2", "3"] * 2
    for a, b in zip(one, two, strict=True):
        assert np.array_equal(a.values, b.values)
    assert not np.array_equal(one[0].values, one[1].values)


def test_pickled_turbine_runs_to_the_same_bits(dynamic, turbulent, controller) -> None:
    """What an executor of processes sends to them."""
    once = simulate(dynamic, turbulent(1), controller, 5.0, start=START)
    copies = pickle.loads(pickle.dumps((dynamic, turbulent(1), controller)))  # noqa: S301 (own)
    assert copies[0].turbine.notes == dynamic.turbine.notes
    np.testing.assert_array_equal(simulate(*copies, 5.0, start=START).values, once.values)


def test_snapshot_goes_on_to_the_last_bit(dynamic, turbulent) -> None:
    command = np.zeros(COMMANDS)
    command[TORQUE], command[PITCH_COMMAND:] = 40e3, 0.05
    run = TurbineRun(dynamic, turbulent(1), rotor_speed=1.2, pitch=0.05, torque=40e3)
    for _ in range(40):
        assert run.advance(command)
    kept = run.snapshot()
    for _ in range(40):
        run.advance(command)
    first = run.outputs()
    other = TurbineRun(dynamic, turbulent(1), rotor_speed=0.5)
    other.restore(kept)
    assert other.time == pytest.approx(1.0)
    for _ in range(40):
        other.advance(command)
    assert np.array_equal(first, other.outputs())
    with pytest.raises(InputError, match="snapshot: array 'q' is missing"):
        other.restore({})


def test_second_order_in_the_step(nrel, sheared) -> None:
    """Halving the step quarters the error of a smooth transient (no tower shadow, no limits)."""
    wind = TransientField(
        mean=dataclasses.replace(sheared(12.0), tower=None),
        time=[0.0, 1.0, 3.0],
        speed=[12.0, 12.0, 13.0],
    )
    command = np.zeros(COMMANDS)
    command[TORQUE], command[PITCH_COMMAND:] = 43e3, 0.05
    states = []
    for step in (0.01, 0.005, 0.0025, 0.000625):
        dynamic = DynamicTurbine(turbine=nrel, inflow="quasi-steady", step=step)
        run = TurbineRun(dynamic, wind, rotor_speed=1.267, pitch=0.05, torque=43e3)
        for _ in range(round(4.0 / step)):
            assert run.advance(command)
        states.append(np.concatenate([run.state.q, run.state.v])[[0, 2, 4, 5, 12]])
    errors = [np.abs(state - states[-1]).max() for state in states[:-1]]
    assert errors[0] / errors[1] > 3.0
    assert errors[1] / errors[2] > 3.0


def test_error_check_falls_with_the_step(nrel, sheared, controller) -> None:
    coarse, fine = (
        simulate(
            DynamicTurbine(turbine=nrel, step=step),
            sheared(12.0),
            controller,
            20.0,
            start=START,
        ).error
        for step in (0.05, 0.0125)
    )
    moving = [0, 1, 2, *range(4, 10)]
    assert np.all(fine[moving] < 0.5 * coarse[moving])
    assert np.all(fine[moving] < 0.05)


def test_switching_freedoms_off(nrel, sheared, controller) -> None:
    rigid = DynamicTurbine(turbine=nrel, freedoms=(), step=0.025)
    result = simulate(rigid, sheared(12.0), controller, 5.0, start=START)
    for name in ("TTDspFA", "TTDspSS", "OoPDefl1", "IPDefl2", "YawBrTAxp", "LSShftTwst"):
        assert np.all(result[name] == 0.0)
    assert np.ptp(result["RotSpeed"]) == 0.0
    for name in FREEDOMS:
        alone = DynamicTurbine(turbine=nrel, freedoms=[name], step=0.0125)
        result = simulate(alone, sheared(12.0), controller, 2.0, start=START)
        moved = {
            "rotor-speed": np.ptp(result["RotSpeed"]),
            "tower-fore-aft": np.ptp(result["TTDspFA"]),
            "tower-side-side": np.ptp(result["TTDspSS"]),
            "blade-flap": np.ptp(result["OoPDefl1"]),
            "blade-edge": np.ptp(result["IPDefl1"]),
            "shaft-torsion": np.ptp(result["LSShftTwst"]),
        }
        assert moved[name] > 0.0
        others = set(FREEDOMS[:3]) | {"shaft-torsion"}
        assert all(moved[other] == 0.0 for other in others - {name})


def test_shaft_torsion_carries_the_torque(nrel, sheared, controller) -> None:
    """Twist at rest is torque over stiffness; the free-free frequency stands in the twist."""
    dynamic = DynamicTurbine(turbine=nrel, freedoms=FREEDOMS, step=0.0125)
    result = simulate(dynamic, sheared(12.0), controller, 120.0, start=START)
    rows = result.after(60.0)
    twist = rows[:, result.place("LSShftTwst")].mean()
    torque = rows[:, result.place("RotTorq")].mean()
    assert -twist * 867637e3 == pytest.approx(torque, rel=1e-3)


def test_actuator_limits_hold(nrel, sheared, controller) -> None:
    actuator = PitchActuator(
        lowest=math.radians(2.0),
        highest=math.radians(5.0),
        rate=math.radians(1.0),
        time_constant=0.4,
    )
    dynamic = DynamicTurbine(turbine=nrel, actuator=actuator, step=0.025)
    result = simulate(
        dynamic,
        TransientField(mean=sheared(12.0), time=[0.0, 5.0, 5.1], speed=[11.0, 11.0, 16.0]),
        controller,
        12.0,
        start=START,
        interval=0.025,
    )
    pitch = result["BldPitch1"]
    assert pitch.max() <= math.radians(5.0) + 1e-12
    assert pitch.min() >= math.radians(2.0) - 1e-12
    assert np.abs(np.diff(pitch)).max() <= math.radians(1.0) * 0.025 + 1e-12


def test_gains_that_destabilise_end_the_run(dynamic, sheared, controller) -> None:
    """Positive feedback: status, time, no NaN, statistics of what was."""

    class Runaway:
        def start(self, step, measured):
            self.integral = 0.0

        def command(self, measured):
            command = np.zeros(COMMANDS)
            command[PITCH_COMMAND:] = -0.3 * (measured[GENERATOR_SPEED] - 120.0)
            return command  # and no torque

    for bad, wind, reason in (
        (Runaway(), 20.0, "times its rated speed"),
        (gains(controller, proportional=100.0), 14.0, "races back and forth"),
        (gains(controller, integral=20.0), 14.0, "races back and forth"),
    ):
        result = simulate(dynamic, sheared(wind), bad, 300.0, start=START, interval=0.25)
        assert result.status == "diverged"
        assert result.diverged_at is not None
        assert 1.0 < result.diverged_at < 150.0
        assert f"diverged at {result.diverged_at:g} s" in result.message
        assert reason in result.message
        assert np.all(np.isfinite(result.values))
        assert result.time[-1] <= result.diverged_at
        for line in statistics(result, skip=1.0).values():
            assert all(math.isfinite(x) for x in (line.mean, line.std, line.least, line.largest))


def test_step_that_is_too_long_is_no_result(nrel, sheared, controller) -> None:
    """The loop stays bounded past its stability limit, and follows the step instead of physics."""
    tower = {}
    for step in (0.02, 0.07, 0.1):
        dynamic = DynamicTurbine(turbine=nrel, step=step)
        result = simulate(dynamic, sheared(14.0), controller, 60.0, start=START)
        tower[step] = result["TwrBsMyt"][result.time >= 30.0].mean()
        assert (result.status == "diverged") == (step == 0.1)
    assert tower[0.07] == pytest.approx(tower[0.02], rel=0.01)
    assert abs(tower[0.1] / tower[0.02] - 1.0) > 0.1
    assert "the step of 0.1 s is too long" in result.message
    assert result.diverged_at == pytest.approx(60.0)
    assert np.all(np.isfinite(result.values))


def gains(controller: TurbineController, **factors: float) -> TurbineController:
    """The controller with gains of its pitch regulator multiplied."""
    pitch = controller.pitch
    changes = {name: getattr(pitch, name) * factor for name, factor in factors.items()}
    return dataclasses.replace(controller, pitch=dataclasses.replace(pitch, **changes))


def test_healthy_loops_do_not_count_as_diverged(dynamic, sheared, controller) -> None:
    """A gust, ways from and to feather, and gains three times too large are results."""
    gust = TransientField(mean=sheared(12.0), time=[20.0, 25.0, 30.0], speed=[12.0, 22.0, 12.0])
    assert simulate(dynamic, gust, controller, 60.0, start=START).status == "finished"
    lively = gains(controller, proportional=3.0)
    assert simulate(dynamic, sheared(14.0), lively, 120.0, start=START).status == "finished"

    class Shutdown:
        def start(self, step, measured):
            pass

        def command(self, measured):
            command = np.zeros(COMMANDS)
            command[PITCH_COMMAND:] = math.radians(90.0)
            return command

    assert simulate(dynamic, sheared(12.0), Shutdown(), 60.0, start=START).status == "finished"
    # 43 s at the limit of a slow actuator, but one way only; the baseline's constant power above
    # one degree of pitch would brake a slow rotor past standstill
    patient = dataclasses.replace(
        controller, torque=dataclasses.replace(controller.torque, region3_pitch=math.inf)
    )
    slow = PitchActuator(lowest=0.0, highest=math.radians(90.0), rate=math.radians(2.0))
    started = simulate(
        DynamicTurbine(turbine=dynamic.turbine, actuator=slow),
        sheared(9.0),
        patient,
        60.0,
        start=Start(rotor_speed=0.3, pitch=math.radians(89.0)),
    )
    assert started.status == "finished"
    rate = np.diff(started["BldPitch1"]) / started.interval
    assert np.count_nonzero(rate < -0.99 * slow.rate) * started.interval > 40.0


def test_box_that_ends_must_reach_as_far_as_the_blades(nrel, controller) -> None:
    """Wind that is not along the shaft meets blades far upwind and downwind of the tower."""

    def run(direction: float, yaw: float, offset: float):
        box = TurbulenceBox(
            velocity=np.zeros((60, 3, 3, 3)),
            spacing=3.0,
            y=np.array([-80.0, 0.0, 80.0]),
            z=np.array([5.0, 90.0, 175.0]),
            mean_speed=12.0,
            offset=offset,
        )
        mean = StaticField(speed=12.0, hub_height=90.0, direction=direction)
        turning = DynamicTurbine(turbine=nrel, yaw=yaw)
        return simulate(
            turning, TurbulentField(mean=mean, box=box), controller, 2.0, start=START
        ).status

    assert run(0.5, 0.5, 3.0) == run(0.0, 0.0, 3.0) == run(0.5, 0.0, 13.0) == "finished"
    for direction, yaw in ((0.5, 0.0), (0.0, 0.5), (-0.5, 0.0)):
        with pytest.raises(InputError, match="offset: got 3 in a box that is not periodic"):
            run(direction, yaw, 3.0)


def blades(turbine, number: int):
    return dataclasses.replace(turbine, rotor=dataclasses.replace(turbine.rotor, blades=number))


def test_bad_input(dynamic, sheared, turbulent, controller, nrel) -> None:
    good = {"start": START}
    cases = [
        ((sheared(2.0), controller, 10.0), good, r"mean speed of 2 m/s .* cut-in at 3 m/s"),
        ((sheared(26.0), controller, 10.0), good, r"mean speed of 26 m/s .* cut-out at 25 m/s"),
        ((sheared(12.0), controller, 0.0), good, r"duration: got 0\.0"),
        ((sheared(12.0), controller, 0.001), good, r"at least one step of 0\.025 s"),
        ((turbulent(1), controller, 61.0), good, r"repeats after 60 s"),
        ((None, controller, 10.0), good, r"wind: got NoneType, expected a StaticField"),
        (
            (sheared(12.0), "tuned", 10.0),
            good,
            r"controller: got str, expected an object with start",
        ),
        ((sheared(12.0), controller, 10.0), good | {"interval": 0.0}, "interval: got 0"),
    ]
    for arguments, options, message in cases:
        with pytest.raises(InputError, match=message):
            simulate(dynamic, *arguments, **options)
    assert simulate(dynamic, sheared(26.0), controller, 1.0, start=START, any_wind=True)
    assert simulate(dynamic, turbulent(1), controller, 61.0, start=START, repeat=True)
    small = kaimal_box(
        12.0,
        20.0,
        0.5,
        hub_height=90.0,
        width=80.0,
        points=(3, 3),
        seed=1,
    )
    with pytest.raises(InputError, match="smaller than the rotor"):
        simulate(
            dynamic, TurbulentField(mean=sheared(12.0), box=small), controller, 10.0, start=START
        )
    for options, message in (
        ({"freedoms": ["flap"]}, "freedoms: got 'flap', expected names out of rotor-speed"),
        ({"freedoms": "blade-flap"}, "expected several names"),
        ({"inflow": "frozen"}, "inflow: got 'frozen'"),
        ({"step": 0.0}, "step: got 0"),
        ({"yaw": 2.0}, "yaw: got 2"),
        ({"generator_inertia": -1.0}, "generator_inertia: got -1"),
        ({"turbine": None}, "turbine: got NoneType"),
        ({"turbine": blades(nrel, 2)}, "got 2 blades, expected 3"),
        ({"turbine": blades(nrel, 4)}, "got 4 blades, expected 3"),
    ):
        with pytest.raises(InputError, match=message):
            DynamicTurbine(**({"turbine": nrel} | options))
    with pytest.raises(InputError, match="rotor_speed: got -1"):
        Start(rotor_speed=-1.0)
    run = TurbineRun(dynamic, sheared(12.0), rotor_speed=1.2)
    with pytest.raises(InputError, match=r"command: got shape \(2,\)"):
        run.advance(np.zeros(2))
    with pytest.raises(InputError, match="expected finite numbers"):
        run.advance(np.full(COMMANDS, np.nan))
    with pytest.raises(InputError, match="channel: got 'Nothing'"):
        simulate(dynamic, sheared(12.0), controller, 1.0, start=START)["Nothing"]
    with pytest.raises(InputError, match="which leaves 0 rows"):
        statistics(simulate(dynamic, sheared(12.0), controller, 1.0, start=START))


def test_steady_start_of_every_wind(dynamic) -> None:
    operation = Operation(dynamic)
    low, high = operation.start(5.0), operation.start(18.0)
    assert low.pitch == 0.0
    assert low.rotor_speed < high.rotor_speed == pytest.approx(1.2671, rel=1e-3)
    assert high.pitch == pytest.approx(math.radians(14.8), abs=0.01)
    assert high.torque == pytest.approx(43.09e3, rel=0.005)
    whole = Operation(dynamic)
    assert whole.curve.wind_speed.size == 23
    for speed in (2.0, 3.0, 5.0, 11.0, 18.6, 25.0, 30.0):  # with the whole curve and without
        assert operation.start(speed) == whole.start(speed)


def test_a_run_starts_at_rest_under_its_loads(dynamic, sheared, controller) -> None:
    """Accelerations of the structure vanish at the start, and the tower rings little."""
    run = TurbineRun(dynamic, sheared(12.0), rotor_speed=1.267, pitch=0.05, torque=43e3)
    run.settle()
    structure = [0, 1, *range(4, 10)]
    assert np.abs(run.state.a[structure]).max() < 1e-9
    assert run.state.q[0] == pytest.approx(0.35, abs=0.05)
    result = simulate(dynamic, sheared(12.0), controller, 60.0, start=START)
    early, late = (np.ptp(result["TwrBsMyt"][part]) for part in (slice(0, 400), slice(800, 1200)))
    assert early < 0.3 * result["TwrBsMyt"].mean()
    assert result["TTDspFA"][0] > 0.3
    assert late < 0.3 * result["TwrBsMyt"].mean()


def test_a_rotor_that_turns_backward_ends_the_run(dynamic, sheared) -> None:
    """A generator that drives: torque without wind brakes the rotor past standstill."""

    class Brake:
        def start(self, step, measured):
            pass

        def command(self, measured):
            command = np.zeros(COMMANDS)
            command[TORQUE], command[PITCH_COMMAND:] = 47e3, math.radians(60.0)
            return command

    result = simulate(dynamic, sheared(5.0), Brake(), 120.0, start=START)
    assert result.status == "diverged"
    assert "turns backward" in result.message


def test_generator_inertia_of_ones_own(nrel) -> None:
    turbine = dataclasses.replace(
        nrel, drivetrain=dataclasses.replace(nrel.drivetrain, generator_inertia=None)
    )
    with pytest.raises(InputError, match="generator inertia is not known"):
        DynamicTurbine(turbine=turbine)
    own = DynamicTurbine(turbine=turbine, generator_inertia=534.116)
    assert own.rotor_inertia == DynamicTurbine(turbine=nrel).rotor_inertia
