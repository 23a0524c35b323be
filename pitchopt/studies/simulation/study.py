"""Runs of a dynamic turbine over wind speeds and seeds, side by side in threads."""

from __future__ import annotations

import difflib
import itertools
import time
from collections.abc import Callable, Sequence

import numpy as np

from pitchopt.control import Controller
from pitchopt.errors import InputError
from pitchopt.exports import series_of
from pitchopt.sim import (
    Channel,
    DynamicTurbine,
    Operation,
    Simulation,
    simulate_many,
    statistics,
)
from pitchopt.sim.wind import check_wind
from pitchopt.studies.simulation.result import RunResult, SimulationResult
from pitchopt.studies.simulation.settings import SimulationSettings
from pitchopt.studies.simulation.winds import WindCase, wind_cases
from windfield import BoxCache

__all__ = ["run_simulations", "selected_channels"]

_SCALARS = (
    *("Wind1VelX", "RotSpeed", "GenSpeed", "GenTq", "GenPwr", "RotTorq", "RotThrust"),
    *("LSSTipMys", "LSSTipMzs", "TTDspFA", "TTDspSS", "YawBrMyp", "YawBrMzp"),
    *("TwrBsMxt", "TwrBsMyt"),
)
_PER_BLADE = ("BldPitch", "RootMxc", "RootMyc", "OoPDefl")
_BATCH = 4  # runs for each worker whose whole record is in memory at a time

Progress = Callable[[int, int, str], None]


def selected_channels(
    dynamic: DynamicTurbine, names: Sequence[str] | None = None
) -> tuple[Channel, ...]:
    """Channels by name, each once; a selection without names, all of them for ``all``.

    Raises
    ------
    InputError
        If the turbine has no channel of a name.
    """
    known = {channel.name: channel for channel in dynamic.channels[1:]}
    if names is None:
        blades = range(1, dynamic.blades + 1)
        names = [*_SCALARS, *(f"{name}{k}" for name in _PER_BLADE for k in blades)]
    if tuple(names) == ("all",):
        return tuple(known.values())
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=1, cutoff=0.4)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise InputError(
                f"channels: got {name!r}, expected all, or names out of OpenFAST's such as "
                f"{', '.join(_SCALARS[:5])}; the turbine has {len(known)}{hint}"
            )
    return tuple(known[name] for name in dict.fromkeys(names))


def run_simulations(
    dynamic: DynamicTurbine,
    controller: Controller,
    settings: SimulationSettings,
    *,
    name: str = "",
    operation: Operation | None = None,
    cache: BoxCache | None = None,
    workers: int = 1,
    progress: Progress | None = None,
) -> SimulationResult:
    """Run a turbine in all winds of the settings.

    Parameters
    ----------
    dynamic : DynamicTurbine
    controller : TurbineController or any Controller
        Each run has a copy of its own.
    settings : SimulationSettings
    name : str
        Of the controller.
    operation : Operation, optional
        Of the same turbine, where it is there already.
    cache : BoxCache, optional
        Where Kaimal boxes are kept.
    workers : int
        Threads.  The result does not depend on them.
    progress : callable, optional
        Called with runs done, runs in all and what is done.

    Raises
    ------
    InputError
        If a wind is outside of the turbine's range, a box is smaller than the rotor or shorter
        than the run, or a channel is unknown.
    """
    began = time.perf_counter()
    channels = selected_channels(dynamic, settings.channels)
    winds = wind_cases(dynamic, settings, cache)
    for wind in winds:
        check_wind(dynamic.turbine, dynamic.reach, wind.mean, settings.length)
    operation = Operation(dynamic) if operation is None else operation
    runs: list[RunResult] = []
    interval = settings.interval
    done = itertools.count()

    def report(_: Simulation | None) -> None:
        if progress is not None:
            progress(next(done), len(winds), "simulation")

    report(None)
    size = _BATCH * workers
    for first in range(0, len(winds), size):
        batch = winds[first : first + size]
        found = simulate_many(
            dynamic,
            [wind.make for wind in batch],
            controller,
            settings.length,
            start=[operation.start(wind.wind_speed) for wind in batch],
            interval=settings.interval,
            labels=[wind.turbulence for wind in batch],
            workers=workers,
            on_result=report,
        )
        interval = found[0].interval
        runs += [
            _run(wind, run, channels, settings) for wind, run in zip(batch, found, strict=True)
        ]
    return SimulationResult(
        turbine=dynamic.turbine.name,
        controller=name,
        iec_class=dynamic.turbine.iec_class,
        settings=settings,
        step=dynamic.step,
        interval=interval,
        channels=channels,
        runs=tuple(runs),
        seconds=time.perf_counter() - began,
    )


def _run(
    wind: WindCase,
    simulation: Simulation,
    channels: tuple[Channel, ...],
    settings: SimulationSettings,
) -> RunResult:
    names = [channel.name for channel in channels]
    enough = simulation.after(settings.skip).shape[0] >= 2
    return RunResult(
        wind_speed=wind.wind_speed,
        turbulence=wind.turbulence,
        seed=wind.seed,
        status=simulation.status,
        message=simulation.message,
        diverged_at=simulation.diverged_at,
        seconds=simulation.seconds,
        statistics=(statistics(simulation, skip=settings.skip, names=names) if enough else None),
        series=series_of(simulation, names),
        step_error=float(np.max(simulation.error)),
        evaluations=simulation.evaluations,
    )
