"""Profiles that flatten three loads exactly: starts that no constant pitch reaches.

With three blades, each rotor position has three pitch angles and can meet three equations, either

    torque(k) = T,   tilt(k) = M_tilt,    yaw(k) = M_yaw,       what is left varies in thrust, or
    tilt(k) = M_tilt,   yaw(k) = M_yaw,   thrust(k) = F,        what is left varies in torque,

for any wanted means.  Newton's method marches over the positions for many means at once, each
position starting from its neighbour's solution; pitch is kept inside its limits on the way.  Means
are counted from those of a constant pitch, towards feather or towards stall, so that three numbers
name a profile: the torque that the constant pitch gives up, and what is added to its tilt and yaw.
With two blades the equations are met in the least-squares sense.

A coarse grid of the three numbers is refined around the best for each objective; what judges is
the true objective of the profiles after the repair to range and rate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.search import Start, graded

__all__ = ["FlatProfiles", "families", "flatten", "loads_of", "polished", "ranks_of"]

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.intp]

KEPT = ((0, 1, 2), (1, 2, 3))
"""Loads that are flattened: all but thrust, all but torque."""

_LOSSES = (0.003, 0.01, 0.02, 0.035, 0.06, 0.1, 0.16, 0.25)
_SHARES = (-0.12, -0.06, 0.0, 0.06, 0.12)  # of torque, added to the constant pitch's mean
_MOST_POSITIONS = 40  # at which starts are looked for
_CONSTANT = -1  # stands for a family where the profile is a constant pitch
_CONSTANTS = 61
_STEPS = 6  # of Newton's method at a position
_DAMPING = 1e-8
_SETTLED = 1e-9  # [rad]
_MISSED = 5e-3  # [rad]; starts that miss a target by more are dropped
_STEP_SIZES = np.array([0.6, 0.06, 0.06])  # of the grid: log loss, shares
_ROUNDS = 6  # of refinement, each with half the step
_BASINS = 4  # that are refined
_APART = np.radians(0.5)  # somewhere, for two profiles to count as two


@dataclass(frozen=True, kw_only=True, eq=False)
class Family:
    """One kind of flattened profiles: the loads kept flat, and one side of constant pitch.

    Attributes
    ----------
    kept : tuple of int
        The three loads that are flattened.
    pitch : ndarray (P,)
        Constant pitches from that of largest torque to one end of the range [rad].
    loss : ndarray (P,)
        Share of torque that they give up, rising.
    means : ndarray (P, 4)
        Mean loads of these pitches.
    """

    kept: tuple[int, int, int]
    pitch: FloatArray
    loss: FloatArray
    means: FloatArray

    def targets(self, numbers: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Wanted means (G, 3) and first pitches (G,) of loss, tilt and yaw shares (G, 3)."""
        torque = self.means[0, 0]
        first = np.interp(numbers[:, 0], self.loss, self.pitch)
        means = np.stack([np.interp(first, *self._rising(q)) for q in range(4)], axis=1)
        means[:, 1:3] += torque * numbers[:, 1:]
        return means[:, self.kept], first

    def _rising(self, load: int) -> tuple[FloatArray, FloatArray]:
        order = np.argsort(self.pitch)
        return self.pitch[order], self.means[order, load]


def families(problem: DesignProblem, pitch: float) -> list[Family]:
    """Both kinds of flattened profiles, towards stall and towards feather.

    Parameters
    ----------
    problem : DesignProblem
    pitch : float
        The constant pitch of largest torque [rad].
    """
    found: list[Family] = []
    for end in problem.constant_range:
        grid = np.linspace(pitch, end, 90)
        means = problem.curves.evaluate_constant(grid)[0].mean(axis=2)
        if means[0, 0] <= 0:
            break  # no torque to give up a share of
        loss = 1.0 - np.minimum.accumulate(means[:, 0]) / means[0, 0]
        last = int(np.argmax(loss)) + 1  # beyond, torque rises again
        if last > 1:
            found += [
                Family(kept=kept, pitch=grid[:last], loss=loss[:last], means=means[:last])
                for kept in KEPT
            ]
    return found


