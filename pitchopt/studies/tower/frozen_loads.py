"""The tower for a hub height and a controller: sized, simulated anew, sized again.

Within a sizing the loads are frozen at those of a simulated design.  When the sized tower differs
from the simulated one by more than a threshold in any diameter or wall, its own loads are
simulated and it is sized again.  The loads answer to the design, so that a frozen-load optimum is
the fixed point of this iteration and no optimum of the coupled problem; the paper and common
practice take it as the design.

The fixed point x = F(x) in logarithms of diameters and walls is approached with the last two
rounds (Anderson's method of depth one): with the residual r = F(x) - x,

    x_next = F(x) - theta (F(x) - F(x')),      theta = r (r - r') / |r - r'|^2,

as soon as the rounds contract; simulated designs may then lie outside of the limits, sized ones
never do.

Source: H. Walker, P. Ni, Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal.
49, 2011.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.errors import ComputationError
from pitchopt.studies.tower.design import TowerDesign
from pitchopt.studies.tower.limits import TowerLimits
from pitchopt.studies.tower.load_sets import LoadSet, LoadSets
from pitchopt.studies.tower.sizing import Sizing, scaled_start, size_tower

__all__ = ["OptimalTower", "Round", "design_logarithms", "optimal_tower"]

_DIGITS = 5  # of diameters and walls of simulated designs [m]
_NEAR, _APART = 0.05, 0.003  # of masses that tell the response of the loads
_STRONGEST = 0.9
_FURTHEST = 0.7  # of theta; beyond, the rounds do not contract


@dataclass(frozen=True, kw_only=True)
class Round:
    """One set and the sizing that followed.

    Attributes
    ----------
    key : str
        Of the set.
    simulated_mass, mass : float
        Of the simulated design and of the sized tower [kg].
    change : float
        Of any diameter or wall from the simulated design, largest [-].
    set_seconds, sizing_seconds : float
        Wall times; of the set when it was simulated.
    """

    key: str
    simulated_mass: float
    mass: float
    change: float
    set_seconds: float
    sizing_seconds: float


@dataclass(frozen=True, kw_only=True, eq=False)
class OptimalTower:
    """A tower sized for loads that are its own, to the threshold.

    Attributes
    ----------
    hub_height : float
        [m].
    tower_velocity : float
        Weight c of the regulator [s^2/m^2].
    sizing : Sizing
        Last sizing: design, mass, multipliers.
    simulated : TowerDesign
        Design whose loads it was sized for.
    load_set : LoadSet
        Those loads.
    rounds : tuple of Round
    converged : bool
        Whether the last change was within the threshold or the rounding of simulated designs.
    """

    hub_height: float
    tower_velocity: float
    sizing: Sizing
    simulated: TowerDesign
    load_set: LoadSet
    rounds: tuple[Round, ...]
    converged: bool

    @property
    def design(self) -> TowerDesign:
        """Sized design."""
        return self.sizing.design

    @property
    def mass(self) -> float:
        """[kg]."""
        return self.sizing.mass

    @property
    def load_response(self) -> float | None:
        """What the sized mass changes by for a change of the simulated one [-], None if not known.

        Least squares over the rounds whose simulated design is within 5 % of the tower's mass; with
        it a saving of frozen loads becomes saving / (1 - response) when the loads follow the tower.
        """
        rows = np.array([(turn.simulated_mass, turn.mass) for turn in self.rounds]) / self.mass
        near = rows[np.abs(rows[:, 0] - 1.0) <= _NEAR]
        if len(near) < 2 or np.ptp(near[:, 0]) < _APART:
            return None
        slope = float(np.polyfit(near[:, 0], near[:, 1], 1)[0])
        return slope if abs(slope) < _STRONGEST else None


def optimal_tower(
    sets: LoadSets,
    limits: TowerLimits,
    hub_height: float,
    tower_velocity: float,
    *,
    start: TowerDesign | None = None,
    threshold: float = 0.01,
    rounds: int = 12,
    on_round: Callable[[Round], None] | None = None,
) -> OptimalTower:
    """Size a tower for its own loads.

    Parameters
    ----------
    sets : LoadSets
    limits : TowerLimits
    hub_height : float
        [m].
    tower_velocity : float
        Weight c of the regulator [s^2/m^2].
    start : TowerDesign, optional
        First design that is simulated, at the hub height; the reference's own tower without.
    threshold : float
        Largest change of a diameter or wall from the simulated design [-].  Below the rounding of
        simulated designs, 5e-4 of a wall of 10 mm, equal sizes after rounding suffice.
    rounds : int
        At most.
    on_round : callable, optional
        Called after each round.

    Raises
    ------
    InputError
        If a number is out of range.
    ComputationError
        If no tower keeps the limits, or a sizing does not converge.
    """
    threshold = finite_number("threshold", threshold, above=0.0)
    most = whole_number("rounds", rounds, at_least=1)
    reference = sets.reference
    if start is None:
        design = scaled_start(reference, hub_height)
    else:
        design = TowerDesign(
            hub_height=hub_height,
            diameter=start.diameter,
            thickness=start.thickness,
            reference=reference,
        )
    design = _rounded(design)
    done: list[Round] = []
    before: tuple[FloatArray, FloatArray] | None = None
    while True:
        found = sets.run(design, tower_velocity)
        sizing = size_tower(hub_height, found.loads, limits, reference, start=design)
        if not sizing.converged:
            raise ComputationError(
                f"no {limits.configuration} tower at a hub height of {hub_height:g} m with c = "
                f"{tower_velocity:g}: {sizing.message}"
            )
        done.append(
            Round(
                key=found.key,
                simulated_mass=design.mass,
                mass=sizing.mass,
                change=sizing.design.change_from(design),
                set_seconds=found.seconds,
                sizing_seconds=sizing.seconds,
            )
        )
        if on_round is not None:
            on_round(done[-1])
        # a sized tower that rounds to the simulated one leaves nothing else to simulate
        settled = _rounded(sizing.design).change_from(design) == 0.0
        settled = settled or done[-1].change <= threshold
        if settled or len(done) == most:
            return OptimalTower(
                hub_height=hub_height,
                tower_velocity=tower_velocity,
                sizing=sizing,
                simulated=design,
                load_set=found,
                rounds=tuple(done),
                converged=settled,
            )
        sized = design_logarithms(sizing.design)
        moved = sized - design_logarithms(design)
        target = sized
        if before is not None:
            turn = moved - before[1]
            square = float(turn @ turn)
            theta = float(moved @ turn) / square if square > 0.0 else 0.0
            if -_FURTHEST < theta < _FURTHEST:
                target = sized - theta * (sized - before[0])
        before = (sized, moved)
        design = _designed(target, sizing.design)


def design_logarithms(design: TowerDesign) -> FloatArray:
    """Of diameters and walls, (2 E + 1,)."""
    return np.asarray(np.log(np.concatenate([design.diameter, design.thickness])))


def _designed(logarithms: FloatArray, like: TowerDesign) -> TowerDesign:
    sizes = np.exp(logarithms)
    nodes = like.elements + 1
    return _rounded(dataclasses.replace(like, diameter=sizes[:nodes], thickness=sizes[nodes:]))


def _rounded(design: TowerDesign) -> TowerDesign:
    """Sizes to a hundredth of a millimetre, so that rounding errors ask for no other set."""
    return dataclasses.replace(
        design,
        diameter=np.round(design.diameter, _DIGITS),
        thickness=np.round(design.thickness, _DIGITS),
    )
