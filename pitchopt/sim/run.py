"""A run in progress: state, scratch and model of the compiled time loop.

`TurbineRun` is what `simulate` marches and what a caller steps by hand, command by command.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.control.signals import COMMANDS, MEASURED
from pitchopt.errors import ComputationError, InputError
from pitchopt.sim.turbine import DynamicTurbine
from pitchopt.sim.wind import Wind, wind_tables

__all__ = ["OVERSPEED", "TurbineRun"]

_SETTLE_ROUNDS = 4
_SETTLE_STEP = 1e-3  # of the differences [m]

OVERSPEED = 2.0  # times rated: no controller holds the rotor any more


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
        turbine, tower = dynamic.turbine, dynamic.tower
        actuator = dynamic.actuator
        assert actuator is not None and dynamic.generator_lag is not None
        for angle in np.ravel(np.asarray(pitch, dtype=np.float64)):
            if not actuator.lowest - 1e-9 <= angle <= actuator.highest + 1e-9:
                raise InputError(
                    f"pitch: got {np.rad2deg(angle):.4g} deg at the start, expected "
                    f"{np.rad2deg(actuator.lowest):.4g} to {np.rad2deg(actuator.highest):.4g} deg, "
                    "the range of the actuators"
                )
        self.model = Model(
            rotor=dynamic.rotor_tables,
            wind=wind_tables(wind, dynamic.reach),
            body=dynamic.body_tables,
            actuator=actuator.parameters(dynamic.step),
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
            fastest=OVERSPEED * turbine.rated_rotor_speed,
            largest=0.5 * turbine.rotor.radius,
        )
        self.state = _state(dynamic, rotor_speed, pitch, torque, azimuth)
        self.work = _work(dynamic)
        if not begin(self.model, self.state, self.work):
            raise ComputationError(
                f"turbine {turbine.name!r}: the equations of motion are singular at the start"
            )

    @property
    def time(self) -> float:
        """Now [s]."""
        return float(self.state.count[0] * self.model.step)

    def settle(self) -> None:
        """Deflect tower and blades to where they would rest, rotor speed and azimuth held.

        Newton's method on the accelerations, which vanish there; without it a run begins with
        the ringing of an undeflected structure under full load.  A structure that finds no rest
        within half of what counts as diverged stays as it was.
        """
        from pitchopt.sim.kernels_body import AZIMUTH, TWIST
        from pitchopt.sim.kernels_march import begin

        state = self.state
        moving = np.flatnonzero(self.model.body.active)
        moving = moving[(moving != AZIMUTH) & (moving != TWIST)]
        before = state.q.copy()

        def acceleration() -> FloatArray:
            state.inflow.disc[3] = 0.0  # the wake settles too
            begin(self.model, state, self.work)
            return np.array(state.a[moving])

        for _ in range(_SETTLE_ROUNDS):
            at = acceleration()
            slopes = np.empty((moving.size, moving.size))
            for j, place in enumerate(moving):
                state.q[place] += _SETTLE_STEP
                slopes[:, j] = (acceleration() - at) / _SETTLE_STEP
                state.q[place] -= _SETTLE_STEP
            state.q[moving] -= np.linalg.solve(slopes, at) if moving.size else 0.0
        if not np.all(np.abs(state.q[moving]) < 0.5 * self.model.largest):
            state.q[:] = before
        acceleration()
        state.inflow.counts[:] = 0

    def measured(self) -> FloatArray:
        """What a controller sees now (MEASURED,), see `pitchopt.control.signals`."""
        from pitchopt.sim.kernels_march import measure

        measure(self.model, self.state, self.work, self.work.measured)
        return np.array(self.work.measured, dtype=np.float64)

    def outputs(self) -> FloatArray:
        """All channels now (C,), SI units, in the order of `DynamicTurbine.channels`."""
        from pitchopt.sim.kernels_march import output

        out = np.zeros(len(self.dynamic.channels))
        output(self.model, self.state, self.work, out)
        return out

    def advance(self, command: FloatArray) -> bool:
        """One step under a command (COMMANDS,); False if the run has diverged in it.

        Raises
        ------
        InputError
            If the command has another shape or its torque is not finite.
        """
        from pitchopt.sim.kernels_march import RUNNING, advance

        vector = np.asarray(command, dtype=np.float64)
        if vector.shape != (COMMANDS,):
            raise InputError(f"command: got shape {vector.shape}, expected ({COMMANDS},)")
        if not np.all(np.isfinite(vector)):
            raise InputError(
                f"command: got {vector.tolist()} at {self.time:g} s, expected finite numbers"
            )
        return bool(advance(self.model, self.state, self.work, vector) == RUNNING)

    def snapshot(self) -> dict[str, FloatArray]:
        """Copy of all that `restore` needs to go on from here to the last bit."""
        return {name: array.copy() for name, array in _arrays(self.state, self.work)}

    def restore(self, snapshot: Mapping[str, FloatArray]) -> None:
        """Go back to a snapshot of a run of the same turbine in the same wind.

        Raises
        ------
        InputError
            If an array is missing or has another shape.
        """
        for name, array in _arrays(self.state, self.work):
            if name not in snapshot or snapshot[name].shape != array.shape:
                raise InputError(
                    f"snapshot: array {name!r} is missing or of another shape than "
                    f"{array.shape}; it belongs to another turbine"
                )
            array[...] = snapshot[name]


def _arrays(state: Any, work: Any) -> Iterator[tuple[str, Any]]:
    """State of the loop by name, the loads of the last step included."""
    for name, value in state._asdict().items():
        if name == "inflow":
            yield from ((f"inflow.{key}", array) for key, array in value._asdict().items())
        else:
            yield name, value
    for name in ("root", "hub", "top"):
        yield f"loads.{name}", getattr(work, name)
    for name in ("force", "moment", "disc_wind", "axes", "frame"):
        yield f"rotor.{name}", getattr(work.rotor, name)
    yield "motion.turn", work.motion.turn


def _state(
    dynamic: DynamicTurbine,
    rotor_speed: float,
    pitch: float | FloatArray,
    torque: float,
    azimuth: float,
) -> Any:
    from pitchopt.sim.kernels_body import AZIMUTH, BLADES
    from pitchopt.sim.kernels_march import State
    from pitchopt.sim.kernels_planes import MEMORY_PLANES, PLANE, InflowState

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
        hunting=np.zeros(2),
        inflow=InflowState(
            row=np.zeros((blades, stations), dtype=np.int64),
            planes=np.zeros(MEMORY_PLANES * PLANE),
            disc=np.zeros(4),
            counts=np.zeros(3, dtype=np.int64),
        ),
    )


def _work(dynamic: DynamicTurbine) -> Any:
    from pitchopt.sim.kernels_body import BLADES, MotionWork
    from pitchopt.sim.kernels_march import Work
    from pitchopt.sim.kernels_planes import PLANE, WORK_PLANES, RotorWork

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
