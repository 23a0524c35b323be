"""One run of the dynamic turbine: start, march, result."""

from __future__ import annotations

from typing import Any

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.control.signals import COMMANDS, MEASURED
from pitchopt.sim.turbine import DynamicTurbine
from pitchopt.sim.wind import Wind, wind_tables

__all__ = ["TurbineRun"]


class TurbineRun:
    """A turbine in a wind, at some instant: state, scratch and model of the time loop.

    Parameters
    ----------
    dynamic : DynamicTurbine
    wind : StaticField, TransientField or TurbulentField
    rotor_speed : float
        At the start [rad/s].
    pitch : float or (B,)
        At the start [rad].
    torque : float
        Of the generator, high-speed side, at the start [N m].
    azimuth : float
        Of blade 1 at the start [rad].
    """

    def __init__(
        self,
        dynamic: DynamicTurbine,
        wind: Wind,
        *,
        rotor_speed: float,
        pitch: float | FloatArray = 0.0,
        torque: float = 0.0,
        azimuth: float = 0.0,
    ) -> None:
        from pitchopt.sim.kernels_march import Model, begin

        self.dynamic = dynamic
        low, high, _, _ = dynamic.reach
        turbine, tower = dynamic.turbine, dynamic.tower
        assert dynamic.actuator is not None and dynamic.generator_lag is not None
        self.model = Model(
            rotor=dynamic.rotor_tables,
            wind=wind_tables(wind, low=low, high=high),
            body=dynamic.body_tables,
            actuator=dynamic.actuator.parameters(dynamic.step),
            torque_keep=dynamic.generator_lag.keep(dynamic.step),
            step=dynamic.step,
            gear_ratio=turbine.drivetrain.gear_ratio,
            efficiency=dynamic.efficiency,
            hub_height=turbine.rotor.hub_height,
            base=turbine.tower.base,
            heights=tower.height,
            tower_shape=tower.shape,
            tower_inertia_force=tower.inertia_force,
            tower_inertia_moment=tower.inertia_moment,
            tower_weight_moment=tower.weight_moment,
            tower_mass_above=tower.mass_above,
            tip_shape=dynamic.blade.tip_shape,
            fastest=4.0 * turbine.rated_rotor_speed,
            largest=0.5 * turbine.rotor.radius,
        )
        self.state = _state(dynamic, rotor_speed, pitch, torque, azimuth)
        self.work = _work(dynamic)
        begin(self.model, self.state, self.work)

    @property
    def time(self) -> float:
        """Now [s]."""
        return float(self.state.count[0] * self.model.step)


def _state(
    dynamic: DynamicTurbine,
    rotor_speed: float,
    pitch: float | FloatArray,
    torque: float,
    azimuth: float,
) -> Any:
    from pitchopt.sim.kernels_march import State
    from pitchopt.sim.kernels_motion import AZIMUTH, BLADES
    from pitchopt.sim.kernels_rotor import MEMORY_PLANES, PLANE, InflowState

    blades, stations = dynamic.blades, dynamic.turbine.rotor.blade.span.size
    size = BLADES + 2 * blades
    q, v = np.zeros(size), np.zeros(size)
    q[AZIMUTH], v[AZIMUTH] = azimuth, rotor_speed
    return State(
        q=q,
        v=v,
        a=np.zeros(size),
        before=np.zeros(size),
        pitch=np.full(blades, pitch, dtype=np.float64),
        pitch_rate=np.zeros(blades),
        torque=np.array([torque], dtype=np.float64),
        count=np.zeros(1, dtype=np.int64),
        error=np.zeros(size),
        scale=np.zeros(size),
        inflow=InflowState(
            row=np.zeros((blades, stations), dtype=np.int64),
            planes=np.zeros(MEMORY_PLANES * PLANE),
            disc=np.zeros(4),
            counts=np.zeros(3, dtype=np.int64),
        ),
    )


def _work(dynamic: DynamicTurbine) -> Any:
    from pitchopt.sim.kernels_march import Work
    from pitchopt.sim.kernels_motion import BLADES, MotionWork
    from pitchopt.sim.kernels_rotor import PLANE, WORK_PLANES, RotorWork

    blades = dynamic.blades
    size = BLADES + 2 * blades
    return Work(
        rotor=RotorWork(
            frame=np.zeros((blades, 3, 3)),
            axes=np.zeros((3, 3)),
            apex=np.zeros(3),
            apex_velocity=np.zeros(3),
            spin=np.zeros(3),
            angle=np.zeros(blades),
            tower=np.zeros(3),
            planes=np.zeros(WORK_PLANES * PLANE),
            force=np.zeros((blades, 3)),
            moment=np.zeros((blades, 3)),
            modal=np.zeros((blades, 2)),
            disc_wind=np.zeros(3),
        ),
        motion=MotionWork(
            turn=np.zeros((3, 3)),
            hub=np.zeros(3),
            nacelle=np.zeros(3),
            nacelle_spin=np.zeros(3),
            shape_force=np.zeros((blades, 2, 2)),
            shape_lever=np.zeros((blades, 2, 2)),
            shape_coupling=np.zeros((blades, 2, 2, 2, 2)),
            matrix=np.zeros((size, size)),
            right=np.zeros(size),
            inertial=np.zeros((blades, 8)),
            w=np.zeros((3, 3)),
            c=np.zeros((2, 2, 3)),
        ),
        q=np.zeros(size),
        v=np.zeros(size),
        bend=np.zeros((blades, 2)),
        bend_rate=np.zeros((blades, 2)),
        root=np.zeros((blades, 6)),
        hub=np.zeros(6),
        top=np.zeros(6),
        scratch=np.zeros((6, 3)),
        measured=np.zeros(MEASURED),
        command=np.zeros(COMMANDS),
    )
