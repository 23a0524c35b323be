"""The comparison: prepare every method in every wind, and judge it in winds that none has met."""

from __future__ import annotations

import time
from collections.abc import Callable
from os import PathLike

import numpy as np

from pitchopt.cases import Case
from pitchopt.errors import ComputationError, PitchoptError
from pitchopt.studies.comparison.ground import Ground
from pitchopt.studies.comparison.measures import measure
from pitchopt.studies.comparison.methods import Methods
from pitchopt.studies.comparison.result import Comparison, Entry, Excerpt
from pitchopt.studies.comparison.settings import ComparisonSettings
from pitchopt.studies.tuning import PlantRun
from pitchopt.studies.tuning.plant import failure_of
from windfield import BoxCache

__all__ = ["compare"]

_TURNS = 2.0  # of the rotor in an excerpt
_STEP = 4  # steps of the progress that a method without tuner counts for

Progress = Callable[[int, int, str], None]


def compare(
    case: Case,
    settings: ComparisonSettings | None = None,
    *,
    workers: int | None = None,
    cache: BoxCache | None = None,
    journals: str | PathLike[str] | None = None,
    progress: Progress | None = None,
) -> Comparison:
    """Compare methods on the dynamic turbine of a case.

    Parameters
    ----------
    case : Case
        Turbine, mean wind, limits, and the objective of the design.
    settings : ComparisonSettings, optional
    workers : int, optional
        Threads; results do not depend on them.
    cache : BoxCache, optional
        Where Kaimal boxes are kept.
    journals : path, optional
        Folder of the tuners' studies; an interrupted comparison goes on from them.
    progress : callable, optional
        Called with steps done, steps in all and what is done.

    Returns
    -------
    Comparison

    Raises
    ------
    InputError
        If case and settings do not fit each other, or a journal is of another study.
    ComputationError
        If the collective controller itself diverges.

    Notes
    -----
    A method that cannot be had or that diverges in a wind is an entry that says so.
    """
    began = time.perf_counter()
    settings = ComparisonSettings() if settings is None else settings
    ground = Ground(case, settings, workers=workers, cache=cache)
    pairs = [(method, wind) for wind in ground.winds for method in settings.methods]
    sizes = [settings.evaluations if "ipc" in method else _STEP for method, _ in pairs]
    base = 0
    label = ""

    def told(done: int, total: int, _: str) -> None:
        if progress is not None:
            share = min(done / max(total, 1), 1.0)
            progress(base + round(share * current), sum(sizes), label)

    methods = Methods(ground, journals=journals, told=told)
    entries = []
    for (method, wind), current in zip(pairs, sizes, strict=True):
        label = method
        told(0, 1, "")
        entries.append(_entry(methods, method, wind))
        base += current
    return Comparison(
        ground=ground,
        settings=settings,
        winds=ground.winds,
        entries=tuple(entries),
        seconds=time.perf_counter() - began,
    )


def _entry(methods: Methods, method: str, wind: str) -> Entry:
    ground = methods.ground
    try:
        prepared = methods.prepare(method, wind)
        runs = ground.judge(prepared.controller, wind)
    except PitchoptError as error:
        if method == "collective" or str(error).startswith("journal:"):
            raise
        return Entry(method=method, wind=wind, status="failed", message=str(error))
    failure = failure_of(runs)
    if failure is not None:
        if method == "collective":
            raise ComputationError(f"the collective controller in wind {wind!r}: {failure}")
        return Entry(
            method=method, wind=wind, status="diverged", message=failure, prepared=prepared
        )
    return Entry(
        method=method,
        wind=wind,
        status="judged",
        prepared=prepared,
        runs=tuple(measure(run, ground.rate) for run in runs),
        excerpt=_excerpt(runs[0], ground.rotor_speed),
    )


def _excerpt(run: PlantRun, rotor_speed: float) -> Excerpt:
    """The first turns after the start-up, from blade 1 up."""
    simulation = run.simulation
    rows = simulation.after(run.skip)
    azimuth = rows[:, simulation.place("Azimuth")]
    wraps = np.flatnonzero(np.diff(azimuth) < -np.pi)
    first = int(wraps[0]) + 1 if wraps.size else 0
    count = round(_TURNS * 2.0 * np.pi / rotor_speed / simulation.interval) + 1
    part = rows[first : first + count]
    pitch = part[:, [simulation.place(f"BldPitch{k}") for k in (1, 2, 3)]]
    return Excerpt(
        time=part[:, 0] - part[0, 0],
        pitch=pitch[:, 0] - pitch.mean(axis=1),
        moment=np.array(part[:, simulation.place("RootMyc1")]),
    )
