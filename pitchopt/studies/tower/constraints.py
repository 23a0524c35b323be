"""Constraints on a tower design by group, as values g <= 0 and as rows linear in logarithms.

Every g is relative to its limit: value / limit - 1 where the limit is an upper one, 1 - value /
limit where it is a lower one; so fatigue is damage - 1 and frequency 1 - f (1 - delta) / f_1P.
Beside it stands the row

    c(x) = ln(value / limit)  or  ln(limit / value),      x = (ln d, ln t),

of the same sign, which is linear, nearly so or convex in x, and the slope dg/dc, so that a
multiplier of c divided by it is one of g.  Where several rows speak of the same thing (a station
at a node, two walls at a node, an element's two ends, two planes of bending) the group's value is
the largest and its multiplier the sum.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray
from pitchopt.errors import InputError
from pitchopt.studies.tower.design import Joints, TowerDesign, station_joints
from pitchopt.studies.tower.fatigue_loads import FatigueLoads
from pitchopt.studies.tower.frequencies import Frequencies, natural_frequencies
from pitchopt.studies.tower.limits import TowerLimits

__all__ = [
    "Rows",
    "TowerConstraints",
    "constraint_rows",
    "fatigue_curvature",
    "geometry_rows",
    "tower_constraints",
]

_STEP = 0.01  # of a logarithm, for second derivatives of damage


@dataclass(frozen=True, kw_only=True, eq=False)
class TowerConstraints:
    """A number for each constraint: its value g [-], or its multiplier.

    Attributes
    ----------
    fatigue : ndarray (S,)
        Stations, base first.
    frequency : ndarray (2,)
        First and second mode; empty for a soft-soft tower.
    largest_diameter : ndarray (E + 1,)
        Nodes.
    top_diameter : ndarray (1,)
    widening, taper : ndarray (E,)
        Elements, which may not widen upwards, nor narrow too fast.
    wall_step : ndarray (E - 1,)
        Inner nodes.
    slenderness, least_wall, largest_wall : ndarray (E,)
    """

    fatigue: FloatArray
    frequency: FloatArray
    largest_diameter: FloatArray
    top_diameter: FloatArray
    widening: FloatArray
    taper: FloatArray
    wall_step: FloatArray
    slenderness: FloatArray
    least_wall: FloatArray
    largest_wall: FloatArray

    def __post_init__(self) -> None:
        for name, values in self.items():
            array = np.array(values, dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def items(self) -> Iterator[tuple[str, FloatArray]]:
        """Names and arrays."""
        for field in dataclasses.fields(self):
            yield field.name, getattr(self, field.name)

    def scaled(self, factor: float) -> TowerConstraints:
        """All numbers times a factor."""
        return TowerConstraints(**{name: factor * values for name, values in self.items()})

    @property
    def largest(self) -> tuple[str, int, float]:
        """Group, place and value of the largest number."""
        parts = [(n, int(np.argmax(v)), float(v.max())) for n, v in self.items() if v.size]
        return max(parts, key=lambda part: part[2])


_GROUPS = tuple(field.name for field in dataclasses.fields(TowerConstraints))


@dataclass(frozen=True, eq=False)
class Rows:
    """Constraints of a design, (R,) rows.

    Attributes
    ----------
    log : ndarray (R,)
        c [-].
    jacobian : ndarray (R, 2 E + 1)
        Of c by the logarithms of diameters and thicknesses.
    value, rate : ndarray (R,)
        g and dg/dc [-].
    group, place : int array (R,)
        Field of `TowerConstraints` and place in it.
    implied : bool array (R,)
        Whether other rows imply this one, which then has no multiplier of its own: limits at an
        element's upper end, as towers do not widen upwards.
    sizes : tuple of int
        Of the groups.
    """

    log: FloatArray
    jacobian: FloatArray
    value: FloatArray
    rate: FloatArray
    group: NDArray[np.intp]
    place: NDArray[np.intp]
    implied: NDArray[np.bool_]
    sizes: tuple[int, ...]

    @property
    def names(self) -> list[str]:
        """Group and place of the rows."""
        return [f"{_GROUPS[g]}[{p}]" for g, p in zip(self.group, self.place, strict=True)]

    def of(self, name: str) -> NDArray[np.intp]:
        """Rows of a group."""
        return np.flatnonzero(self.group == _GROUPS.index(name))

    def gather(self, numbers: FloatArray, *, add: bool) -> TowerConstraints:
        """Rows' numbers by group: their sum, or the largest."""
        parts = {}
        for k, name in enumerate(_GROUPS):
            mine = self.group == k
            out = np.full(self.sizes[k], 0.0 if add else -np.inf)
            (np.add if add else np.maximum).at(out, self.place[mine], numbers[mine])
            parts[name] = out
        return TowerConstraints(**parts)