def flatten(
    problem: DesignProblem,
    kept: tuple[int, int, int],
    targets: FloatArray,
    first: FloatArray,
    *,
    turns: int = 3,
    backwards: bool = False,
    tolerance: float = _MISSED,
) -> tuple[FloatArray, IntArray]:
    """Profiles whose kept loads have the wanted values at every rotor position.

    Parameters
    ----------
    problem : DesignProblem
    kept : tuple of int
        Three of the loads torque, tilt, yaw, thrust, by their index.
    targets : array (G, 3)
        Wanted values of the kept loads.
    first : array (G,)
        Constant pitch that the march starts from [rad].
    turns : int
        Passages marched over.  From the third on the effect of the pitch rate is counted, with
        the rate of the passage before; without such effects there are two at most.
    backwards : bool
        March against the direction of rotation.
    tolerance : float
        Largest miss of a target that counts as met [rad], loads over their largest slope.

    Returns
    -------
    profiles : ndarray (F, N)
        Within range; the rate limit is not looked at.
    which : ndarray (F,)
        Their targets: with three blades or more those that were met, else all.
    """
    curves, m, loads = problem.curves, problem.curves.positions, list(kept)
    unit = _units(problem, loads)
    rates = curves.rates[loads, None, :] / (2 * curves.spacing)
    which = np.arange(first.size)
    beta = first[:, None] * np.ones(curves.blades)
    profiles = np.repeat(first[:, None], curves.stations, axis=1)
    order = range(m - 1, -1, -1) if backwards else range(m)
    for turn in range(turns if np.any(rates) else min(turns, 2)):
        change = np.roll(profiles, -1, axis=1) - np.roll(profiles, 1, axis=1)
        added = rates * (change if turn >= 2 else 0.0)
        missed = np.zeros(which.size)
        for k in order:
            stations = k + m * np.arange(curves.blades)
            if k == order[0] and turn > 0:  # where each blade stood, the next one stands now
                beta = np.roll(beta, -1 if backwards else 1, axis=1)
            wanted = targets[which] - added[:, :, stations].sum(axis=2).T
            beta, miss = _newton(problem, loads, unit, stations, beta, wanted)
            profiles[:, stations] = beta
            missed = np.maximum(missed, miss)
        if curves.blades >= len(loads):
            met = missed < tolerance
            which, beta, profiles = which[met], beta[met], profiles[met]
    return profiles, which


def _units(problem: DesignProblem, loads: list[int]) -> FloatArray:
    """Largest slope of each load anywhere, which measures it as an angle."""
    slopes = problem.curves.slopes[loads]
    return np.asarray(np.maximum(slopes.max(axis=(1, 2)), -slopes.min(axis=(1, 2))) + 1e-300)


