"""Spent: what a method took before it could be judged."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Spent"]


@dataclass(frozen=True, kw_only=True)
class Spent:
    """Effort.

    Attributes
    ----------
    evaluations : int
        Controllers that a tuner tried, or passages after which a learner changed the profile.
    simulations : int
        Runs of the turbine for them.
    rotations : float
        Turns of the rotor, of the turbine or of its model.
    turbine_time : float
        That they take [s].
    seconds : float
        On this machine.
    """

    evaluations: int = 0
    simulations: int = 0
    rotations: float = 0.0
    turbine_time: float = 0.0
    seconds: float = 0.0

    def __add__(self, other: Spent) -> Spent:
        """Both one after the other."""
        return Spent(
            evaluations=self.evaluations + other.evaluations,
            simulations=self.simulations + other.simulations,
            rotations=self.rotations + other.rotations,
            turbine_time=self.turbine_time + other.turbine_time,
            seconds=self.seconds + other.seconds,
        )
