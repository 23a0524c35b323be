"""What another controller would save on a tower, estimated from one solved tower.

With the design x* of weight c = 0 and its multipliers lambda frozen, only the damage answers to the
controller,

    dm(c) = sum_j lambda_j (D_j(x*, c) - D_j(x*, 0))          high-order,
    dm(c) = c sum_j lambda_j (D_j(x*, c_1) - D_j(x*, 0)) / c_1    first-order, forward step c_1,

(`pitchopt.sensitivity`; equation (15) of the paper).  Each weight takes one set of simulations on
the frozen design.  The estimates know neither that a lighter tower meets other loads nor that the
damage is far from linear in the walls.

The first of the two can be mended at no cost.  The rounds that led to the tower have shown by how
much the sized mass changes for a change of the simulated one, its response rho; a saving s of
frozen loads makes a lighter tower, whose loads save rho s more, and so on:

    dm(c) = high-order / (1 - rho)                                    with the loads' response.

For other heights the damage of the reference height is kept and the multipliers are those of the
height, equation (16),

    CoE(h, c) = FCR ICC(m*(h, 0) + dm_h(c)) / E(h) + AOE.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array
from pitchopt.errors import InputError
from pitchopt.sensitivity import Estimate, PostOptimum
from pitchopt.studies.tower.constraints import Rows, constraint_rows
from pitchopt.studies.tower.design import Joints, TowerDesign, station_joints
from pitchopt.studies.tower.economics import Economics
from pitchopt.studies.tower.frozen_loads import OptimalTower
from pitchopt.studies.tower.load_sets import LoadSet
from pitchopt.studies.tower.towers import Towers

__all__ = ["CostMap", "MassEstimates", "cost_estimates", "mass_estimates", "station_damage"]


def station_damage(design: TowerDesign, found: LoadSet) -> FloatArray:
    """Lifetime damage (S,) of a design under the loads of a set; the worse of a node's two."""
    joints, values = _joint_damage(design, found)
    worst = np.zeros(found.loads.stations)
    np.maximum.at(worst, joints.station, values)
    return worst


def _joint_damage(design: TowerDesign, found: LoadSet) -> tuple[Joints, FloatArray]:
    joints = station_joints(found.loads.stations, design.elements)
    return joints, found.loads.damage(joints, *design.joint_sections(joints)).value


@dataclass(frozen=True, kw_only=True, eq=False)
class MassEstimates:
    """Estimated changes of the optimal mass over the controller's weight.

    Attributes
    ----------
    weights : ndarray (K,)
        c, 0 first [s^2/m^2].
    damage : ndarray (K, S)
        Of the frozen design at the stations, at a node the worse of its two elements' [-].
    joint_damage : ndarray (K, P)
        At the joints, in the order of the sizing's fatigue rows.
    first_order, high_order : ndarray (K,)
        Changes of the mass [kg].
    load_response : float or None
        rho [-], None where the rounds do not tell.
    estimates : tuple of Estimate
        For the weights but the first: contributions, assumptions.
    largest_damage : float
        Limit that the multipliers' constraints are relative to [-].
    """

    weights: FloatArray
    damage: FloatArray
    joint_damage: FloatArray
    first_order: FloatArray
    high_order: FloatArray
    load_response: float | None
    estimates: tuple[Estimate, ...]
    largest_damage: float = 1.0

    @property
    def with_response(self) -> FloatArray | None:
        """High-order changes with the loads' response (K,) [kg]."""
        rho = self.load_response
        return None if rho is None else np.asarray(self.high_order / (1.0 - rho))

    @property
    def damage_change(self) -> FloatArray:
        """Of the frozen design, over that at c = 0, less one (K, S) [-]."""
        return np.asarray(self.damage / self.damage[0] - 1.0)


def mass_estimates(
    towers: Towers, reference: OptimalTower, weights: ArrayLike, *, step: float
) -> MassEstimates:
    """Estimates for weights (K,), 0 and the step among them.

    Parameters
    ----------
    towers : Towers
        That run and count the sets.
    reference : OptimalTower
        Solved at c = 0.
    weights : array_like (K,)
        Ascending from 0 [s^2/m^2].
    step : float
        Forward step of the first-order estimate [s^2/m^2].

    Raises
    ------
    InputError
        If the weights do not begin with 0, do not ascend or lack the step, or the reference is
        that of another weight.
    """
    values = finite_array("weights", weights)
    if values[0] != 0.0 or np.any(np.diff(values) <= 0.0) or step not in values:
        raise InputError(
            f"weights: got {values.tolist()}, expected ascending ones with 0 first and the step "
            f"{step:g} among them"
        )
    if reference.tower_velocity != 0.0:
        raise InputError(f"reference: got one with c = {reference.tower_velocity:g}, expected 0")
    sets = {0.0: reference.load_set}
    for weight in values[1:].tolist():
        sets[weight] = towers.loads_on(reference.simulated, weight)
    optimum = _post_optimum(reference, sets, step)
    found = tuple(optimum.estimate(weight) for weight in values[1:])
    every = [sets[c] for c in values.tolist()]
    return MassEstimates(
        weights=values,
        damage=np.stack([station_damage(reference.design, part) for part in every]),
        joint_damage=np.stack([_joint_damage(reference.design, part)[1] for part in every]),
        first_order=np.array([0.0, *(e.first_order for e in found)]),
        high_order=np.array([0.0, *(e.high_order for e in found)]),
        load_response=reference.load_response,
        estimates=found,
        largest_damage=reference.sizing.limits.largest_damage,
    )