class _Builder:
    """Collects rows."""

    def __init__(self, elements: int, stations: int, limits: TowerLimits) -> None:
        self.elements = elements
        sizes = {
            "fatigue": stations,
            "frequency": 0 if limits.frequency_margin is None else 2,
            "largest_diameter": elements + 1,
            "top_diameter": 1,
            "wall_step": elements - 1,
        }
        self.sizes = tuple(sizes.get(name, elements) for name in _GROUPS)
        self.parts: list[tuple[NDArray[Any], ...]] = []

    def add(
        self,
        name: str,
        place: NDArray[np.intp],
        log: FloatArray,
        *,
        diameter: list[tuple[NDArray[np.intp], FloatArray]] | None = None,
        thickness: list[tuple[NDArray[np.intp], FloatArray]] | None = None,
        jacobian: FloatArray | None = None,
        upper: bool = True,
        value: FloatArray | None = None,
        rate: FloatArray | None = None,
        implied: NDArray[np.bool_] | None = None,
    ) -> None:
        """Rows of a group: c, and its slopes as (column, slope) or as a matrix."""
        if jacobian is None:
            jacobian = np.zeros((log.size, 2 * self.elements + 1))
            rows = np.arange(log.size)
            for first, entries in ((0, diameter), (self.elements + 1, thickness)):
                for column, slope in entries or []:
                    jacobian[rows, first + column] += slope
        if value is None or rate is None:
            value = np.expm1(log) if upper else -np.expm1(-log)
            rate = np.exp(log) if upper else np.exp(-log)
        group = np.full(log.size, _GROUPS.index(name))
        if implied is None:
            implied = np.zeros(log.size, dtype=np.bool_)
        self.parts.append((log, jacobian, value, rate, group, place, implied))

    def rows(self) -> Rows:
        names = ("log", "jacobian", "value", "rate", "group", "place", "implied")
        columns: dict[str, Any] = {
            name: np.concatenate(column)
            for name, column in zip(names, zip(*self.parts, strict=True), strict=True)
        }
        return Rows(**columns, sizes=self.sizes)


def constraint_rows(
    design: TowerDesign,
    loads: FatigueLoads,
    limits: TowerLimits,
    frequencies: Frequencies | None = None,
) -> Rows:
    """All constraints of a design with slopes; frequencies are computed where not given."""
    build = _Builder(design.elements, loads.stations, limits)
    _fatigue(build, design, loads, limits)
    least = limits.least_frequency(design.reference)
    if least is not None:
        found = natural_frequencies(design) if frequencies is None else frequencies
        slopes = np.concatenate([found.by_diameter, found.by_thickness], axis=2)
        build.add(
            "frequency",
            np.tile(np.arange(2), 2),
            np.log(least / found.value).ravel(),
            jacobian=-slopes.reshape(4, -1),
            upper=False,
        )
    _geometry(build, design, limits)
    return build.rows()


def geometry_rows(design: TowerDesign, limits: TowerLimits) -> Rows:
    """Constraints that know neither loads nor frequencies."""
    build = _Builder(design.elements, 0, limits)
    _geometry(build, design, limits)
    return build.rows()


def _fatigue(
    build: _Builder, design: TowerDesign, loads: FatigueLoads, limits: TowerLimits
) -> None:
    if loads.stations < 2:
        raise InputError(f"loads: got {loads.stations} station, expected at least base and top")
    joints = station_joints(loads.stations, design.elements)
    middle, wall = design.joint_sections(joints)
    damage = loads.damage(joints, middle, wall)
    tiny = np.finfo(np.float64).tiny
    relative = np.maximum(damage.value, tiny) / limits.largest_damage
    below = (1.0 - joints.share) * design.diameter[joints.element] / middle
    build.add(
        "fatigue",
        joints.station,
        np.log(relative),
        diameter=[
            (joints.element, below * damage.by_diameter),
            (joints.element + 1, (1.0 - below) * damage.by_diameter),
        ],
        thickness=[(joints.element, damage.by_thickness)],
    )


