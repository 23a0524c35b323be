"""Drives a tuner as a study does: results in the order of asking, with some asked ahead."""

import numpy as np

from pitchopt.tuning import Candidate


def drive(tuner, function, evaluations, *, parallel=1, journal=()):
    """Candidates of a study; the first ones are taken over from `journal`."""
    asked, waiting = [], []
    for _ in range(evaluations):
        while len(waiting) < parallel:
            number = len(asked)
            if number < len(journal):
                old = journal[number]
                copy = Candidate(
                    index=old.index, x=old.x.tolist(), origin=old.origin, note=old.note
                )
                taken = tuner.adopt(copy)
                new = [] if taken is None else [taken]
            else:
                new = tuner.ask(1)
            if not new:
                break
            asked += new
            waiting += new
        if not waiting:
            break
        candidate = waiting.pop(0)
        tuner.tell(candidate, function(candidate.x))
    return asked


def same(candidates, others):
    """Whether two lists of candidates are the same, bit by bit."""
    return len(candidates) == len(others) and all(
        a.index == b.index and a.origin == b.origin and np.array_equal(a.x, b.x)
        for a, b in zip(candidates, others, strict=True)
    )
