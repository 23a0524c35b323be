"""LearningSettings: everything that a learning run is told besides the case."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np

from pitchopt.checks import finite_number, whole_number
from pitchopt.errors import InputError
from pitchopt.studies.learning.plant import BladeDifference
from pitchopt.studies.learning.wind import ConstantWind, WindDrift, WindRamp, WindStep

__all__ = ["LearningSettings"]

DEFAULT_LOSS = 0.07
_FIXED_ONLY = ("learning_rate", "damping", "smoothing")
_WINDS = {ConstantWind: "constant", WindStep: "step", WindRamp: "ramp", WindDrift: "drift"}


@dataclass(frozen=True, kw_only=True)
class LearningSettings:
    """Learner, set-point, wind and sensors of one run.

    Parameters
    ----------
    learner : {"adaptive", "paper"}
        :class:`ilc.AdaptiveLearner` or :class:`ilc.FixedLearner`.
    rotations : int
        Rotations after the experiment, at least 1.
    max_power_loss, mean_torque : float, optional
        Set-point: a share of what each wind can give, 7 % without either, or a torque that stays
        [N m].  At most one is given.
    start_pitch : float, optional
        Constant pitch to start from [rad]; by default the one with the set-point's mean torque.
    learning_rate, damping, smoothing : float, optional
        Of the paper's learner; its own defaults without.
    separate : bool
        One profile for each blade.
    amplitude : float, optional
        Size of the perturbations in the experiment [rad]; the learner's default without.
    noise : float
        Standard deviation of the measurement noise, as a share of each load's RMS or mean at the
        starting pitch.
    noise_of : {"rms", "mean"}
        Which of the two.
    quantisation : float
        Step of the measurements, as a share of each load's RMS at the starting pitch.
    delay : int
        Samples by which the measurements lag; the learner is told.
    dropout : float
        Probability of each sample of each load to be lost.
    seed : int
        Of the sensors' random numbers.
    wind : ConstantWind, WindStep, WindRamp or WindDrift, optional
        From the case's wind speed; constant without.
    difference : BladeDifference, optional
        One blade that differs; the model-based designs do not know of it.

    Raises
    ------
    InputError
        If a value is out of range, or one of the paper's learner is given for the other.
    """

    learner: Literal["adaptive", "paper"] = "adaptive"
    rotations: int = 50
    max_power_loss: float | None = None
    mean_torque: float | None = None
    start_pitch: float | None = None
    learning_rate: float | None = None
    damping: float | None = None
    smoothing: float | None = None
    separate: bool = False
    amplitude: float | None = None
    noise: float = 0.0
    noise_of: Literal["rms", "mean"] = "rms"
    quantisation: float = 0.0
    delay: int = 0
    dropout: float = 0.0
    seed: int = 0
    wind: ConstantWind | WindStep | WindRamp | WindDrift | None = None
    difference: BladeDifference | None = None

    def __post_init__(self) -> None:
        checked: dict[str, Any] = {
            "rotations": whole_number("rotations", self.rotations, at_least=1),
            "delay": whole_number("delay", self.delay, at_least=0),
            "seed": whole_number("seed", self.seed, at_least=0),
            "noise": finite_number("noise", self.noise, at_least=0),
            "quantisation": finite_number("quantisation", self.quantisation, at_least=0),
            "dropout": finite_number("dropout", self.dropout, at_least=0, at_most=1),
        }
        for name, allowed in (("learner", ("adaptive", "paper")), ("noise_of", ("rms", "mean"))):
            if getattr(self, name) not in allowed:
                raise InputError(
                    f"{name}: got {getattr(self, name)!r}, expected {' or '.join(allowed)}"
                )
        if self.max_power_loss is not None and self.mean_torque is not None:
            raise InputError(
                "set-point: got both, expected at most one of max_power_loss, mean_torque"
            )
        if self.mean_torque is not None:
            checked["mean_torque"] = finite_number("mean_torque", self.mean_torque)
        else:
            loss = DEFAULT_LOSS if self.max_power_loss is None else self.max_power_loss
            checked["max_power_loss"] = finite_number("max_power_loss", loss, at_least=0, at_most=1)
        ranges: dict[str, dict[str, float]] = {
            "start_pitch": {},
            "amplitude": {"above": 0},
            "learning_rate": {"above": 0, "at_most": 1},
            "damping": {"at_least": 0},
            "smoothing": {"above": 0, "at_most": 1},
        }
        for name, limits in ranges.items():
            value = getattr(self, name)
            if value is None:
                continue
            checked[name] = finite_number(name, value, **limits)
            if name in _FIXED_ONLY and self.learner != "paper":
                raise InputError(
                    f"{name}: got {value:g} with the adaptive learner, expected it with the "
                    "paper's alone"
                )
        for name, kinds in (("wind", tuple(_WINDS)), ("difference", (BladeDifference,))):
            value = getattr(self, name)
            if value is not None and not isinstance(value, kinds):
                names = ", ".join(kind.__name__ for kind in kinds)
                raise InputError(f"{name}: got {type(value).__name__}, expected {names}")
        if not isinstance(self.separate, (bool, np.bool_)):
            raise InputError(f"separate: got {self.separate!r}, expected True or False")
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    def plain(self) -> dict[str, Any]:
        """The settings as plain data, angles in degrees."""
        out = {
            name: getattr(self, name)
            for name in (
                *("learner", "rotations", "max_power_loss", "mean_torque", *_FIXED_ONLY),
                *("separate", "noise", "noise_of", "quantisation", "delay", "dropout", "seed"),
            )
        }
        for name in ("start_pitch", "amplitude"):
            value = getattr(self, name)
            out[f"{name}_deg"] = None if value is None else float(np.rad2deg(value))
        out["wind"] = None
        if self.wind is not None:
            out["wind"] = {"kind": _WINDS[type(self.wind)], **asdict(self.wind)}
        out["different_blade"] = None
        if self.difference is not None:
            out["different_blade"] = {
                "blade": self.difference.blade,
                "pitch_offset_deg": float(np.rad2deg(self.difference.pitch_offset)),
                "chord": self.difference.chord,
            }
        return out
