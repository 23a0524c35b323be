"""Closed-loop runs of the dynamic turbine: one wind, or many in threads."""

from __future__ import annotations

import copy
import time as clock
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.control import Controller, TurbineController
from pitchopt.errors import InputError
from pitchopt.sim.channels import Channel
from pitchopt.sim.run import OVERSPEED, TurbineRun
from pitchopt.sim.turbine import DynamicTurbine
from pitchopt.sim.wind import Wind, check_wind, wind_direction

__all__ = ["Simulation", "Start", "simulate", "simulate_many"]

_TOO_LONG = 1.0  # step check of a run that oscillates with the step and follows no physics
_CHUNK = 60.0  # seconds marched between two looks at the keyboard


@dataclass(frozen=True, kw_only=True)
class Start:
    """State in which a run begins; tower and blades are at rest, deflected by the loads there.

    Parameters
    ----------
    rotor_speed : float
        [rad/s].
    pitch : float
        Of all blades [rad].
    torque : float
        Of the generator, high-speed side [N m].
    azimuth : float
        Of blade 1 [rad].
    """

    rotor_speed: float
    pitch: float = 0.0
    torque: float = 0.0
    azimuth: float = 0.0

    def __post_init__(self) -> None:
        finite_number("start.rotor_speed", self.rotor_speed, at_least=0.0)
        finite_number("start.pitch", self.pitch)
        finite_number("start.torque", self.torque, at_least=0.0)
        finite_number("start.azimuth", self.azimuth)


@dataclass(frozen=True, kw_only=True, eq=False)
class Simulation:
    """Result of a run.

    A run has diverged when the compiled loop stopped it (see `message`), or when at its end the
    step check `error` of a coordinate has passed one: the step is then longer than the loop is
    stable with.

    Attributes
    ----------
    turbine : str
        Name.
    channels : tuple of Channel
    values : ndarray (R, C)
        Time series, SI units and radians; ``simulation["RootMyc1"]`` is one of them.
    status : {"finished", "diverged"}
        A run that diverged ends with the last row before it did.
    message : str
    diverged_at : float or None
        [s].
    interval, step : float
        Between two rows, and of the time loop [s].
    duration : float
        That was asked for [s].
    label : str
        Of the wind, e.g. its class and seed.
    error : ndarray (D,)
        Error check of the loop for each coordinate: largest distance between predicted and
        final rate over the largest rate.
    evaluations : float
        Of the momentum balance, mean per blade element and step.
    seconds : float
        Wall time of the time loop.
    """

    turbine: str
    channels: tuple[Channel, ...]
    values: FloatArray
    status: Literal["finished", "diverged"]
    message: str
    diverged_at: float | None
    interval: float
    step: float
    duration: float
    label: str
    error: FloatArray
    evaluations: float
    seconds: float

    def __getitem__(self, name: str) -> FloatArray:
        """Time series (R,) of a channel, SI units."""
        return self.values[:, self.place(name)]

    def place(self, name: str) -> int:
        """Column of a channel.

        Raises
        ------
        InputError
            If there is none of that name.
        """
        for i, channel in enumerate(self.channels):
            if channel.name == name:
                return i
        raise InputError(
            f"channel: got {name!r}, expected one of {', '.join(c.name for c in self.channels)}"
        )

    @property
    def time(self) -> FloatArray:
        """Times of the rows (R,) [s]."""
        return self.values[:, 0]

    def after(self, start: float) -> FloatArray:
        """Rows from time `start` on, (R', C), SI units."""
        return self.values[self.time >= start - 1e-9 * max(self.duration, 1.0)]

    def table(self, names: Sequence[str] | None = None) -> FloatArray:
        """Time series in OpenFAST's units, (R, len(names)); all channels if absent."""
        places = (
            range(len(self.channels)) if names is None else [self.place(name) for name in names]
        )
        factors = np.array([self.channels[i].factor for i in places])
        return np.asarray(self.values[:, list(places)] * factors)


