"""Offset that decouples tilt from yaw: closed forms, the sampled loop, and the turbine itself."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.control import PitchActuator, decoupling_offset
from pitchopt.errors import InputError
from pitchopt.sim import DynamicTurbine, Operation
from pitchopt.studies.tuning import (
    FixedFrameResponse,
    fixed_frame_response,
    measure_decoupling,
    sampled_offset,
)
from pitchopt.turbines import load_turbine

STEP = 0.025
SETTLED = 10.0  # of a rigid rotor: the actuators' lag alone [s]


def straight(turbine):
    """Aerodynamic centres on the pitch axis, the rotor upright."""
    blade = turbine.rotor.blade
    zeros = np.zeros(blade.span.size)
    blade = dataclasses.replace(blade, sweep=zeros, prebend=zeros)
    rotor = dataclasses.replace(turbine.rotor, blade=blade, tilt=0.0, cone=0.0)
    return dataclasses.replace(turbine, rotor=rotor)


def rigid(turbine, lag):
    return DynamicTurbine(
        turbine=turbine,
        freedoms=(),
        inflow="quasi-steady",
        skew=False,
        step=STEP,
        actuator=PitchActuator(
            lowest=-0.1, highest=1.5, rate=turbine.pitch_rate, time_constant=lag or None
        ),
    )


@given(
    angle=st.floats(-3.0, 3.0),
    order=st.sampled_from([1, 2]),
    offset=st.floats(-0.5, 0.5),
    size=st.floats(1e5, 1e9),
)
def test_a_pure_turn_is_found_whatever_the_offset_it_was_measured_with(angle, order, offset, size):
    turn = order * offset - angle
    c, s = math.cos(turn), math.sin(turn)
    response = FixedFrameResponse(
        order=order, offset=offset, matrix=-size * np.array([[c, s], [-s, c]])
    )
    gap = order * response.decoupling_offset - angle
    assert math.remainder(gap, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
    assert response.coupling == pytest.approx(abs(s), abs=1e-12)
    assert response.relative_gain == pytest.approx(c * c, abs=1e-12)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("lag", [0.0, 0.4])
def test_the_sampled_loop_tends_to_the_closed_form(order, lag):
    closed = decoupling_offset(order, 1.2, lag)
    gaps = [sampled_offset(order, 1.2, lag, step) - closed for step in (0.02, 0.01, 0.005)]
    assert gaps[0] > gaps[1] > gaps[2] > 0.0
    assert gaps[1] / gaps[2] == pytest.approx(2.0, rel=0.01)
    assert sampled_offset(order, 1.2, 0.0, 0.02) == pytest.approx(1.2 * 0.02, rel=1e-12)


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("lag", [0.0, 0.4])
def test_closed_form_on_a_rigid_rotor(order, lag):
    dynamic = rigid(straight(load_turbine("nrel-5mw")), lag)
    operation = Operation(dynamic)
    found = fixed_frame_response(dynamic, 15.0, order=order, settling=SETTLED, operation=operation)
    omega = operation.start(15.0).rotor_speed
    expected = sampled_offset(order, omega, lag, STEP)
    assert math.degrees(found.decoupling_offset - expected) == pytest.approx(0.0, abs=1e-5)
    # the closed form itself, up to one step of the controller
    closed = decoupling_offset(order, omega, lag)
    assert 0.0 < found.decoupling_offset - closed < 1.01 * omega * STEP
    assert found.matrix[0, 0] < 0.0


@pytest.mark.slow
def test_the_offset_decouples_tilt_from_yaw():
    dynamic = rigid(load_turbine("nrel-5mw"), 0.4)
    operation = Operation(dynamic)
    omega = operation.start(15.0).rotor_speed
    offsets = np.array([-0.2, 0.0, 0.3, sampled_offset(1, omega, 0.4, STEP), 0.8])
    found = measure_decoupling(dynamic, 15.0, offsets, settling=SETTLED, operation=operation)
    best = found.decoupling_offset
    np.testing.assert_allclose(found.coupling, np.abs(np.sin(offsets - best)), atol=2e-3)
    assert int(np.argmin(found.coupling)) == 3
    assert found.coupling[3] < 0.01
    assert found.coupling[1] > 0.4
    assert found.responses[3].relative_gain == pytest.approx(1.0, abs=1e-4)
    # aerodynamic centres ahead of the pitch axis feel the pitch rate: 0.3 to 0.5 m at 40 m
    assert 0.3 / 45.0 < best - offsets[3] < 0.5 / 40.0


@pytest.mark.slow
def test_iea_15_mw_with_all_freedoms_beside_the_published_offset():
    """24.5 degrees at 15 m/s, published for OpenFAST with all degrees of freedom."""
    turbine = load_turbine("iea-15-240")
    offsets = {}
    for lag in (0.0, 0.4):
        dynamic = DynamicTurbine(
            turbine=turbine,
            actuator=PitchActuator(
                lowest=-0.1, highest=1.5, rate=turbine.pitch_rate, time_constant=lag or None
            ),
        )
        offsets[lag] = math.degrees(fixed_frame_response(dynamic, 15.0).decoupling_offset)
    assert offsets[0.0] == pytest.approx(24.5, abs=2.0)
    omega = turbine.rated_rotor_speed
    actuators = math.degrees(decoupling_offset(1, omega, 0.4))
    assert offsets[0.4] - offsets[0.0] == pytest.approx(actuators, abs=1.0)


@pytest.mark.parametrize(
    ("call", "word"),
    [
        (lambda d: fixed_frame_response(d, 15.0, order=3), "multiple of three"),
        (lambda d: fixed_frame_response(d, -1.0), "wind_speed"),
        (lambda d: measure_decoupling(d, 15.0, []), "offset"),
        (lambda _: sampled_offset(1, 1.0, 0.4, 0.0), "step"),
    ],
)
def test_bad_input(call, word):
    with pytest.raises(InputError, match=word):
        call(rigid(load_turbine("nrel-5mw"), 0.4))
