"""Lightest tower of a given height under frozen loads.

Of all towers that keep the limits, the lightest; found in logarithms of diameters and walls by
`pitchopt.studies.tower.search`.

A multiplier lambda_i >= 0 is that of g_i <= 0 in  m + sum lambda_i g_i:  kilogrammes of the
lightest tower for each unit by which a limit is tightened.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.errors import InputError
from pitchopt.studies.tower.constraints import Rows, TowerConstraints
from pitchopt.studies.tower.design import TowerDesign
from pitchopt.studies.tower.fatigue_loads import FatigueLoads
from pitchopt.studies.tower.frequencies import Frequencies
from pitchopt.studies.tower.limits import TowerLimits
from pitchopt.studies.tower.search import lightest
from pitchopt.turbines import Turbine

__all__ = ["Sizing", "scaled_start", "size_tower"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Sizing:
    """The lightest tower, or how far the search came.

    Attributes
    ----------
    design : TowerDesign
    mass : float
        [kg].
    status : str
        ``converged``, ``iteration limit`` or ``infeasible``.
    message : str
        In words; of an infeasible problem, which limit is missed most.
    iterations : int
        Subproblems solved.
    seconds : float
    constraints : TowerConstraints
        g, at most zero where kept [-].
    multipliers : TowerConstraints
        [kg].  Those of the shape's limits need not be unique, as where several hold a can in
        place together; where infeasible they belong to the penalty and mean nothing.
    frequencies : Frequencies
    error : float
        Largest of violation, stationarity of ln m and complementarity [-].
    limits : TowerLimits
    rows : Rows
        All constraints one by one; a place of a group may have several.
    row_multipliers : ndarray (R,)
        Of the rows [kg].
    """

    design: TowerDesign
    mass: float
    status: str
    message: str
    iterations: int
    seconds: float
    constraints: TowerConstraints
    multipliers: TowerConstraints
    frequencies: Frequencies
    error: float
    limits: TowerLimits
    rows: Rows
    row_multipliers: FloatArray

    @property
    def converged(self) -> bool:
        """Whether the design is optimal."""
        return self.status == "converged"

    def relative_multipliers(self, reference_mass: float | None = None) -> TowerConstraints:
        """Multipliers over a reference mass [kg], or over the optimal mass."""
        mass = self.mass if reference_mass is None else reference_mass
        return self.multipliers.scaled(1.0 / finite_number("reference_mass", mass, above=0.0))

    def active(self, *, share: float = 1e-4) -> dict[str, list[int]]:
        """Places by group whose multiplier is above this share of the mass."""
        found = {
            name: np.flatnonzero(values > share * self.mass).tolist()
            for name, values in self.multipliers.items()
        }
        return {name: places for name, places in found.items() if places}


def scaled_start(reference: Turbine, hub_height: float, *, elements: int = 10) -> TowerDesign:
    """The reference's own tower stretched to a hub height, with evenly long elements.

    Diameters are those at the nodes; each wall keeps the mass of its element.
    """
    count = whole_number("elements", elements, at_least=1)
    tower = reference.tower
    if tower.thickness is None:
        raise InputError(f"turbine {reference.name!r}: the walls of its tower are not known")
    share = (tower.height - tower.base) / (tower.top - tower.base)
    middle = tower.diameter - tower.thickness
    node = np.linspace(0.0, 1.0, count + 1)
    diameter = np.interp(node, share, middle)
    fine = np.linspace(0.0, 1.0, 200 * count + 1)
    at = 0.5 * (fine[1:] + fine[:-1])
    area = np.interp(at, share, middle) * np.interp(at, share, tower.thickness)
    mean = area.reshape(count, -1).mean(axis=1)
    return TowerDesign(
        hub_height=hub_height,
        diameter=diameter,
        thickness=mean / (0.5 * (diameter[1:] + diameter[:-1])),
        reference=reference,
    )


def size_tower(
    hub_height: float,
    loads: FatigueLoads,
    limits: TowerLimits,
    reference: Turbine,
    start: TowerDesign | None = None,
    *,
    elements: int = 10,
    tolerance: float = 1e-6,
    iterations: int = 100,
) -> Sizing:
    """Lightest tower for frozen loads at a hub height.

    Parameters
    ----------
    hub_height : float
        [m].
    loads : FatigueLoads
    limits : TowerLimits
    reference : Turbine
        What stands on the tower, and its material.
    start : TowerDesign, optional
        Whose diameters and walls the search begins with, whatever its height; the reference's
        own tower, stretched, if absent.
    elements : int
        Number of elements where no start is given.
    tolerance : float
        On violation, stationarity and complementarity, all relative to limits and mass [-].
    iterations : int
        Largest number of subproblems.

    Raises
    ------
    InputError
        If an argument is out of range or the turbine's data do not suffice.
    ComputationError
        If a subproblem cannot be solved.
    """
    begun = time.perf_counter()
    tolerance = finite_number("tolerance", tolerance, above=0.0)
    most = whole_number("iterations", iterations, at_least=1)
    if start is None:
        first = scaled_start(reference, hub_height, elements=elements)
    else:
        first = TowerDesign(
            hub_height=hub_height,
            diameter=start.diameter,
            thickness=start.thickness,
            reference=reference,
        )
    found = lightest(first, loads, limits, tolerance=tolerance, most=most)
    rows, mass = found.rows, found.design.mass
    values = rows.gather(rows.value, add=False)
    # m = exp(ln m), and dg = (dg/dc) dc
    prices = np.asarray(found.multipliers * mass / rows.rate)
    prices.setflags(write=False)
    return Sizing(
        design=found.design,
        mass=mass,
        status=found.status,
        message=_message(found.status, values, found.steps, found.error),
        iterations=found.steps,
        seconds=time.perf_counter() - begun,
        constraints=values,
        multipliers=rows.gather(prices, add=True),
        frequencies=found.frequencies,
        error=found.error,
        limits=limits,
        rows=rows,
        row_multipliers=prices,
    )


def _message(status: str, values: TowerConstraints, count: int, error: float) -> str:
    if status == "converged":
        return f"optimal after {count} steps, error {error:.1e}"
    parts = [
        (float(part.max()), f"{name} {int(np.argmax(part))} by {100.0 * part.max():.3g} %")
        for name, part in values.items()
        if part.size and part.max() > 1e-4
    ]
    missed = "missed: " + ", ".join(text for _, text in sorted(parts, reverse=True)[:3])
    if status == "infeasible":
        return f"no design near keeps all limits; {missed}"
    stopped = f"stopped after {count} steps with error {error:.1e}"
    return f"{stopped}; {missed}" if parts else stopped