def simulate(
    dynamic: DynamicTurbine,
    wind: Wind,
    controller: Controller,
    duration: float,
    *,
    start: Start,
    interval: float = 0.05,
    any_wind: bool = False,
    repeat: bool = False,
    label: str = "",
) -> Simulation:
    """Run the turbine.

    Parameters
    ----------
    dynamic : DynamicTurbine
    wind : StaticField, TransientField or TurbulentField
    controller : TurbineController or any Controller
        A `TurbineController` runs compiled, and is not changed; any other object is called every
        step.
    duration : float
        [s].
    start : Start
        See `pitchopt.sim.operation` for a steady one.
    interval : float
        Between two rows of the result [s], rounded to whole steps.
    any_wind : bool
        Allow mean winds below cut-in and above cut-out.
    repeat : bool
        Allow a periodic turbulence box that is shorter than the run.
    label : str
        Of the wind.

    Raises
    ------
    InputError
        If the wind is outside of the turbine's range, a box is smaller than the rotor or shorter
        than the run, the run is shorter than a step, or the controller has no such methods.
    """
    step = dynamic.step
    duration = finite_number("duration", duration, above=0.0)
    steps = round(duration / step)
    if steps < 1:
        raise InputError(f"duration: got {duration:g} s, expected at least one step of {step:g} s")
    finite_number("interval", interval, above=0.0)
    every = max(round(interval / step), 1)
    reach = dynamic.reach_in(wind_direction(wind))
    check_wind(dynamic.turbine, reach, wind, duration, any_wind=any_wind, repeat=repeat)
    if not all(callable(getattr(controller, name, None)) for name in ("start", "command")):
        raise InputError(
            f"controller: got {type(controller).__name__}, expected an object with start(step, "
            "measured) and command(measured)"
        )
    run = TurbineRun(
        dynamic,
        wind,
        rotor_speed=start.rotor_speed,
        pitch=start.pitch,
        torque=start.torque,
        azimuth=start.azimuth,
    )
    run.settle()
    record = np.zeros((steps // every + 1, len(dynamic.channels)))
    record[0] = run.outputs()
    began = clock.perf_counter()
    march = _compiled if isinstance(controller, TurbineController) else _stepwise
    rows, good = march(run, controller, steps, every, record[1:])
    seconds = clock.perf_counter() - began
    state = run.state
    balances = max(int(state.inflow.counts[1]), 1)
    scale = np.where(state.scale > 0.0, state.scale, 1.0)
    values = record[: rows + 1]
    error = np.where(np.isfinite(state.error), state.error, np.inf) / scale
    reason = "" if good else f"{_reason(run)}; gains, wind or time step do that"
    if good and error.max() > _TOO_LONG:
        good = False
        reason = (
            f"predicted and final rates part by {error.max():.3g} times the largest rate, the step "
            f"of {step:g} s is too long"
        )
    if not good:
        values = values[np.isfinite(values).all(axis=1)]
    return Simulation(
        turbine=dynamic.turbine.name,
        channels=dynamic.channels,
        values=values,
        status="finished" if good else "diverged",
        message=(
            f"finished after {duration:g} s" if good else f"diverged at {run.time:g} s: {reason}"
        ),
        diverged_at=None if good else run.time,
        interval=every * step,
        step=step,
        duration=duration,
        label=label,
        error=error,
        evaluations=float(state.inflow.counts[0]) / balances,
        seconds=seconds,
    )


def _reason(run: TurbineRun) -> str:
    """What has gone wrong in a run that diverged."""
    from pitchopt.sim.kernels_body import AZIMUTH
    from pitchopt.sim.kernels_march import HUNTING, hunting

    state = run.state
    speed = float(state.v[AZIMUTH]) / run.dynamic.turbine.rated_rotor_speed
    if not np.all(np.isfinite(state.v)):
        return "the motion is not finite any more"
    if speed < 0.0:
        return "the rotor turns backward"
    if speed >= OVERSPEED:
        return f"the rotor runs at {speed:.3g} times its rated speed"
    if hunting(state.hunting) >= HUNTING:
        return "the collective pitch races back and forth at its rate limit"
    return "a deflection passed half the radius"


def _compiled(
    run: TurbineRun, controller: Any, steps: int, every: int, record: FloatArray
) -> tuple[int, bool]:
    """March with a compiled controller; rows written and whether the run lasted."""
    from pitchopt.control.kernels import start
    from pitchopt.sim.kernels_march import RUNNING, march

    parameters = controller.parameters(run.model.step)
    memory = np.zeros(controller.memory_size)
    start(parameters, memory, run.measured())
    chunk = max(round(_CHUNK / run.model.step / every), 1) * every
    rows = done = 0
    while done < steps:
        status, more = march(
            run.model,
            run.state,
            run.work,
            parameters,
            memory,
            min(chunk, steps - done),
            every,
            record[rows:],
        )
        rows += more
        done += chunk
        if status != RUNNING:
            return rows, False
    return rows, True


def _stepwise(
    run: TurbineRun, controller: Controller, steps: int, every: int, record: FloatArray
) -> tuple[int, bool]:
    """March with a controller in Python."""
    controller.start(run.model.step, run.measured())
    rows = 0
    for count in range(1, steps + 1):
        if not run.advance(controller.command(run.measured())):
            return rows, False
        if count % every == 0:
            record[rows] = run.outputs()
            rows += 1
    return rows, True


def simulate_many(
    dynamic: DynamicTurbine,
    winds: Iterable[Wind | Callable[[], Wind]],
    controller: Controller,
    duration: float,
    *,
    start: Start | Sequence[Start],
    labels: Sequence[str] | None = None,
    executor: Executor | None = None,
    workers: int = 2,
    on_result: Callable[[Simulation], None] | None = None,
    **options: Any,
) -> list[Simulation]:
    """Run the turbine in several winds, side by side.

    The compiled loop lets go of Python's lock, so threads run on cores of their own.  Results
    come in the order of `winds` and are the same whatever the number of workers.

    Parameters
    ----------
    dynamic : DynamicTurbine
    winds : iterable of wind fields, or of functions that make one
        A function is called in the worker, so that boxes are made side by side and only as many
        are in memory as there are workers.
    controller : TurbineController or any Controller
        Each run has a copy of its own.
    duration : float
        Of each run [s].
    start : Start or one for each wind
    labels : sequence of str, optional
    executor : Executor, optional
        Of any kind; threads if absent.
    workers : int
        Threads, without an executor.
    on_result : callable, optional
        Called with each result in the order of `winds`, for progress.
    **options
        Of `simulate`.
    """
    whole_number("workers", workers, at_least=1)
    tasks = list(winds)
    starts = [start] * len(tasks) if isinstance(start, Start) else list(start)
    names = [""] * len(tasks) if labels is None else list(labels)
    if len(starts) != len(tasks) or len(names) != len(tasks):
        raise InputError(
            f"start, labels: got {len(starts)} and {len(names)} for {len(tasks)} winds, expected "
            "one each"
        )
    pool = ThreadPoolExecutor(max_workers=workers) if executor is None else executor
    try:
        futures = [
            pool.submit(_one, dynamic, wind, copy.deepcopy(controller), duration, at, name, options)
            for wind, at, name in zip(tasks, starts, names, strict=True)
        ]
        results = []
        try:
            for future in futures:
                results.append(future.result())
                if on_result is not None:
                    on_result(results[-1])
        except BaseException:
            for future in futures:
                future.cancel()
            raise
        return results
    finally:
        if executor is None:
            pool.shutdown(cancel_futures=True)


def _one(
    dynamic: DynamicTurbine,
    wind: Wind | Callable[[], Wind],
    controller: Controller,
    duration: float,
    start: Start,
    label: str,
    options: dict[str, Any],
) -> Simulation:
    field = wind() if callable(wind) else wind
    return simulate(dynamic, field, controller, duration, start=start, label=label, **options)
