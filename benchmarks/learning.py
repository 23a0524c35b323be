"""Learners of pitch profiles: time of a rotation, and how near they come to the model's design.

Time: processor time that a learner takes for the passages of one rotation, at m = 24 and m = 360
positions, plant not counted; once with limits that never bind and once with the rate limit of
biegel2011.  An answer of the plant is drawn beforehand, so that nothing else is timed.

Table: learner x plant condition on two cases, 20 seeds each (one where nothing is random).
Figures are the weighted RMS of the exact loads in the last passage of a rotation over that of the
model-based design with the same mean torque, at rotations 10 and 20 after the experiment, median
and worst; and for a change of the wind the rotations from its begin until it is within 1.3 of the
new design, and the ratio to that ten rotations after its begin.  Both learners start from the same
constant pitch, with the same experiment and the same noise.

    python benchmarks/learning.py [--quick] [--out FILE.json]
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import _harness
import numpy as np

AIM_MS = {24: 0.2, 360: 5.0}
STEP_AT = 20


@dataclass(frozen=True, kw_only=True)
class Condition:
    """What a plant and its sensors are like."""

    name: str
    noise: float = 0.0
    of_mean: bool = False
    quantisation: float = 0.0
    delay: int = 0
    dropout: float = 0.0
    step: float = 0.0
    over: int = 0
    drift: float = 0.0
    offset_deg: float = 0.0
    separate: bool = False
    pitch_rate_deg: float | None = None

    @property
    def random(self) -> bool:
        """Whether seeds differ."""
        return bool(self.noise or self.dropout or self.drift)


CONDITIONS = (
    Condition(name="exact"),
    Condition(name="noise 2 % of RMS", noise=0.02),
    Condition(name="noise 5 % of RMS", noise=0.05),
    Condition(name="noise 2 % of mean", noise=0.02, of_mean=True),
    Condition(name="quantised to 1 % of RMS", quantisation=0.01),
    Condition(name="delay of 5 samples", delay=5),
    Condition(name="10 % of samples lost, noise 2 %", dropout=0.1, noise=0.02),
    Condition(name="wind +2 m/s", step=2.0),
    Condition(name="wind +2 m/s, noise 2 %", step=2.0, noise=0.02),
    Condition(name="wind -1 m/s, noise 2 %", step=-1.0, noise=0.02),
    Condition(name="wind +2 m/s over 10 rotations", step=2.0, over=10),
    Condition(name="wind +2 m/s over 10 rotations, noise 2 %", step=2.0, over=10, noise=0.02),
    Condition(name="wind drifts, 0.1 m/s, noise 2 %", drift=0.1, noise=0.02),
    Condition(name="actuators 2 deg/s, noise 2 %", pitch_rate_deg=2.0, noise=0.02),
    Condition(name="blade 1 off by 0.5 deg, one profile", offset_deg=0.5),
    Condition(name="blade 1 off by 0.5 deg, three profiles", offset_deg=0.5, separate=True),
    Condition(
        name="blade 1 off by 0.5 deg, three profiles, noise 2 %",
        offset_deg=0.5,
        separate=True,
        noise=0.02,
    ),
)


class Bench:
    """One case at one pitch rate, with what runs are compared with made once."""

    def __init__(self, name: str, speed: float, loss: float, values: dict[str, Any]) -> None:
        from pitchopt.cases import load_case
        from pitchopt.studies.learning import WindTasks

        self.name, self.speed, self.loss = name, speed, loss
        self.case = load_case(name).with_values({"wind.speed": speed, **values})
        self.tasks = WindTasks(case=self.case)
        self._references: dict[float, Any] = {}

    def reference(self, speed: float) -> Any:
        """Set-point, start and design at a wind speed."""
        from pitchopt.studies.learning import reference

        if speed not in self._references:
            self._references[speed] = reference(self.tasks, speed, max_power_loss=self.loss)
        return self._references[speed]

    @cached_property
    def start_loads(self) -> Any:
        """Loads at the pitch that runs start from, (4, m)."""
        return self.reference(self.speed).start_loads

    def run(self, learner: str, condition: Condition, seed: int, rotations: int) -> Any:
        """Ratios to the design after each rotation."""
        from ilc import ActuatorLimits, AdaptiveLearner, FixedLearner, Layout, Sensors
        from ilc import run as run_learner
        from pitchopt.studies.learning import (
            BladeDifference,
            ConstantWind,
            SetpointSchedule,
            StaticPlant,
            WindDrift,
            WindRamp,
            WindStep,
        )

        case, limits = self.case, self.case.pitch_limits
        first = self.reference(self.speed)
        wind: Any = ConstantWind(speed=self.speed)
        if condition.step:
            wind = WindStep(speed=self.speed, change=condition.step, rotation=STEP_AT)
        if condition.over:
            last = STEP_AT + condition.over
            wind = WindRamp(speed=self.speed, change=condition.step, first=STEP_AT, last=last)
        if condition.drift:
            wind = WindDrift(
                speed=self.speed, std=condition.drift, rotations_correlation=30, seed=seed
            )
        winds = {self.speed, self.speed + condition.step}
        designs = {speed: self.reference(speed) for speed in winds}
        layout = Layout(blades=case.blades, positions=case.positions, separate=condition.separate)
        kind = {"paper": FixedLearner, "adaptive": AdaptiveLearner}[learner]
        rotor = max(case.with_values({"wind.speed": v}).rotor_speed for v in designs)
        one = kind(
            layout=layout,
            limits=ActuatorLimits.from_rate(
                lower=limits.lower,
                upper=limits.upper,
                pitch_rate=limits.pitch_rate,
                rotor_speed=rotor,
                stations=layout.stations,
            ),
            start=first.start_pitch,
            setpoint=first.setpoint,
            weights=case.weights.array[:4],
            delay=condition.delay,
        )
        difference = None
        if condition.offset_deg:
            offset = float(np.deg2rad(condition.offset_deg))
            difference = BladeDifference(blade=1, pitch_offset=offset)
        plant = StaticPlant(
            tasks=self.tasks,
            wind=wind,
            offset=one.experiment_passages,
            difference=difference,
            operating_pitch={v: found.operating_pitch for v, found in designs.items()},
        )
        rms, mean = self.start_loads.std(axis=1), self.start_loads.mean(axis=1)
        record = run_learner(
            plant,
            one,
            rotations=rotations,
            setpoint=SetpointSchedule(tasks=self.tasks, wind=wind, max_power_loss=self.loss).at,
            sensors=Sensors.with_share(
                condition.noise,
                mean if condition.of_mean else rms,
                quantisation=condition.quantisation * rms,
                delay=condition.delay,
                dropout=condition.dropout,
                seed=seed,
            ),
        )
        after = designs[self.speed + condition.step]
        target = np.where(
            np.arange(1, rotations + 1) > STEP_AT,
            after.design.rms_weighted,
            first.design.rms_weighted,
        )
        return record.learning.ac_load / target


def table(report: _harness.Report, bench: Bench, condition: Condition, seeds: int) -> None:
    """Both learners in one condition."""
    rotations = STEP_AT + 15 if condition.step else STEP_AT
    for learner in ("paper", "adaptive"):
        runs = np.array(
            [
                bench.run(learner, condition, seed, rotations)
                for seed in range(seeds if condition.random else 1)
            ]
        )
        figures: dict[str, Any] = {}
        for rotation in (10, 20):
            figures[f"ratio_median_at_{rotation}"] = float(np.median(runs[:, rotation - 1]))
            figures[f"ratio_worst_at_{rotation}"] = float(runs[:, rotation - 1].max())
        if condition.step:
            near = runs[:, STEP_AT:] <= 1.3
            counts = [int(np.argmax(row)) + 1 if row.any() else None for row in near]
            found = [count for count in counts if count is not None]
            figures["recovery_median"] = statistics.median(found) if found else None
            figures["recovery_worst"] = max(found) if len(found) == len(counts) else None
            figures["ratio_median_10_after"] = float(np.median(runs[:, STEP_AT + 9]))
        report.add(
            "learner x condition",
            case=bench.name,
            wind_speed=bench.speed,
            max_power_loss=bench.loss,
            learner=learner,
            condition=condition.name,
            seeds=len(runs),
            **figures,
        )


def seconds_a_rotation(learner: str, positions: int, *, binding: bool, rotations: int) -> float:
    """Processor time of the passages of a rotation, median."""
    from ilc import ActuatorLimits, AdaptiveLearner, FixedLearner, Layout

    layout = Layout(blades=3, positions=positions)
    random = np.random.default_rng(_harness.SEED)
    psi = layout.azimuth[layout.index]
    rows = [-np.ones(psi.shape), -np.cos(psi), -np.sin(psi), -np.ones(psi.shape)]
    scale = np.array([3e6, 1e6, 1e6, 4e4])
    slopes = scale[:, None] * (
        np.stack(rows, axis=1) + 0.05 * random.normal(size=(positions, 4, 3))
    )
    values = scale * 0.01 * random.normal(size=(positions, 4))
    turn = 2 * np.pi / layout.stations
    step = turn * float(np.deg2rad(10.0)) / 2.0 if binding else 10.0
    kind = {"paper": FixedLearner, "adaptive": AdaptiveLearner}[learner]
    one = kind(
        layout=layout,
        limits=ActuatorLimits(lower=-0.2, upper=0.8, step=step),
        start=0.0,
        setpoint=0.0,
    )
    times = []
    for number in range(one.experiment_passages + 3 * rotations):
        pitch = one.profile[layout.index]
        loads = (values + np.einsum("plb,pb->pl", slopes, pitch)).T
        loads = loads + 0.002 * scale[:, None] * random.normal(size=loads.shape)
        began = time.process_time()
        one.tell(loads)
        one.profile  # noqa: B018  what a plant asks for is part of the passage
        if number >= one.experiment_passages:
            times.append(time.process_time() - began)
    return 3 * statistics.median(times)


def main(argv: list[str] | None = None) -> int:
    args = _harness.options(__doc__, argv)
    report = _harness.Report("learning", quick=args.quick, out=args.out)
    sizes, rotations = ((6, 12), 3) if args.quick else ((24, 360), 60)
    for positions in sizes:
        for learner in ("paper", "adaptive"):
            free, bound = (
                1e3 * seconds_a_rotation(learner, positions, binding=b, rotations=rotations)
                for b in (False, True)
            )
            report.add(
                "time of a rotation",
                learner=learner,
                positions=positions,
                milliseconds=free,
                milliseconds_rate_binding=bound,
                milliseconds_aim=AIM_MS.get(positions) if learner == "paper" else None,
            )
    few: dict[str, Any] = {"limits.positions": 6} if args.quick else {}
    cases: list[Callable[[dict[str, Any]], Bench]] = [
        lambda values: Bench("biegel2011", 15.0, 0.07, {**few, **values}),
    ]
    if not args.quick:
        cases.append(
            lambda values: Bench("nrel-5mw", 9.0, 0.03, {"limits.positions": 24, **values})
        )
    for make in cases:
        usual = make({})
        for condition in CONDITIONS[:2] if args.quick else CONDITIONS:
            bench = usual
            if condition.pitch_rate_deg is not None:
                rate = float(np.deg2rad(condition.pitch_rate_deg))
                bench = make({"limits.pitch_rate": rate})
            table(report, bench, condition, seeds=2 if args.quick else 20)
    report.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
