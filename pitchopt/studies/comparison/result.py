"""Comparison: what the methods came to in each wind."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.studies.comparison.ground import Ground
from pitchopt.studies.comparison.measures import LOADS, Cut, RunMeasures, cut
from pitchopt.studies.comparison.methods import Prepared
from pitchopt.studies.comparison.settings import ComparisonSettings, intensity

__all__ = ["Comparison", "Entry", "Excerpt"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Excerpt:
    """Two turns of the rotor out of the first run of a method.

    Attributes
    ----------
    time, pitch, moment : ndarray (R,)
        From the excerpt's beginning [s]; pitch of blade 1 less the mean of the blades [rad], and
        its root moment out of plane [N m].
    """

    time: FloatArray
    pitch: FloatArray
    moment: FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class Entry:
    """One method in one wind.

    Attributes
    ----------
    method, wind : str
    status : {"judged", "diverged", "failed"}
    message : str
        Why it could not be judged.
    prepared : Prepared or None
        None where it failed.
    runs : tuple of RunMeasures
        In fresh seeds, the same for all methods; none unless judged.
    excerpt : Excerpt or None
    """

    method: str
    wind: str
    status: str
    message: str = ""
    prepared: Prepared | None = None
    runs: tuple[RunMeasures, ...] = ()
    excerpt: Excerpt | None = None

    def mean(self, name: str) -> float:
        """Mean over the runs of an attribute of `RunMeasures`."""
        return float(np.mean([getattr(run, name) for run in self.runs]))

    def load(self, kind: str, load: str) -> float:
        """Mean over the runs of the RMS (``rms``) or equivalent load (``del``) of a load [N m]."""
        return float(np.mean([run.figure(kind, load) for run in self.runs]))


@dataclass(frozen=True, kw_only=True, eq=False)
class Comparison:
    """Methods side by side.

    Attributes
    ----------
    ground : Ground
    settings : ComparisonSettings
    winds : tuple of str
        In the order of their intensity.
    entries : tuple of Entry
        Methods within winds.
    seconds : float
    """

    ground: Ground = field(repr=False)
    settings: ComparisonSettings
    winds: tuple[str, ...]
    entries: tuple[Entry, ...]
    seconds: float

    def entry(self, method: str, wind: str) -> Entry:
        """A method in a wind.

        Raises
        ------
        InputError
            If it is not part of the comparison.
        """
        for entry in self.entries:
            if (entry.method, entry.wind) == (method, wind):
                return entry
        raise InputError(f"method, wind: got {method!r} in {wind!r}, which were not compared")

    def cut(self, method: str, wind: str, kind: str, load: str) -> Cut | None:
        """What a method takes off a load of the collective controller; None if not judged."""
        mine, other = self.entry(method, wind), self.entry("collective", wind)
        if not mine.runs or not other.runs:
            return None
        return cut(mine.runs, other.runs, kind, load)

    def cuts(self, method: str, wind: str, kind: str = "del") -> dict[str, Cut]:
        """Those of all loads, as far as judged."""
        found = {load: self.cut(method, wind, kind, load) for load in LOADS}
        return {load: one for load, one in found.items() if one is not None}

    def intensity(self, wind: str) -> float:
        """Of a wind [-]."""
        return intensity(wind, self.ground.wind_speed)

    @property
    def excerpts(self) -> dict[str, dict[str, Excerpt]]:
        """Excerpts by wind and method, for pictures."""
        return {
            wind: {
                entry.method: entry.excerpt
                for entry in self.entries
                if entry.wind == wind and entry.excerpt is not None
            }
            for wind in self.winds
        }