def _post_optimum(
    reference: OptimalTower, sets: Mapping[float, LoadSet], step: float
) -> PostOptimum:
    """The sized tower over (diameters, walls) and c, for weights that were simulated."""
    design, limits = reference.design, reference.sizing.limits
    nodes = design.elements + 1

    def at(x: FloatArray) -> TowerDesign:
        return TowerDesign(
            hub_height=design.hub_height,
            diameter=x[:nodes],
            thickness=x[nodes:],
            reference=design.reference,
        )

    def rows(x: FloatArray, c: float) -> Rows:
        return constraint_rows(at(x), sets[float(c)].loads, limits)

    def gradients(x: FloatArray, c: float) -> tuple[FloatArray, FloatArray]:
        found = rows(x, c)
        part = at(x).element_masses
        ends = part / (x[: nodes - 1] + x[1:nodes])  # of either end of an element
        by_diameter = np.concatenate([ends, [0.0]]) + np.concatenate([[0.0], ends])
        mass = np.concatenate([by_diameter, part / x[nodes:]])
        return mass, found.rate[:, None] * found.jacobian / x

    sizing = reference.sizing
    return PostOptimum.from_functions(
        lambda x, c: at(x).mass,  # noqa: ARG005  the mass does not depend on c
        lambda x, c: rows(x, c).value,
        x=np.concatenate([design.diameter, design.thickness]),
        c=0.0,
        multipliers=sizing.row_multipliers,
        names=sizing.rows.names,
        x_gradients=gradients,
        step=step,
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class CostMap:
    """Cost of energy over hub height and controller weight.

    Attributes
    ----------
    heights : ndarray (H,)
        [m].
    weights : ndarray (K,)
        [s^2/m^2].
    mass : ndarray (H, K)
        [kg].
    energy : ndarray (H, K)
        Yearly [J].
    economics : Economics
        What makes a cost of them.
    """

    heights: FloatArray
    weights: FloatArray
    mass: FloatArray
    energy: FloatArray
    economics: Economics

    @property
    def cost(self) -> FloatArray:
        """(H, K) [$/MWh]."""
        return self.economics.cost(self.heights[:, None], self.mass, self.energy)

    def fine(self, count: int = 241) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Heights (n,), weights (n,) and cost (n, n) between them.

        Costs of interpolated masses and energies: the logarithm of the mass at the first weight and
        the share that is left at the others monotone (PCHIP) over heights and weights, so that a
        limit that comes and goes makes no waves and diminishing returns stay such; energy by
        a cubic spline over the heights, which is the polynomial through three or four of them,
        monotone over the weights.
        """
        from scipy.interpolate import CubicSpline, PchipInterpolator

        h = np.linspace(self.heights[0], self.heights[-1], count)
        c = np.linspace(self.weights[0], self.weights[-1], count)

        def over_weights(values: FloatArray) -> FloatArray:
            return np.asarray(PchipInterpolator(self.weights, values, axis=1)(c))

        base = np.exp(PchipInterpolator(self.heights, np.log(self.mass[:, 0]))(h))
        share = over_weights(self.mass / self.mass[:, :1])
        mass = base[:, None] * PchipInterpolator(self.heights, share, axis=0)(h)
        energy = CubicSpline(self.heights, over_weights(self.energy), axis=0)(h)
        return h, c, self.economics.cost(h[:, None], mass, energy)

    def lowest(self, weight: float | None = None) -> tuple[float, float, float]:
        """Height, weight and cost of the lowest cost, at a weight or over all."""
        h, c, cost = self.fine()
        if weight is not None:
            column = int(np.argmin(np.abs(c - weight)))
            cost = np.where(np.arange(c.size) == column, cost, np.inf)
        i, j = np.unravel_index(int(np.argmin(cost)), cost.shape)
        return float(h[i]), float(c[j]), float(cost[i, j])


def cost_estimates(
    solved: Mapping[float, OptimalTower], changes: MassEstimates, economics: Economics
) -> dict[str, CostMap]:
    """Cost maps estimated from towers solved at c = 0.

    ``first-order`` and ``high-order``; ``with response`` too, where the reference knows it, whose
    response is kept for the other heights.

    Parameters
    ----------
    solved : mapping of float to OptimalTower
        By hub height, ascending [m].
    changes : MassEstimates
        Of the reference height, whose damage is kept for the others.
    economics : Economics
    """
    heights = np.array(list(solved))
    slope = changes.weights[1:, None]
    change = changes.joint_damage - changes.joint_damage[0]
    steps = [e.step for e in changes.estimates]
    first = int(np.flatnonzero(changes.weights == steps[0])[0])
    linear = np.concatenate(
        [np.zeros((1, change.shape[1])), slope * change[first] / changes.weights[first]]
    )
    kinds = {"first-order": (linear, 1.0), "high-order": (change, 1.0)}
    if changes.load_response is not None:
        kinds["with response"] = (change, 1.0 / (1.0 - changes.load_response))
    maps = {}
    limit = changes.largest_damage
    base = np.array([tower.mass for tower in solved.values()])
    energy = np.array([economics.energy(h, tower.load_set) for h, tower in solved.items()])
    prices = np.stack(
        [t.sizing.row_multipliers[t.sizing.rows.of("fatigue")] for t in solved.values()]
    )
    for kind, (damage, factor) in kinds.items():
        mass = base[:, None] + factor * (prices @ damage.T) / limit
        constant = np.broadcast_to(energy[:, None], mass.shape)
        maps[kind] = CostMap(
            heights=heights,
            weights=changes.weights,
            mass=mass,
            energy=constant.copy(),
            economics=economics,
        )
    return maps
