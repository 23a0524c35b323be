"""Aerodynamics of the loop: the static rotor as its limit, dynamic inflow, power."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from pitchopt.aero.polars import Polar
from pitchopt.aero.static_rotor import StaticRotor
from pitchopt.control import PitchActuator
from pitchopt.control.signals import COMMANDS, PITCH_COMMAND
from pitchopt.sim import DynamicTurbine, TurbineRun, simulate
from pitchopt.sim.simulate import Start
from pitchopt.turbines import load_turbine
from windfield import PowerLaw, StaticField, TowerShadow, TransientField


def rigid_turn(turbine, wind, speed: float, pitch: float, *, yaw: float = 0.0, skew: bool = True):
    """Aerodynamic force and moment of blade 1 over a revolution, apex, its coned frame."""
    steps = 72
    dynamic = DynamicTurbine(
        turbine=turbine,
        freedoms=(),
        inflow="quasi-steady",
        yaw=yaw,
        skew=skew,
        actuator=PitchActuator(lowest=-0.1, highest=1.5, rate=1.0),
        step=2 * math.pi / speed / steps,
    )
    run = TurbineRun(dynamic, wind, rotor_speed=speed, pitch=pitch)
    command = np.zeros(COMMANDS)
    command[PITCH_COMMAND:] = pitch
    force, moment = np.empty((2, steps, 3))
    for k in range(steps):
        assert run.advance(command)
        force[k], moment[k] = run.work.rotor.force[0], run.work.rotor.moment[0]
    azimuth = 2 * math.pi * (np.arange(steps) + 1) / steps
    return azimuth, force, moment


@pytest.mark.parametrize(
    ("key", "speed", "wind", "pitch_deg", "yaw_deg"),
    [
        ("nrel-5mw", 1.2671, 15.0, 10.45, 0.0),
        ("nrel-5mw", 0.9634, 8.0, 0.0, 8.0),
        ("nrel-5mw", 0.9, 6.0, -2.0, 0.0),
        ("iea-15-240", 0.7, 9.0, 0.0, 0.0),
    ],
)
def test_static_rotor_is_the_limit(key, speed, wind, pitch_deg, yaw_deg) -> None:
    """All structure locked, quasi-steady: the loads of the static rotor in momentum balance."""
    turbine = load_turbine(key)
    tower = turbine.tower
    field = StaticField(
        speed=wind,
        hub_height=turbine.rotor.hub_height,
        vertical=PowerLaw(exponent=0.2),
        tower=TowerShadow(radius=tower.radius, height=tower.height - tower.base, top=tower.top),
    )
    pitch, yaw = math.radians(pitch_deg), math.radians(yaw_deg)
    azimuth, force, moment = rigid_turn(turbine, field, speed, pitch, yaw=yaw)
    static = StaticRotor(
        rotor=turbine.rotor,
        wind=field,
        rotor_speed=speed,
        air_density=turbine.air_density,
        yaw=yaw,
        induction="equilibrium",
        skew=True,
    )
    loads = static.blade_loads(azimuth, np.full(azimuth.size, pitch))
    cone = turbine.rotor.cone
    assert moment[:, 1] == pytest.approx(loads.bending, rel=3e-5)
    assert math.cos(cone) * force[:, 0] == pytest.approx(loads.thrust, rel=3e-5)
    torque = math.cos(cone) * moment[:, 0] - math.sin(cone) * moment[:, 2]
    assert torque == pytest.approx(loads.torque, abs=3e-5 * np.abs(loads.torque).max())


def test_narrow_polars_keep_their_end_values(nrel) -> None:
    """Beyond its ends a polar is constant: in the momentum balance as well as in the loads."""
    blade = nrel.rotor.blade
    short, long = {}, {}
    for polar in blade.polars:
        part = np.abs(polar.alpha) <= math.radians(6.0)
        if np.count_nonzero(part) < 3:  # cylinders
            short[id(polar)] = long[id(polar)] = polar
            continue
        alpha, cl, cd = polar.alpha[part], polar.cl[part], polar.cd[part]
        short[id(polar)] = Polar(alpha=alpha, cl=cl, cd=cd)
        long[id(polar)] = Polar(
            alpha=np.concatenate([[-math.pi], alpha, [math.pi]]),
            cl=np.pad(cl, 1, mode="edge"),
            cd=np.pad(cd, 1, mode="edge"),
        )

    def turn(polars):
        rotor = dataclasses.replace(
            nrel.rotor,
            blade=dataclasses.replace(blade, polars=tuple(polars[id(p)] for p in blade.polars)),
        )
        turbine = dataclasses.replace(nrel, rotor=rotor)
        dynamic = DynamicTurbine(turbine=turbine, freedoms=(), inflow="quasi-steady")
        wind = StaticField(speed=12.0, hub_height=90.0, vertical=PowerLaw(exponent=0.2))
        run = TurbineRun(dynamic, wind, rotor_speed=1.2)
        command = np.zeros(COMMANDS)
        for _ in range(100):
            run.advance(command)
        counts = run.state.inflow.counts
        return run.work.rotor.moment.copy(), counts[0] / counts[1]

    (moment, evaluations), (expected, as_many) = turn(short), turn(long)
    np.testing.assert_allclose(moment, expected, rtol=1e-12)
    assert evaluations == as_many


def test_induced_velocity_answers_a_step(nrel) -> None:
    """Closed form of the two-stage filter for a step of the quasi-steady induced velocity.

    W_int jumps by k = 0.6 of the step and follows with tau_1, W with tau_2 behind it.
    """
    from pitchopt.sim import kernels_planes as kernels

    wind = TransientField(
        mean=StaticField(speed=1.0, hub_height=90.0), time=[0.0, 1.0, 1.001], speed=[12, 12, 12.5]
    )
    turbine = dataclasses.replace(nrel, rotor=dataclasses.replace(nrel.rotor, tilt=0.0, cone=0.0))
    dynamic = DynamicTurbine(turbine=turbine, freedoms=(), inflow="dynamic", step=0.01)
    run = TurbineRun(dynamic, wind, rotor_speed=1.267, pitch=0.05)
    command = np.zeros(COMMANDS)
    command[PITCH_COMMAND:] = 0.05
    inflow = run.state.inflow

    def normal(place: int) -> float:
        """Normal component of an induced velocity at station 12 of blade 1."""
        return float(inflow.planes[place + 12])

    for _ in range(100):
        run.advance(command)
    before = normal(kernels.M_INDUCED)
    assert before == pytest.approx(normal(kernels.M_QUASI), rel=1e-6)
    run.advance(command)
    after = normal(kernels.M_QUASI)
    assert abs(after - before) > 0.02
    tau1 = 1.1 / (1.0 - 1.3 * inflow.disc[0]) * 63.0 / inflow.disc[1]
    share = run.dynamic.turbine.rotor.blade.span[12] + 1.5
    tau2 = (0.39 - 0.26 * (share / 63.0) ** 2) * tau1
    for seconds in (0.5, 2.0, 6.0):
        while run.time < 1.0 + seconds - 1e-9:
            run.advance(command)
        t = seconds
        slow = -0.4 / (1.0 - tau2 / tau1)
        fast = -1.0 - slow
        expected = after + (after - before) * (
            slow * math.exp(-t / tau1) + fast * math.exp(-t / tau2)
        )
        assert normal(kernels.M_INDUCED) == pytest.approx(expected, abs=0.01 * abs(after - before))


def test_thrust_overshoots_only_with_dynamic_inflow(nrel, sheared) -> None:
    """After a step of pitch the thrust dips and recovers as the wake follows."""
    dips = {}
    for inflow in ("dynamic", "quasi-steady"):
        dynamic = DynamicTurbine(turbine=nrel, freedoms=(), inflow=inflow, step=0.025)
        wind = dataclasses.replace(sheared(8.0), tower=None)
        run = TurbineRun(dynamic, wind, rotor_speed=0.96)
        command = np.zeros(COMMANDS)
        thrust = []
        for k in range(2400):
            command[PITCH_COMMAND:] = 0.0 if k < 400 else math.radians(3.0)
            run.advance(command)
            thrust.append(run.outputs()[run.dynamic.channels.index(channel(run, "RtAeroFxh"))])
        series = np.array(thrust)
        step = series[300:400].mean() - series[-400:].mean()
        dips[inflow] = (series[-400:].mean() - series[400:600].min()) / step
    assert dips["dynamic"] > 0.3
    assert dips["quasi-steady"] < 0.15


def channel(run: TurbineRun, name: str):
    return next(c for c in run.dynamic.channels if c.name == name)


def test_power_balance(dynamic, sheared, controller) -> None:
    """Over whole revolutions of a steady run: wind gives what generator and dampers take.

    Aerodynamic power on the rotor is torque times speed; blades and tower swing, and the work
    on them goes to their damping.  What is left over is less than half a per cent.
    """
    result = simulate(
        dynamic,
        sheared(14.0),
        controller,
        200.0,
        start=Start(rotor_speed=1.267, pitch=0.143, torque=43e3),
    )
    rows = result.after(150.0)
    speed = rows[:, result.place("RotSpeed")]
    given = (rows[:, result.place("RtAeroMxh")] * speed).mean()
    taken = (rows[:, result.place("GenTq")] * rows[:, result.place("GenSpeed")]).mean()
    shaft = (rows[:, result.place("RotTorq")] * speed).mean()
    assert shaft == pytest.approx(taken, rel=2e-4)
    assert given == pytest.approx(taken, rel=5e-3)
