"""What a design stores so that its bound can be checked: numbers and limits, no solver.

A certificate holds the objective, the limits and either the multipliers of one bound
(:func:`pitchopt.design.certificate.lagrangian_bound`) or the tree of a branch and bound.  With the
BladeCurves it was made for, :meth:`Certificate.check` computes the bound again.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.aero.curves import BladeCurves
from pitchopt.checks import finite_array
from pitchopt.design.certificate import lagrangian_bound
from pitchopt.design.limits import PitchLimits
from pitchopt.design.multipliers import Multipliers
from pitchopt.design.problem import DesignProblem, Objective
from pitchopt.design.proof.record import Proof, check_proof, problem_digest
from pitchopt.design.proof.region import Frame, Region, dual_step, tightened
from pitchopt.errors import InputError

__all__ = ["Certificate"]

FloatArray = NDArray[np.float64]

_PASSES = 3
_HULL, _TREE = "hull relaxation", "branch and bound"


@dataclass(frozen=True, kw_only=True, eq=False)
class Certificate:
    """A bound on the objective of every feasible profile, and what proves it.

    Attributes
    ----------
    upper_bound : float
        [N m]
    objective : Objective
        What is bounded, with the limits on mean torque and blade load that profiles keep.
    limits : PitchLimits
    curves : BladeCurves
        What the bound is about.
    multipliers : Multipliers
        Of the hull relaxation.
    proof : Proof or None
        The tree of regions, where there is one.
    mean_pitch : float or None
        The bound is for profiles of this mean, at which the wake is frozen [rad].
    left_out : str
        Restrictions that the bound does not use: it is that of the wider problem.
    digest : str
        Of the curves, limits and objective.
    """

    upper_bound: float
    objective: Objective
    limits: PitchLimits
    curves: BladeCurves
    multipliers: Multipliers
    proof: Proof | None
    mean_pitch: float | None
    left_out: str
    digest: str

    @classmethod
    def of(
        cls,
        problem: DesignProblem,
        objective: Objective,
        upper_bound: float,
        multipliers: Multipliers,
        proof: Proof | None = None,
    ) -> Certificate:
        """The certificate of a bound on a problem."""
        return cls(
            upper_bound=upper_bound,
            objective=objective,
            limits=problem.limits,
            curves=problem.curves,
            multipliers=multipliers,
            proof=proof,
            mean_pitch=problem.curves.mean_pitch,
            left_out="harmonics" if problem.harmonics is not None else "",
            digest=problem_digest(problem, objective),
        )

    @property
    def method(self) -> str:
        """``hull relaxation`` or ``branch and bound``."""
        return _HULL if self.proof is None else _TREE

    def check(self, curves: BladeCurves | None = None) -> float:
        """Compute the bound again from the curves [N m].

        Parameters
        ----------
        curves : BladeCurves, optional
            As the model gives them, or already narrowed to the limits; those of the certificate
            by default.

        Returns
        -------
        float
            What is proven; at most ``upper_bound`` but for rounding.

        Raises
        ------
        InputError
            If the certificate was made for other curves.
        """
        problem = DesignProblem(curves=curves or self.curves, limits=self.limits)
        if problem_digest(problem, self.objective) != self.digest:
            raise InputError("certificate: made for other curves than those it is checked against")
        if self.proof is not None:
            return check_proof(self.proof, problem, self.objective)
        return lagrangian_bound(problem, self.objective, self.multipliers)[0]

    def intervals(self, value: float) -> tuple[FloatArray, FloatArray] | None:
        """Pitch intervals (N,) that hold every profile whose objective is at least ``value`` [rad].

        None when no profile is worth so much.
        """
        frame = Frame(DesignProblem(curves=self.curves, limits=self.limits), self.objective)
        region: Region | None = frame.first()
        for _ in range(_PASSES):
            if region is not None:
                region = tightened(frame, region, value)
            if region is not None:
                region = dual_step(frame, region, self.multipliers, value)[1]
        return None if region is None else (region.lower, region.upper)

    # ---- storage -------------------------------------------------------------------------

    def arrays(self) -> dict[str, Any]:
        """Everything but the curves, as arrays by name."""
        mult, objective, limits = self.multipliers, self.objective, self.limits
        data: dict[str, Any] = {
            "upper_bound": self.upper_bound,
            "objective": np.array(
                [
                    objective.torque,
                    *objective.rms,
                    objective.travel,
                    objective.torque_min,
                    objective.torque_max,
                    objective.blade_cap,
                ]
            ),
            "limits": np.array([limits.rotor_speed, limits.pitch_rate, limits.lower, limits.upper]),
            "loads": mult.loads,
            "blade": mult.blade,
            "rate": mult.rate,
            "single": np.array([mult.torque_min, mult.torque_max, mult.cap, mult.mean]),
            "mean_pitch": np.nan if self.mean_pitch is None else self.mean_pitch,
            "left_out": np.array(self.left_out),
            "digest": np.array(self.digest),
        }
        if self.proof is not None:
            for field in fields(Proof):
                data["tree_" + field.name] = getattr(self.proof, field.name)
        return data

    @classmethod
    def from_arrays(cls, data: Mapping[str, Any], curves: BladeCurves) -> Certificate:
        """What :meth:`arrays` made of a certificate."""
        numbers = [float(v) for v in data["objective"]]
        speed, rate, lower, upper = (float(v) for v in data["limits"])
        low, high, cap, mean = (float(v) for v in data["single"])
        mean_pitch = float(data["mean_pitch"])
        a, b, c, d, e = numbers[1:6]
        proof = None
        if "tree_digest" in data:
            tree = {field.name: data["tree_" + field.name] for field in fields(Proof)}
            tree["digest"], tree["upper_bound"] = str(tree["digest"]), float(tree["upper_bound"])
            proof = Proof(**tree)
        return cls(
            upper_bound=float(data["upper_bound"]),
            objective=Objective(
                torque=numbers[0],
                rms=(a, b, c, d, e),
                travel=numbers[6],
                torque_min=numbers[7],
                torque_max=numbers[8],
                blade_cap=numbers[9],
            ),
            limits=PitchLimits(rotor_speed=speed, pitch_rate=rate, lower=lower, upper=upper),
            curves=curves,
            multipliers=Multipliers(
                loads=finite_array("loads", data["loads"], shape=(4, curves.positions)),
                blade=finite_array("blade", data["blade"], shape=(curves.stations,)),
                rate=finite_array("rate", data["rate"], shape=(curves.stations,)),
                torque_min=low,
                torque_max=high,
                cap=cap,
                mean=mean,
            ),
            proof=proof,
            mean_pitch=None if np.isnan(mean_pitch) else mean_pitch,
            left_out=str(data["left_out"]),
            digest=str(data["digest"]),
        )
