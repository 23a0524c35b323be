"""Tuned problems as plain data: the JSON document and the table of ``pitchopt tune``.

Points and measures are in SI units.  ``cost`` is what was evaluated; where a tuner has a surrogate,
``estimate`` and ``std`` are its posterior mean and standard deviation there.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from pitchopt.exports.records import records_csv
from pitchopt.studies.tuning.guidelines import agreement
from pitchopt.studies.tuning.tune import Tuned
from pitchopt.tuning import Evaluation

FIRST_FRESH = 1001
"""First of the seeds that judge what was tuned: beyond those that anyone tunes with."""

__all__ = [
    "FIRST_FRESH",
    "agreement_record",
    "comparison_document",
    "evaluation_record",
    "evaluations_csv",
    "tuned_document",
]


def tuned_document(tuned: Tuned) -> dict[str, Any]:
    """Everything about a study."""
    best, tuner = tuned.result.best, tuned.result.tuner
    return {
        "problem": tuned.problem.name,
        "turbine": tuned.problem.plant.turbine.name,
        "method": tuned.method,
        "parameters": list(tuned.problem.space.names),
        "settings": {
            "problem": tuned.problem.document(),
            "tuner": {"seed": tuner.seed, **tuner.settings()},
        },
        "start": _point(tuned.start),
        "best": {**_point(tuned.best), "estimate": best.cost, "std": best.std},
        "gain": tuned.gain,
        "evaluations": [evaluation_record(e) for e in tuned.result.evaluations],
        "simulations": tuned.simulations,
        "seconds": tuned.seconds,
    }


def agreement_record(tuned: Tuned) -> dict[str, Any]:
    """The closing check by kriging as ``agreement``, for the tuners and spaces that it is for.

    Those are the zeroth-order and the Bayesian tuner with one or two parameters.  The minimum of
    kriging is simulated for it, which ``simulations`` leaves out.
    """
    good = {tuple(e.x) for e in tuned.result.evaluations if e.status == "ok"}
    space = tuned.problem.space
    if tuned.method not in ("zoo", "bayes") or len(space) > 2 or len(good) <= len(space) + 1:
        return {}
    found = agreement(
        space,
        tuned.result.evaluations,
        tuned.best,
        tuned.start,
        lambda x: tuned.problem(x).cost,
    )
    return {
        "agreement": {
            "agrees": found.agrees,
            "x": found.kriging.tolist(),
            "gap": found.gap if math.isfinite(found.gap) else None,
            "tolerance": found.tolerance,
            "distance": found.distance,
        }
    }


def comparison_document(studies: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Several studies and one table of them, best gain of each problem first."""
    keys = ("problem", "method", "turbine", "gain", "fresh_gain", "simulations", "seconds")
    rows = [
        {
            **{key: study[key] for key in keys if key in study},
            "evaluations": len(study["evaluations"]),
            "start_cost": study["start"]["cost"],
            "best_cost": study["best"]["cost"],
            "best_x": study["best"]["x"],
            "parameters": study["parameters"],
        }
        for study in studies
    ]
    problems = list(dict.fromkeys(row["problem"] for row in rows))
    rows.sort(key=lambda row: (problems.index(row["problem"]), -row["gain"]))
    return {
        "studies": list(studies),
        "comparison": rows,
        "simulations": sum(study["simulations"] for study in studies),
    }


def evaluation_record(evaluation: Evaluation) -> dict[str, Any]:
    """One evaluation as plain data."""
    return {
        "number": evaluation.index,
        "origin": evaluation.origin,
        **_point(evaluation),
        "variance": evaluation.variance,
        "replicates": list(evaluation.replicates),
        "status": evaluation.status,
        "message": evaluation.message,
        "seconds": evaluation.seconds,
    }


def evaluations_csv(document: Mapping[str, Any]) -> str:
    """Evaluations of a document, one row each: points by name, measures, what became of them."""
    left_out = ("x", "replicates", "measures")
    return records_csv(
        [
            {
                **dict(zip(document["parameters"], e["x"], strict=True)),
                **{key: value for key, value in e.items() if key not in left_out},
                **e["measures"],
            }
            for e in document["evaluations"]
        ]
    )


def _point(evaluation: Evaluation) -> dict[str, Any]:
    return {
        "x": evaluation.x.tolist(),
        "cost": None if math.isnan(evaluation.cost) else evaluation.cost,
        "measures": dict(evaluation.measures),
    }