def _newton(
    problem: DesignProblem,
    loads: list[int],
    unit: FloatArray,
    stations: IntArray,
    beta: FloatArray,
    targets: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Damped Newton steps on one rotor position: pitch (G, B), and by how much it misses (G,).

    Loads are measured by their largest slope anywhere, ``unit``, so that all of them are angles.
    """
    curves = problem.curves
    low, high = curves.lower[stations], curves.upper[stations]
    pick = np.array(loads)[:, None]
    reach = np.radians(2.0)
    last = curves.beta.shape[1] - 2
    beta = np.clip(beta, low, high)
    miss = np.zeros(beta.shape[0])
    for _ in range(_STEPS):
        jacobian = np.empty((beta.shape[0], len(loads), stations.size))
        residual = -targets
        for b, n in enumerate(stations):
            knots = curves.beta[n]
            j = np.clip(np.searchsorted(knots, beta[:, b], side="right") - 1, 0, last)
            slope = curves.slopes[pick, n, j]
            jacobian[:, :, b] = slope.T / unit
            residual = residual + (curves.loads[loads, n][:, j] + slope * (beta[:, b] - knots[j])).T
        residual = residual / unit
        miss = np.abs(residual).max(axis=1, initial=0.0)
        step = _least_squares(jacobian, residual)
        moved = np.clip(beta - np.clip(step, -reach, reach), low, high)
        done = np.abs(moved - beta).max(initial=0.0) < _SETTLED
        beta = moved
        if done:
            break
    return np.asarray(beta), miss


def _least_squares(jacobian: FloatArray, residual: FloatArray) -> FloatArray:
    """Damped Gauss-Newton steps (G, B) for Jacobians (G, 3, B) and residuals (G, 3)."""
    transposed = np.swapaxes(jacobian, 1, 2)
    normal = transposed @ jacobian + _DAMPING * np.eye(jacobian.shape[2])
    return np.asarray(np.linalg.solve(normal, transposed @ residual[:, :, None])[:, :, 0])


def polished(
    problem: DesignProblem, kept: tuple[int, int, int], targets: FloatArray, profile: FloatArray
) -> FloatArray:
    """A nearly flat profile (N,) brought to the targets (3,), all positions at once."""
    curves, loads = problem.curves, list(kept)
    shape = (len(loads), curves.blades, curves.positions)
    rows = np.arange(curves.stations)
    unit = _units(problem, loads)
    reach = np.radians(2.0)
    for _ in range(_STEPS):
        rotor = curves.evaluate(profile).rotor[loads]
        slope = curves.slopes[:, rows, curves.segment(profile)][loads].reshape(shape)
        jacobian = np.moveaxis(slope / unit[:, None, None], 2, 0)
        step = _least_squares(jacobian, (rotor.T - targets) / unit).T.ravel()
        profile = np.clip(profile - np.clip(step, -reach, reach), curves.lower, curves.upper)
    return np.asarray(profile)


@dataclass(frozen=True, kw_only=True, eq=False)
class _Batch:
    """Repaired profiles (G, N), the three numbers behind each, and what objectives need."""

    family: IntArray
    numbers: FloatArray
    profiles: FloatArray
    torque: FloatArray
    rms: FloatArray
    travel: FloatArray

    def ranks(self, objective: Objective) -> FloatArray:
        """Rank of each profile, shape (G,)."""
        return ranks_of(objective, self.torque, self.rms, self.travel)

    def joined(self, others: Sequence[_Batch]) -> _Batch:
        """One batch of this and the others."""
        batches = (self, *others)
        return _Batch(
            **{
                item.name: np.concatenate(
                    [getattr(batch, item.name) for batch in batches],
                    axis=1 if item.name == "rms" else 0,
                )
                for item in fields(_Batch)
            }
        )


class FlatProfiles:
    """Flattened and constant profiles of one problem, refined for the objectives of a call.

    Parameters
    ----------
    problem : DesignProblem
    pitch : float
        The constant pitch of largest torque [rad].  Torque can be given up towards feather or
        towards stall, and both sides are tried.
    """

    def __init__(self, problem: DesignProblem, pitch: float) -> None:
        self.full = problem
        if problem.curves.positions > _MOST_POSITIONS:
            problem = problem.with_curves(problem.curves.thinned(_MOST_POSITIONS))
        self.problem = problem
        self._refined: set[Objective] = set()
        free = problem.curves.mean_pitch is None and not problem.constant_only
        wanted = free and problem.curves.blades > 1
        self.families = families(problem, pitch) if wanted else []
        constants = np.linspace(*problem.constant_range, _CONSTANTS)[:, None]
        grid = np.array(list(product(_LOSSES, _SHARES, _SHARES)))
        self.pool = self._judged(
            _CONSTANT, np.zeros((_CONSTANTS, 3)), np.repeat(constants, problem.curves.stations, 1)
        ).joined([self._batch(i, grid) for i in range(len(self.families))])

    def _batch(self, family: int, numbers: FloatArray) -> _Batch:
        own, problem = self.families[family], self.problem
        raw, which = flatten(problem, own.kept, *own.targets(numbers))
        profiles = np.array([problem.repaired(profile) for profile in raw]).reshape(raw.shape)
        return self._judged(family, numbers[which], profiles)

    def _judged(self, family: int, numbers: FloatArray, profiles: FloatArray) -> _Batch:
        torque, rms = loads_of(self.problem, profiles)
        return _Batch(
            family=np.full(len(profiles), family),
            numbers=numbers,
            profiles=profiles,
            torque=torque,
            rms=rms,
            travel=np.abs(np.roll(profiles, -1, axis=1) - profiles).sum(axis=1),
        )

    def refine(self, objectives: Sequence[Objective]) -> None:
        """Search around the profiles that each objective likes best, with finer and finer steps.

        What was refined before is left out.
        """
        objectives = [objective for objective in objectives if objective not in self._refined]
        self._refined.update(objectives)
        if not self.families or not objectives:
            return
        torque = self.families[0].means[0, 0]
        losses = {1.0 - objective.torque_min / torque for objective in objectives}
        grid = np.array(list(product([x for x in losses if 0 < x < 1], _SHARES, _SHARES)))
        if grid.size:
            self.pool = self.pool.joined([self._batch(i, grid) for i in range(len(self.families))])
        for count in range(1, _ROUNDS + 1):
            centres = {int(i) for objective in objectives for i in self._liked(objective, _BASINS)}
            moves = _STEP_SIZES * (np.array(list(product((-1, 0, 1), repeat=3))) / 2.0**count)
            found = []
            for family in range(len(self.families)):
                around = [i for i in centres if self.pool.family[i] == family]
                if not around:
                    continue
                numbers = self.pool.numbers[around][:, None, :]
                moved = numbers + moves
                moved[..., 0] = numbers[..., 0] * np.exp(moves[:, 0])
                found.append(self._batch(family, np.unique(moved.reshape(-1, 3), axis=0)))
            self.pool = self.pool.joined(found)

    def _liked(self, objective: Objective, count: int) -> list[int]:
        """Indices of the flattened profiles that an objective likes best, apart from each other."""
        profiles = self.pool.profiles
        chosen: list[int] = []
        for i in np.argsort(-self.pool.ranks(objective), kind="stable"):
            apart = np.abs(profiles[chosen] - profiles[i]).max(axis=1, initial=0.0)
            if self.pool.family[i] != _CONSTANT and np.all(apart > _APART):
                chosen.append(int(i))
            if len(chosen) == count:
                break
        return chosen

    def starts(self, objective: Objective, count: int = 2) -> list[Start]:
        """The flattened profiles that an objective likes best, as starts."""
        self.refine([objective])
        return [
            Start(label=f"flattened {number}", profile=self._at_full_size(i))
            for number, i in enumerate(self._liked(objective, count), start=1)
        ]

    def best(self, objective: Objective) -> Start:
        """The profile that an objective likes best, flattened or constant."""
        self.refine([objective])
        i = int(np.argmax(self.pool.ranks(objective)))
        flat = self.pool.family[i] != _CONSTANT
        constant = f"constant {np.degrees(self.pool.profiles[i, 0]):.1f} deg"
        return Start(label="flattened 1" if flat else constant, profile=self._at_full_size(i))

    def _at_full_size(self, i: int) -> FloatArray:
        """A profile of the pool at all stations of the problem."""
        few, full = self.problem.curves, self.full.curves
        profile = self.pool.profiles[i]
        if self.problem is self.full:
            return np.asarray(profile)
        if self.pool.family[i] == _CONSTANT:
            return np.full(full.stations, profile[0])
        own = self.families[self.pool.family[i]]
        targets, _ = own.targets(self.pool.numbers[i : i + 1])
        between = np.interp(full.azimuth, few.azimuth, profile, period=2 * np.pi)
        return self.full.repaired(polished(self.full, own.kept, targets[0], between))


def loads_of(problem: DesignProblem, profiles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean torque (G,) and the five RMS values (5, G) of profiles (G, N)."""
    curves = problem.curves
    beta = profiles.T
    rows, j = np.arange(curves.stations)[:, None], curves.segment(beta)
    blade = curves.loads[:, rows, j] + curves.slopes[:, rows, j] * (beta - curves.beta[rows, j])
    change = (np.roll(beta, -1, axis=0) - np.roll(beta, 1, axis=0)) / (2 * curves.spacing)
    blade += curves.rates[:, :, None] * change
    rotor = blade[:4].reshape(4, curves.blades, curves.positions, -1).sum(axis=1)
    rms = np.concatenate([rotor.std(axis=1), blade[4:].std(axis=1)])
    return np.asarray(rotor[0].mean(axis=0)), np.asarray(rms)


def ranks_of(
    objective: Objective, torque: FloatArray, rms: FloatArray, travel: FloatArray
) -> FloatArray:
    """What :func:`pitchopt.design.search.rank` says of many profiles, shape (G,)."""
    value = objective.torque * torque - objective.lambdas @ rms - objective.travel * travel
    return graded(objective, value, torque, rms[4])
