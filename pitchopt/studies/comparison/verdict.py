"""Verdict: where a profile that is planned for a steady wind stops paying in turbulence.

A method pays in a load where the confidence interval of the cut lies above one per cent, it costs
where that lies below minus one per cent, and it does nothing where it lies between the two.  Any
other interval is too wide to tell, and so is a single seed.  It stops paying by the first wind, in
the order of intensity, in which it no longer pays in a load that it paid in before: it does nothing
there, costs, or is lost in the scatter of the seeds.
"""

from __future__ import annotations

from dataclasses import dataclass

from pitchopt.errors import InputError
from pitchopt.studies.comparison.measures import LOADS, Cut, cut
from pitchopt.studies.comparison.result import Comparison

__all__ = ["WORTH", "LoadVerdict", "added", "effect", "sentences", "verdicts", "wind_name"]

WORTH = 0.01
"""Least cut that counts [-]."""

_WORDS = {
    "blade": "blade out of plane",
    "tower": "tower fore-aft",
    "tilt": "tilt",
    "yaw": "yaw",
    "torque": "torque",
}


_STOPS = {"costs": "costs", "nothing": "stops paying", "unclear": "lost in the scatter"}


@dataclass(frozen=True, kw_only=True)
class LoadVerdict:
    """What a method does to one damage-equivalent load from wind to wind.

    Attributes
    ----------
    load : str
    cuts : dict of str to Cut
        By wind, in the order of intensity.
    effects : dict of str to str
        ``pays``, ``costs``, ``nothing`` or ``unclear``, by wind.
    stops_at : str or None
        First wind in which it no longer pays after one in which it did.
    """

    load: str
    cuts: dict[str, Cut]
    effects: dict[str, str]
    stops_at: str | None


def effect(found: Cut) -> str:
    """``pays``, ``costs``, ``nothing`` or ``unclear``; see the module."""
    if found.least > WORTH:
        return "pays"
    if found.most < -WORTH:
        return "costs"
    if found.least >= -WORTH and found.most <= WORTH:
        return "nothing"
    return "unclear" if found.half_width is not None else "nothing"


def wind_name(wind: str) -> str:
    """A wind in words."""
    if wind == "none":
        return "steady wind"
    return (
        f"class {wind}"
        if not wind[0].isdigit() and wind[0] != "."
        else f"turbulence of {100 * float(wind):g} %"
    )


def verdicts(comparison: Comparison, method: str = "feed-forward") -> list[LoadVerdict]:
    """What a method does to each load; without the winds in which it was not judged."""
    found = []
    for load in LOADS:
        cuts = {}
        for wind in comparison.winds:
            one = comparison.cut(method, wind, "del", load)
            if one is not None:
                cuts[wind] = one
        effects = {
            wind: "unclear" if one.half_width is None and wind != "none" else effect(one)
            for wind, one in cuts.items()
        }
        paid, stops = False, None
        for wind, word in effects.items():
            if paid and word != "pays" and stops is None:
                stops = wind
            paid = paid or word == "pays"
        found.append(LoadVerdict(load=load, cuts=cuts, effects=effects, stops_at=stops))
    return found


def sentences(comparison: Comparison, method: str = "feed-forward") -> list[str]:
    """The verdict in plain words, one line for each load and one on pitch travel."""
    lines: list[str] = []
    for verdict in verdicts(comparison, method):
        if not verdict.cuts:
            continue
        parts = ", ".join(
            f"{_change(found)} in {wind_name(wind)}" for wind, found in verdict.cuts.items()
        )
        lines.append(f"{_WORDS[verdict.load]}: {parts}: {_ending(verdict)}")
    travel = _travel(comparison, method)
    return [*lines, travel] if travel else lines


def added(comparison: Comparison) -> list[str]:
    """What the profile adds to tuned individual pitch, in plain words, a line for each wind.

    The changes are those of ``feed-forward+ipc`` against ``ipc-bayes`` in the same seeds; both were
    tuned by the same tuner with the same number of evaluations.
    """
    lines = []
    for wind in comparison.winds:
        try:
            both, alone = (comparison.entry(m, wind) for m in ("feed-forward+ipc", "ipc-bayes"))
        except InputError:
            return []
        if both.runs and alone.runs:
            parts = (
                f"{_WORDS[load]} {_change(cut(both.runs, alone.runs, 'del', load))}"
                for load in LOADS
            )
            lines.append(f"{wind_name(wind)}: {', '.join(parts)}")
    return lines


def _change(found: Cut) -> str:
    spread = "" if found.half_width is None else f" ±{100 * found.half_width:.1f}"
    return f"{-100 * found.mean:+.1f}{spread} %"


def _ending(verdict: LoadVerdict) -> str:
    words = set(verdict.effects.values())
    if verdict.stops_at is not None:
        winds = list(verdict.effects)
        after = winds[winds.index(verdict.stops_at) :]
        again = next((wind for wind in after if verdict.effects[wind] == "pays"), None)
        return f"{_STOPS[verdict.effects[verdict.stops_at]]} by {wind_name(verdict.stops_at)}" + (
            "" if again is None else f", pays again in {wind_name(again)}"
        )
    if words == {"pays"}:
        return "pays" if len(verdict.effects) == 1 else "pays everywhere"
    if "pays" not in words:
        costs = [wind_name(wind) for wind, word in verdict.effects.items() if word == "costs"]
        return "pays nowhere" + (f", costs in {' and '.join(costs)}" if costs else "")
    first = next(wind for wind, word in verdict.effects.items() if word == "pays")
    return f"pays from {wind_name(first)} on"


def _travel(comparison: Comparison, method: str) -> str:
    """Pitch travel beside that of the collective controller."""
    parts = []
    for wind in comparison.winds:
        mine, other = comparison.entry(method, wind), comparison.entry("collective", wind)
        if mine.runs:
            degrees = [57.29577951308232 * one.mean("travel") for one in (mine, other)]
            parts.append(f"{degrees[0]:.2f} for {degrees[1]:.2f} in {wind_name(wind)}")
    return f"pitch travel a turn [deg]: {', '.join(parts)}" if parts else ""
