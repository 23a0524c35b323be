"""Lowest pitch at one wind speed of a table, against peak loads: Zalkind et al., section 3.3.

Around rated wind speed a lull brings the pitch down, and the gust after it finds a rotor at full
thrust.  A lowest pitch over the estimated wind speed (`pitchopt.control.MinimumPitchTable`, cubic
and monotone between its points) caps that for a little power.  One breakpoint u of the table is
tuned at a time, z its pitch, in the wind of mean speed u and of the one seed with the largest load:

    minimise over z    C(z) = kappa M(z)/M(z^0) + (1 - kappa) P(z^0)/P(z),                   (35)

M the largest flapwise root moment of all blades, P the mean electrical power, z^0 the pitch that
the table has; kappa = 0.01 weighs 10 % of the load as 0.1 % of the power.  Bounds are the pitches
of the two neighbours, so that the table stays monotone.

Torque is constant above rated speed, as the paper's controller has it.  The wind estimator is half
as fast as the turbine's own, a quarter of the rated rotor speed: the table feeds the estimate
back to the pitch, the estimate knows no dynamic inflow, and at the full bandwidth the loop hunts
at the pitch rate's limit once the table rises steeply (the NREL 5 MW from 4.5 degrees at 14 m/s).

The paper's table is for the NREL 5 MW: 5, 14, 18, 24 and 50 m/s with the fine pitch twice, 9, 19
and 90 degrees.  Other turbines get its wind speeds but the last times their rated wind speed over
11.4 m/s, and at the third and fourth the same share of the way from fine pitch to steady operation,
which the NREL 5 MW has at 14.92 and 22.35 degrees (NREL/TP-500-38060, table 7-1); feather is the
upper end of the actuators' range.

Source: D. Zalkind, E. Dall'Anese, L. Pao, "Automatic controller tuning using a zeroth-order
optimization algorithm", Wind Energy Science 5, 2020, section 3.3, table 4.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.control import MinimumPitchTable, TurbineController
from pitchopt.errors import InputError
from pitchopt.studies.tuning.plant import PlantRun, TuningPlant
from pitchopt.studies.tuning.problem import TuningProblem
from pitchopt.tuning import Parameter, Space

__all__ = ["KAPPA", "MinimumPitch", "initial_table", "minimum_pitch_base", "with_table"]

KAPPA = 0.01
RADIUS = math.radians(0.5)  # mu
_SLOWER = 0.5  # estimator gain over that of the turbine's own
_STEP = 1500.0 * math.radians(1.0) ** 2  # alpha_0 is per degree of a cost over degrees
_PAPER_RATED = 11.4  # rated wind speed of the NREL 5 MW [m/s]
_PAPER_SPEEDS = (5.0, 14.0, 18.0, 24.0)
_HIGHEST_SPEED = 50.0
_PAPER_PITCH = (9.0, 19.0)  # at the third and fourth [deg]
_PAPER_STEADY = (14.92, 22.35)  # steady operation there [deg]


def initial_table(plant: TuningPlant) -> MinimumPitchTable:
    """The paper's table to begin with, scaled to the turbine; see the module.

    Raises
    ------
    InputError
        If the turbine's rated wind speed is not known.
    """
    turbine, operation = plant.turbine, plant.operation
    if turbine.rated_wind_speed is None:
        raise InputError(
            f"turbine {turbine.name!r}: its rated wind speed is not known; give a table of lowest "
            "pitch to begin with"
        )
    fine = operation.fine_pitch
    speeds = np.array(_PAPER_SPEEDS) * (turbine.rated_wind_speed / _PAPER_RATED)
    if turbine.name == "nrel-5mw":
        middle = np.radians(_PAPER_PITCH)
    else:
        steady = np.interp(speeds[2:], operation.curve.wind_speed, operation.curve.pitch)
        middle = fine + np.array(_PAPER_PITCH) / np.array(_PAPER_STEADY) * (steady - fine)
    return MinimumPitchTable(
        wind_speed=np.array([*speeds, _HIGHEST_SPEED]),
        pitch=np.array([fine, fine, *middle, turbine.pitch_range[1]]),
    )


def minimum_pitch_base(plant: TuningPlant) -> TurbineController:
    """The turbine's own regulator with constant torque above rated and a slow wind estimator."""
    found = plant.operation.controller(constant_power=False, estimator=True)
    assert found.estimator is not None  # asked for
    slow = dataclasses.replace(found.estimator, gain=_SLOWER * found.estimator.gain)
    return dataclasses.replace(found, estimator=slow)


