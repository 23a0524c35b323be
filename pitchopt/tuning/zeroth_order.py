"""Zeroth-order tuning: a projected gradient method on gradients estimated from samples.

Each stage r samples the cost at J directions of unit length round its point z (2), estimates

    G(z) = 1/J sum_j [C(z + mu phi_j) - C(z)] / mu  phi_j,                                   (3)

and tries steps along d = -D G, projected into the bounds less the radius mu (6), with
alpha_k = alpha_0 beta^(k-1) for k = 1..k_max (7), until one satisfies Armijo's rule (8).  Where
none does, the best sample of all becomes the next point (10).

The mean of phi phi' over directions of unit length is I/M, so G estimates the gradient over the
number of parameters M, and step and threshold refer to that, as in the paper.  In 1-D, with -1 and
+1, it is the central difference.  In 2-D, with even spacing, it is exactly half of the gradient of
a quadratic from J = 4 on, and with J = 3 in the mean over the first angle.

Source: Zalkind, Dall'Anese, Pao, Automatic controller tuning using a zeroth-order optimization
algorithm, Wind Energy Science 5 (2020), sections 2 and 4.3.  Four things differ from its print:
directions are spaced by 2 pi/J for any J (34); a step counts in Armijo's rule as it is after
projection, C(z) - C(z_k) > sigma G'(z - z_k) > 0 (8); a reset to a sample that lies outside of the
shrunken bounds goes to its projection, or to the best sample inside where the projection turns out
worse, so that costs of stages never grow (10); and nothing is evaluated twice.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number, whole_number
from pitchopt.errors import InputError
from pitchopt.tuning.evaluations import Evaluation
from pitchopt.tuning.space import Space
from pitchopt.tuning.tuner import Proposal, StagedTuner, Stages

__all__ = ["StageRecord", "ZerothOrder", "settling"]

_SAME = 1e-9  # of a range: closer points are one point


@dataclass(frozen=True, kw_only=True)
class StageRecord:
    """One stage, for tables.

    Attributes
    ----------
    stage : int
        r, from 1.
    x, next_x : (d,) ndarray
        z^r and z^(r+1) in the units of the space.
    cost, next_cost : float
        There; NaN where the evaluation failed.
    gradient : (d,) ndarray
        Estimate (3), in the coordinates that the tuner works in.
    step : float
        alpha_k that was accepted; 0 after a reset.
    accepted : int
        k that was accepted; 0 after a reset.
    """

    stage: int
    x: FloatArray
    next_x: FloatArray
    cost: float
    next_cost: float
    gradient: FloatArray
    step: float
    accepted: int

    @property
    def reset(self) -> bool:
        """Whether no step was accepted, so that the best sample became the next point."""
        return self.accepted == 0


def settling(costs: ArrayLike) -> FloatArray:
    """Settling function (21): what share of the gain is still to come at each stage.

    Parameters
    ----------
    costs : (N + 1,) array_like
        C(z^1) ... C(z^N), C(z^soln), as `ZerothOrder.stage_costs` has them.

    Returns
    -------
    (N + 1,) ndarray
        From 1 to 0; 0 throughout where nothing was gained.
    """
    costs = finite_array("costs", costs)
    gain = costs[-1] - costs[0]
    return np.zeros(costs.size) if gain == 0.0 else (costs[-1] - costs) / gain


class ZerothOrder(StagedTuner):
    """Zeroth-order tuner.

    Parameters
    ----------
    space : Space
    start : (d,) array_like, optional
        z^1 in the units of the space; the middle by default.  It is moved into the shrunken bounds.
    radius : float or (d,) array_like, optional
        mu, in the coordinates that the tuner works in; 0.05 of each range by default.  Where it
        differs between parameters, (2) and (3) hold in parameters over their radius.
    samples : int, optional
        J in a stage; d + 1 by default.
    stages : int
        N.
    step : float, optional
        alpha_0.  By default such that its product with the norm of the first gradient that is not
        zero is `product`.
    step_over : str, optional
        Divides `step` by the absolute value at the first point: of the cost (``cost``) or of the
        measure of that name, as in the paper's 10/P(z^1) and 3/M(z^1).
    product : float
        Of step and norm of the gradient, 0.5 to 1.5 (38): the first step in the coordinates that
        the tuner works in.  The rule takes it that ranges are of the order of 1.
    scaling : (d,) array_like, optional
        Diagonal of D; ones by default.  (37) makes it the inverse second derivatives.
    shrinkage, threshold, steps : float, float, int
        beta, sigma and k_max of the line search.
    directions : {"even", "random", "orthogonal"}, optional
        Even: -1 and +1 in 1-D (26), evenly spaced from a random angle in 2-D (33), (34); random:
        Gaussian, brought to unit length; orthogonal: plus and minus the axes of frames that are
        turned at random, exact for a quadratic where J is a multiple of 2 d.  Even by default in
        1-D and 2-D, else random.
    coordinates : {"unit", "own"}
        Unit coordinates of the space, or the units of the parameters, as the paper has it.
    line_search : {"sequential", "parallel"}
        One step after the other, or all that may be needed side by side; the same is accepted.
    seed : int

    Notes
    -----
    The samples of a stage, and in the first stage its point with them, may be evaluated in
    parallel.  At most 1 + N (J + k_max) points are evaluated, and one more for each reset but in
    the last stage; the paper's 7 stages with J = 2 and k_max = 3 may take 36 by this count, and
    took 31.

    Points that failed or break constraints enter (3), (8) and (10) with their `merit`, so a
    gradient points away from a failed sample by the range of costs that is known; a stage whose
    own point failed takes no step but goes to the best sample, and where all failed it stays.
    Periodic parameters have no bounds and move by half a period at most.
    """

    name: ClassVar[str] = "zoo"

    def __init__(
        self,
        space: Space,
        *,
        start: ArrayLike | None = None,
        radius: float | ArrayLike | None = None,
        samples: int | None = None,
        stages: int = 10,
        step: float | None = None,
        step_over: str | None = None,
        product: float = 1.0,
        scaling: ArrayLike | None = None,
        shrinkage: float = 0.5,
        threshold: float = 0.05,
        steps: int = 3,
        directions: Literal["even", "random", "orthogonal"] | None = None,
        coordinates: Literal["unit", "own"] = "unit",
        line_search: Literal["sequential", "parallel"] = "sequential",
        seed: int = 0,
    ) -> None:
        super().__init__(space, seed=seed)
        size = len(space)
        _choice("coordinates", coordinates, ("unit", "own"))
        _choice("line_search", line_search, ("sequential", "parallel"))
        directions = directions or ("even" if size <= 2 else "random")
        _choice("directions", directions, ("even", "random", "orthogonal"))
        self.coordinates, self.line_search, self.directions = coordinates, line_search, directions
        self._low = np.zeros(size) if coordinates == "unit" else space.lower
        self._high = np.ones(size) if coordinates == "unit" else space.upper
        self.radius = self._checked_radius(radius)
        self.samples = whole_number("samples", size + 1 if samples is None else samples, at_least=1)
        even = (self.samples == 2, self.samples >= 2)[size - 1] if size <= 2 else False
        if directions == "even" and not even:
            raise InputError(
                f"directions: got even with {self.samples} samples of {size} parameters, expected "
                "two samples of one parameter or at least two of two; else take random ones"
            )
        self.stages = whole_number("stages", stages, at_least=1)
        self.step = None if step is None else finite_number("step", step, above=0.0)
        if step_over is not None and step is None:
            raise InputError(f"step_over: got {step_over!r} without a step, expected both")
        self.step_over = step_over
        self.product = finite_number("product", product, above=0.0)
        self.scaling = finite_array(
            "scaling", np.ones(size) if scaling is None else scaling, shape=(size,)
        )
        if np.any(self.scaling <= 0.0):
            raise InputError(f"scaling: got {self.scaling.min():g}, expected positive numbers")
        self.shrinkage = finite_number("shrinkage", shrinkage, above=0.0)
        self.threshold = finite_number("threshold", threshold, above=0.0)
        for field in ("shrinkage", "threshold"):
            if getattr(self, field) >= 1.0:
                raise InputError(f"{field}: got {getattr(self, field):g}, expected less than 1")
        self.steps = whole_number("steps", steps, at_least=1)
        middle = space.from_unit(np.full(size, 0.5))
        self._start = self._into(self._inward(space.point(middle if start is None else start)))
        self._records: list[StageRecord] = []

    def _checked_radius(self, radius: float | ArrayLike | None) -> FloatArray:
        width = self._high - self._low
        given = 0.05 * width if radius is None else np.asarray(radius)
        if given.ndim == 0:
            given = np.full(width.size, finite_number("radius", radius, above=0.0))
        found = finite_array("radius", given, shape=width.shape)
        bad = (found <= 0.0) | (found >= 0.5 * width)
        if np.any(bad):
            place = int(np.argmax(bad))
            raise InputError(
                f"radius: got {found[place]:g} for {self.space.names[place]}, expected above 0 and "
                f"below half of its range, {0.5 * width[place]:g} in {self.coordinates} coordinates"
            )
        return found

    @property
    def start(self) -> FloatArray:
        """z^1 in the units of the space, after it was moved into the shrunken bounds."""
        return self._outward(self._start)

    @property
    def records(self) -> tuple[StageRecord, ...]:
        """Stages that are done."""
        return tuple(self._records)

    @property
    def stage_costs(self) -> FloatArray:
        """C(z^1) ... C(z^(r+1)) of the stages that are done."""
        costs = [record.cost for record in self._records]
        return np.array([*costs, *(record.next_cost for record in self._records[-1:])])

    @property
    def most_evaluations(self) -> int:
        """Evaluations that the stages can take."""
        return self.stages * (self.samples + self.steps + 1)

    def settings(self) -> dict[str, object]:
        """Plain data that names the tuner."""
        return {
            "name": self.name,
            "seed": self.seed,
            "start": self.start.tolist(),
            "radius": self.radius.tolist(),
            "samples": self.samples,
            "stages": self.stages,
            "step": self.step,
            "step_over": self.step_over,
            "product": self.product,
            "scaling": self.scaling.tolist(),
            "shrinkage": self.shrinkage,
            "threshold": self.threshold,
            "steps": self.steps,
            "directions": self.directions,
            "coordinates": self.coordinates,
            "line_search": self.line_search,
        }

    def _stages(self) -> Stages:
        z, first_step = self._start, math.nan
        for stage in range(1, self.stages + 1):
            phi = self._directions(stage)
            labels = ["start" if stage == 1 else f"stage {stage}"]
            labels += [f"search {stage}.{j}" for j in range(1, self.samples + 1)]
            here, *around = yield from self._evaluated([z, *(z + self.radius * phi)], labels)
            gradient = self._gradient(here, around, phi)
            accepted, step, following = 0, 0.0, here
            if here.status == "ok" and np.any(gradient):
                if math.isnan(first_step):
                    first_step = self._first_step(here, gradient)
                accepted, step, following = yield from self._line_search(
                    stage, z, here, gradient, first_step
                )
            if not accepted:
                following = yield from self._reset(stage, here)
            z = self._inward(following.x)
            self._records.append(
                StageRecord(
                    stage=stage,
                    x=here.x,
                    next_x=following.x,
                    cost=here.cost,
                    next_cost=following.cost,
                    gradient=gradient,
                    step=step,
                    accepted=accepted,
                )
            )

    def _directions(self, stage: int) -> FloatArray:
        """phi_j of a stage, (J, d), of unit length."""
        size = len(self.space)
        rng = np.random.default_rng([self.seed, stage])
        if self.directions == "even":
            if size == 1:
                return np.array([[-1.0], [1.0]])
            first = rng.uniform(0.0, 2.0 * np.pi)
            psi = first + 2.0 * np.pi * np.arange(1, self.samples + 1) / self.samples
            return np.column_stack([np.cos(psi), np.sin(psi)])
        if self.directions == "random":
            phi = rng.standard_normal((self.samples, size))
            return np.asarray(phi / np.linalg.norm(phi, axis=1, keepdims=True))
        frames = []
        for _ in range(math.ceil(self.samples / (2 * size))):
            axes = np.linalg.qr(rng.standard_normal((size, size)))[0].T
            frames += [sign * axis for axis in axes for sign in (1.0, -1.0)]
        return np.array(frames[: self.samples])

    def _gradient(
        self, here: Evaluation, around: Sequence[Evaluation], phi: FloatArray
    ) -> FloatArray:
        """Estimate (3); zero where no merit is known yet."""
        merits = self.merits([here, *around])
        if not math.isfinite(merits[0]):
            return np.zeros(len(self.space))
        change = merits[1:] - merits[0]
        return np.asarray(np.mean(change[:, np.newaxis] * phi, axis=0) / self.radius)

    def _first_step(self, here: Evaluation, gradient: FloatArray) -> float:
        """alpha_0."""
        if self.step is None:
            return self.product / float(np.linalg.norm(gradient))
        if self.step_over is None:
            return self.step
        measures = {"cost": here.cost, **here.measures}
        value = abs(measures.get(self.step_over, math.nan))
        if not 0.0 < value < math.inf:
            raise InputError(
                f"step_over: got {self.step_over!r}, expected what is known of the first point and "
                f"is neither zero nor infinite, of: {', '.join(measures)}"
            )
        return self.step / value

    def _line_search(
        self, stage: int, z: FloatArray, here: Evaluation, gradient: FloatArray, first: float
    ) -> Generator[list[Proposal], list[Evaluation], tuple[int, float, Evaluation]]:
        """First step that satisfies Armijo's rule (8): k, alpha_k and its point."""
        alphas = first * self.shrinkage ** np.arange(self.steps)
        targets = [self._into(z - alpha * self.scaling * gradient, z) for alpha in alphas]
        labels = [f"step {stage}.{k}" for k in range(1, self.steps + 1)]
        together = self.steps if self.line_search == "parallel" else 1
        for begin in range(0, self.steps, together):
            batch = slice(begin, begin + together)
            tried = yield from self._evaluated(targets[batch], labels[batch])
            for k, point in enumerate(tried, start=begin):
                expected = self.threshold * float(gradient @ (z - targets[k]))
                before, after = self.merits([here, point])
                if expected > 0.0 and before - after > expected:
                    return k + 1, float(alphas[k]), point
        return 0, 0.0, here

    def _reset(
        self, stage: int, here: Evaluation
    ) -> Generator[list[Proposal], list[Evaluation], Evaluation]:
        """Best of all samples (10): inside the shrunken bounds unless it is the last stage."""
        best = self._least([here, *self.evaluations])
        z = self._inward(best.x)
        if stage == self.stages or self._same(self._into(z), z):
            return best
        yield from self._evaluated([self._into(z)], [f"reset {stage}"])
        inside = [e for e in self.evaluations if self._same(self._into(w := self._inward(e.x)), w)]
        return self._least([here, *inside])

    def _least(self, evaluations: Sequence[Evaluation]) -> Evaluation:
        return evaluations[int(np.argmin(self.merits(evaluations)))]

    def _evaluated(
        self, points: Sequence[FloatArray], labels: Sequence[str]
    ) -> Generator[list[Proposal], list[Evaluation], list[Evaluation]]:
        """Evaluations of points in working coordinates; asks only for those that are not known."""
        wanted: list[tuple[FloatArray, str]] = []
        for z, label in zip(points, labels, strict=True):
            if self._known(z) is None and not any(self._same(z, other) for other, _ in wanted):
                wanted.append((z, label))
        if wanted:
            yield [Proposal(x=self._outward(z), origin=label) for z, label in wanted]
        found = [self._known(z) for z in points]
        return [evaluation for evaluation in found if evaluation is not None]

    def _known(self, z: FloatArray) -> Evaluation | None:
        return next((e for e in self.evaluations if self._same(self._inward(e.x), z)), None)

    def _same(self, z: FloatArray, other: FloatArray) -> bool:
        width = self._high - self._low
        apart = np.abs(z - other) / width
        apart = np.where(self.space.periodic, np.abs(apart - np.round(apart)), apart)
        return bool(np.all(apart <= _SAME))

    def _into(self, z: FloatArray, origin: FloatArray | None = None) -> FloatArray:
        """Projection into the shrunken bounds; of a periodic parameter within half a period."""
        inside = np.clip(z, self._low + self.radius, self._high - self.radius)
        if origin is None:
            return np.where(self.space.periodic, z, inside)
        half = 0.5 * (self._high - self._low)
        return np.where(self.space.periodic, np.clip(z, origin - half, origin + half), inside)

    def _inward(self, x: FloatArray) -> FloatArray:
        return self.space.to_unit(x) if self.coordinates == "unit" else np.asarray(x)

    def _outward(self, z: FloatArray) -> FloatArray:
        return self.space.from_unit(z) if self.coordinates == "unit" else self.space.project(z)


def _choice(field: str, value: object, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise InputError(f"{field}: got {value!r}, expected one of {', '.join(allowed)}")