def fatigue_curvature(
    design: TowerDesign, loads: FatigueLoads, multipliers: FloatArray
) -> FloatArray:
    """Second derivatives of the fatigue rows times their multipliers, by (ln d, ln t).

    Differences over 1 % of the damage's slopes, which is the width of the loads' bins, and the
    exact second derivative of a diameter between two nodes.

    Parameters
    ----------
    design : TowerDesign
    loads : FatigueLoads
    multipliers : ndarray (P,)
        Of the rows of fatigue in their order.

    Returns
    -------
    ndarray (2 E + 1, 2 E + 1)
    """
    size, count = 2 * design.elements + 1, design.elements
    every = station_joints(loads.stations, count)
    some = np.flatnonzero(multipliers)
    joints = Joints(every.station[some], every.element[some], every.share[some])
    z = multipliers[some]
    middle, wall = design.joint_sections(joints)
    second = np.empty((some.size, 2, 2))
    for k in range(2):
        low, high = (
            loads.damage(
                joints, middle * (factor if k == 0 else 1.0), wall * (factor if k else 1.0)
            )
            for factor in (1.0 - 0.5 * _STEP, 1.0 + 0.5 * _STEP)
        )
        second[:, 0, k] = (high.by_diameter - low.by_diameter) / _STEP
        second[:, 1, k] = (high.by_thickness - low.by_thickness) / _STEP
    second = 0.5 * (second + np.swapaxes(second, 1, 2)) * z[:, None, None]
    slope = z * loads.damage(joints, middle, wall).by_diameter
    by = np.zeros((2, some.size, size))
    rows = np.arange(some.size)
    below = (1.0 - joints.share) * design.diameter[joints.element] / middle
    by[0, rows, joints.element] = below
    by[0, rows, joints.element + 1] = 1.0 - below
    by[1, rows, count + 1 + joints.element] = 1.0
    out = np.einsum("jkl,kja,ljb->ab", second, by, by)
    return np.asarray(out + np.diag(slope @ by[0]) - (by[0] * slope[:, None]).T @ by[0])


def _geometry(build: _Builder, design: TowerDesign, limits: TowerLimits) -> None:
    d, t = design.diameter, design.thickness
    count = design.elements
    e = np.arange(count)
    one = np.ones(count)
    ends = np.concatenate([e, e + 1])  # nodes at the elements' lower and upper ends
    own = np.concatenate([e, e])
    upper_end = np.repeat([False, True], count)
    outer = d[ends] + t[own]
    part = d[ends] / outer
    build.add(
        "largest_diameter",
        ends,
        np.log(outer / limits.largest_diameter),
        diameter=[(ends, part)],
        thickness=[(own, 1.0 - part)],
        implied=upper_end,
    )
    build.add(
        "top_diameter",
        np.zeros(1, dtype=np.intp),
        np.log(limits.top_diameter / outer[-1:]),
        diameter=[(e[-1:] + 1, -part[-1:])],
        thickness=[(e[-1:], part[-1:] - 1.0)],
        upper=False,
    )
    ratio = d[1:] / d[:-1]
    build.add("widening", e, np.log(ratio), diameter=[(e + 1, one), (e, -one)])
    build.add(
        "taper", e, np.log(limits.taper / ratio), diameter=[(e, one), (e + 1, -one)], upper=False
    )
    n = e[:-1]
    for sign in (1.0, -1.0):
        step = sign * np.log(t[1:] / t[:-1])
        build.add(
            "wall_step",
            n,
            step - np.log(limits.wall_step),
            thickness=[(n + 1, sign * one[:-1]), (n, -sign * one[:-1])],
        )
    slender = d[ends] / t[own]
    build.add(
        "slenderness",
        own,
        np.log(slender / (limits.slenderness - 1.0)),
        diameter=[(ends, np.ones(2 * count))],
        thickness=[(own, -np.ones(2 * count))],
        value=(slender + 1.0) / limits.slenderness - 1.0,
        rate=slender / limits.slenderness,
        implied=upper_end,
    )
    build.add("least_wall", e, np.log(limits.least_wall / t), thickness=[(e, -one)], upper=False)
    build.add("largest_wall", e, np.log(t / limits.largest_wall), thickness=[(e, one)])


def tower_constraints(
    design: TowerDesign, loads: FatigueLoads, limits: TowerLimits
) -> TowerConstraints:
    """Values g of a design's constraints by group, at most zero where they are kept.

    Parameters
    ----------
    design : TowerDesign
    loads : FatigueLoads
    limits : TowerLimits

    Raises
    ------
    InputError
        If the turbine's data do not suffice or the tower buckles under its weights.
    """
    rows = constraint_rows(design, loads, limits)
    return rows.gather(rows.value, add=False)
