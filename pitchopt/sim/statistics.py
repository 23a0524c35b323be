"""Statistics and damage-equivalent loads of simulated channels.

For every channel mean, standard deviation, least and largest value; for loads the 1 Hz
damage-equivalent load over the length of the series, `pitchopt.fatigue.damage_equivalent_load`,
with the slope of composite for blade roots (10) and of steel for everything else (4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import finite_number
from pitchopt.errors import InputError
from pitchopt.fatigue import damage_equivalent_load
from pitchopt.sim.simulate import Simulation

__all__ = ["BLADE_SLOPE", "STEEL_SLOPE", "ChannelStatistics", "average", "statistics"]

BLADE_SLOPE = 10.0
STEEL_SLOPE = 4.0


@dataclass(frozen=True, kw_only=True)
class ChannelStatistics:
    """Statistics of one channel, SI units.

    Attributes
    ----------
    mean, std, least, largest : float
    slope : float or None
        Of the damage-equivalent load; None for channels that are no loads.
    equivalent_load : float or None
    """

    mean: float
    std: float
    least: float
    largest: float
    slope: float | None = None
    equivalent_load: float | None = None


def _slope(name: str, unit: str, blade: float, steel: float) -> float | None:
    if unit not in ("kN-m", "kN", "N-m", "N"):
        return None
    return blade if name.startswith("Root") else steel


def statistics(
    simulation: Simulation,
    *,
    skip: float = 60.0,
    names: Sequence[str] | None = None,
    blade_slope: float = BLADE_SLOPE,
    steel_slope: float = STEEL_SLOPE,
) -> dict[str, ChannelStatistics]:
    """Statistics of channels by name; all of them, or `names`.

    Parameters
    ----------
    simulation : Simulation
    skip : float
        Start of the series that is left out [s].
    names : sequence of str, optional
        Channels; all without.
    blade_slope, steel_slope : float
        Slopes of the S-N curves of blade roots (channels ``Root...``) and of all other loads.

    Returns
    -------
    dict of str to ChannelStatistics
        SI units.

    Raises
    ------
    InputError
        If fewer than two rows are left.
    """
    skip = finite_number("skip", skip, at_least=0.0)
    rows = simulation.after(skip)
    if rows.shape[0] < 2:
        raise InputError(
            f"skip: got {skip:g} s, which leaves {rows.shape[0]} rows of a run that ended at "
            f"{simulation.time[-1]:g} s; expected at least 2"
        )
    length = rows.shape[0] * simulation.interval
    result = {}
    wanted = [c.name for c in simulation.channels[1:]] if names is None else list(names)
    for name in wanted:
        place = simulation.place(name)
        channel, series = simulation.channels[place], np.ascontiguousarray(rows[:, place])
        slope = _slope(name, channel.unit, blade_slope, steel_slope)
        result[name] = ChannelStatistics(
            mean=float(series.mean()),
            std=float(series.std()),
            least=float(series.min()),
            largest=float(series.max()),
            slope=slope,
            equivalent_load=(
                None if slope is None else damage_equivalent_load(series, slope, duration=length)
            ),
        )
    return result


def average(runs: Sequence[dict[str, ChannelStatistics]]) -> dict[str, ChannelStatistics]:
    """Statistics over several runs of equal length.

    Means are averaged, standard deviations are those of all runs together, extremes are the
    outermost, and damage-equivalent loads are averaged in damage (mean of their powers).
    """
    if not runs:
        raise InputError("runs: got none, expected the statistics of at least one run")
    result = {}
    for name, first in runs[0].items():
        parts = [run[name] for run in runs]
        mean = float(np.mean([p.mean for p in parts]))
        spread = np.mean([p.std**2 + (p.mean - mean) ** 2 for p in parts])
        load = None
        if first.slope is not None:
            loads = np.array([p.equivalent_load for p in parts], dtype=np.float64)
            top = float(loads.max())
            load = top and top * float(np.mean((loads / top) ** first.slope)) ** (1 / first.slope)
        result[name] = ChannelStatistics(
            mean=mean,
            std=float(np.sqrt(spread)),
            least=min(p.least for p in parts),
            largest=max(p.largest for p in parts),
            slope=first.slope,
            equivalent_load=load,
        )
    return result
