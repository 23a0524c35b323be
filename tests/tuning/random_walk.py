"""A tuner for tests of studies: each point depends on all costs before it, bit by bit."""

import numpy as np

from pitchopt.tuning import Parameter, Space, StagedTuner
from pitchopt.tuning.tuner import Proposal

SPACE = Space([Parameter(name="a", low=-1.0, high=2.0), Parameter(name="b", low=0.0, high=1.0)])


class RandomWalk(StagedTuner):
    name = "random-walk"

    def __init__(self, space=SPACE, *, seed=0, batch=3, stages=1000):
        super().__init__(space, seed=seed)
        self.batch = batch
        self.stages = stages

    def settings(self):
        return {"batch": self.batch, "stages": self.stages}

    def _stages(self):
        rng = np.random.default_rng(self.seed)
        centre = np.full(len(self.space), 0.5)
        for stage in range(self.stages):
            steps = rng.normal(size=(self.batch, len(self.space)))
            points = [self.space.from_unit(centre + 0.1 * step) for step in steps]
            told = yield [Proposal(x=x, origin=f"stage {stage + 1}") for x in points]
            weights = [1.0 / (1.0 + e.cost**2) if e.status == "ok" else 0.0 for e in told]
            centre = centre + 0.3 * np.average(steps, axis=0, weights=[w + 1e-3 for w in weights])


def bowl(x):
    return float((x[0] - 0.3) ** 2 + 3.0 * (x[1] - 0.6) ** 2)
