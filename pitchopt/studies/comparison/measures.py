"""Measures: what a run is judged by, and what a method gains over another in the same winds.

    power            mean electrical power [W]
    loads            RMS about the mean and 1 Hz damage-equivalent load [N m] of
                       blade    out of plane at the roots, slope 10, mean of the blades
                       tower    fore-aft at the base, slope 4
                       tilt, yaw  at the hub, not turning, slope 4
                       torque   of the shaft, slope 4
    travel           path of a blade's pitch in a turn of the rotor [rad]
    rate_use         mean pitch rate over the largest allowed one [-]
    rate_peak        largest pitch rate over the largest allowed one [-]

Pitch rates are those of the series' instants, 0.05 s apart.  Methods meet the same seeds, so a
gain is taken seed by seed, and its uncertainty is that of these differences:

    cut_s = 1 - x_s / x_s(collective),     mean +- t(0.975, S - 1) std / sqrt(S).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pitchopt.errors import InputError
from pitchopt.sim import statistics
from pitchopt.sim.statistics import ChannelStatistics
from pitchopt.studies.tuning import PlantRun

__all__ = ["LOADS", "Cut", "RunMeasures", "cut", "measure"]

LOADS = ("blade", "tower", "tilt", "yaw", "torque")
"""Names of the loads."""

_CHANNELS = {
    "blade": ("RootMyc1", "RootMyc2", "RootMyc3"),
    "tower": ("TwrBsMyt",),
    "tilt": ("LSSTipMys",),
    "yaw": ("LSSTipMzs",),
    "torque": ("RotTorq",),
}
_PITCH = ("BldPitch1", "BldPitch2", "BldPitch3")


@dataclass(frozen=True, kw_only=True)
class RunMeasures:
    """Figures of one run, SI units; see the module.

    Attributes
    ----------
    seed : int
    power, power_std, generator_speed_std : float
        [W], [W], [rad/s].
    rms, equivalent_load : dict of str to float
        By `LOADS` [N m].
    travel, rate_use, rate_peak : float
    """

    seed: int
    power: float
    power_std: float
    generator_speed_std: float
    rms: dict[str, float]
    equivalent_load: dict[str, float]
    travel: float
    rate_use: float
    rate_peak: float

    def figure(self, kind: str, load: str) -> float:
        """RMS (``rms``) or damage-equivalent load (``del``) of a load."""
        return (self.rms if kind == "rms" else self.equivalent_load)[load]


@dataclass(frozen=True, kw_only=True)
class Cut:
    """What a method takes off a figure.

    Attributes
    ----------
    mean : float
        Share of the collective controller's figure [-]; negative for a rise.
    half_width : float or None
        Of the 95 % confidence interval of the mean; None for a single run.
    """

    mean: float
    half_width: float | None

    @property
    def least(self) -> float:
        """Lower end of the interval."""
        return self.mean - (self.half_width or 0.0)

    @property
    def most(self) -> float:
        """Upper end of the interval."""
        return self.mean + (self.half_width or 0.0)


def measure(run: PlantRun, rate: float) -> RunMeasures:
    """Figures of a finished run.

    Parameters
    ----------
    run : PlantRun
    rate : float
        Largest pitch rate allowed [rad/s].
    """
    simulation = run.simulation
    loads = [name for names in _CHANNELS.values() for name in names]
    found = statistics(simulation, skip=run.skip, names=["GenPwr", "GenSpeed", *loads])
    rows = simulation.after(run.skip)
    pitch = rows[:, [simulation.place(name) for name in _PITCH]]
    steps = np.abs(np.diff(pitch, axis=0))
    rates = steps / simulation.interval
    turns = (rows.shape[0] - 1) * simulation.interval
    turns *= float(rows[:, simulation.place("RotSpeed")].mean()) / (2.0 * np.pi)
    return RunMeasures(
        seed=run.seed,
        power=found["GenPwr"].mean,
        power_std=found["GenPwr"].std,
        generator_speed_std=found["GenSpeed"].std,
        rms={load: _mean([found[n].std for n in names]) for load, names in _CHANNELS.items()},
        equivalent_load={
            load: _mean([_load(found[n]) for n in names]) for load, names in _CHANNELS.items()
        },
        travel=float(steps.sum(axis=0).mean() / turns),
        rate_use=float(rates.mean() / rate),
        rate_peak=float(rates.max() / rate),
    )


def cut(
    method: Sequence[RunMeasures], reference: Sequence[RunMeasures], kind: str, load: str
) -> Cut:
    """What a method takes off a figure, seed by seed.

    Parameters
    ----------
    method, reference : sequence of RunMeasures
        Of the same seeds in the same order.
    kind : {"rms", "del"}
    load : str
        Of `LOADS`.

    Raises
    ------
    InputError
        If the seeds differ.
    """
    if [run.seed for run in method] != [run.seed for run in reference] or not method:
        raise InputError("runs: got different seeds or none, expected those of the reference")
    shares = np.array(
        [
            1.0 - mine.figure(kind, load) / other.figure(kind, load)
            for mine, other in zip(method, reference, strict=True)
        ]
    )
    count = shares.size
    if count < 2:
        return Cut(mean=float(shares[0]), half_width=None)
    from scipy.special import stdtrit

    spread = float(shares.std(ddof=1)) / np.sqrt(count)
    return Cut(mean=float(shares.mean()), half_width=float(stdtrit(count - 1, 0.975) * spread))


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values))


def _load(channel: ChannelStatistics) -> float:
    assert channel.equivalent_load is not None  # moments have one
    return channel.equivalent_load