def with_table(base: TurbineController, table: MinimumPitchTable) -> TurbineController:
    """A controller with an estimator, its lowest pitch from a table."""
    return dataclasses.replace(base, minimum_pitch=table)


class MinimumPitch(TuningProblem):
    """Cost of the lowest pitch at one breakpoint, in the wind of one seed.

    Parameters
    ----------
    plant : TuningPlant
    table : MinimumPitchTable
        As far as it is tuned.
    place : int
        Breakpoint, neither the first nor the last.
    seed : int
        Of the wind with the largest load.
    kappa : float
        Weight of the load, 0 to 1.
    lower : float, optional
        Lower bound in place of the neighbour's pitch [rad].
    base : TurbineController, optional
        With a wind estimator; `minimum_pitch_base` without.

    Attributes
    ----------
    space : Space
        ``minimum_pitch`` [rad].
    start : (1,) ndarray
        z^0, the pitch of the table.
    first : (1,) ndarray
        z^1, the start moved inside the bounds by the sampling radius.
    radius : float
        Of the samples [rad]: half a degree, or less where the bounds leave less.

    Raises
    ------
    InputError
        If the breakpoint is an end of the table, the bounds leave no room, or a number is out of
        range.
    """

    name: ClassVar[str] = "minimum-pitch"

    def __init__(
        self,
        plant: TuningPlant,
        table: MinimumPitchTable,
        place: int,
        *,
        seed: int,
        kappa: float = KAPPA,
        lower: float | None = None,
        base: TurbineController | None = None,
    ) -> None:
        whole_number("place", place, at_least=1)
        if place > table.pitch.size - 2:
            raise InputError(
                f"place: got {place}, expected 1 to {table.pitch.size - 2}, between the ends of "
                "the table"
            )
        base = minimum_pitch_base(plant) if base is None else base
        if base.estimator is None:
            raise InputError(
                "base: a table over the wind speed without an estimator, expected a controller "
                "with a WindEstimator"
            )
        self.table, self.place = table, place
        self.kappa = finite_number("kappa", kappa, at_least=0.0, at_most=1.0)
        low = float(table.pitch[place - 1]) if lower is None else finite_number("lower", lower)
        high = float(table.pitch[place + 1])
        super().__init__(
            plant,
            Space([Parameter(name="minimum_pitch", low=low, high=high)]),
            [table.pitch[place]],
            wind_speeds=[table.wind_speed[place]],
            seeds=[seed],
            base=base,
        )
        self.radius = min(RADIUS, 0.25 * (high - low))
        self.first = np.clip(self.start, low + self.radius, high - self.radius)
        self._load = self._power = math.nan

    def table_of(self, x: FloatArray) -> MinimumPitchTable:
        """The table with the pitch of a point (1,) at the breakpoint."""
        pitch = np.array(self.table.pitch)
        pitch[self.place] = x[0]
        return MinimumPitchTable(wind_speed=self.table.wind_speed, pitch=pitch)

    def controller(self, x: FloatArray) -> TurbineController:
        """Controller with the table of a point (1,)."""
        return with_table(self.base, self.table_of(x))

    def cost_of(self, runs: Sequence[PlantRun]) -> float:
        """C of equation (35) [-]."""
        measures = runs[0].measures
        load = measures["flapwise_moment"] / self._load
        return self.kappa * load + (1.0 - self.kappa) * self._power / measures["power"]

    def _refer(self, runs: Sequence[PlantRun]) -> None:
        """M(z^0) and P(z^0)."""
        measures = runs[0].measures
        self._load, self._power = measures["flapwise_moment"], measures["power"]

    def document(self) -> dict[str, object]:
        """Plain data that names the problem with all that its results depend on."""
        return {
            **super().document(),
            "kappa": self.kappa,
            "place": self.place,
            "table": [self.table.wind_speed.tolist(), self.table.pitch.tolist()],
        }

    def tuner_options(self, method: str) -> dict[str, Any]:
        """Table 4 of the paper for ``zoo``."""
        if method != "zoo":
            return super().tuner_options(method)
        return {
            "start": self.first,
            "samples": 2,
            "stages": 4,
            "radius": self.radius,
            "step": _STEP,
            "scaling": (1.0,),
            "shrinkage": 0.5,
            "threshold": 0.05,
            "steps": 3,
            "directions": "even",
            "coordinates": "own",
        }
