"""A tubular steel tower of conical elements, and the turbine that stands on it.

Element e between the nodes e and e + 1 has the wall thickness t_e and, linear between its nodes,
the diameter d of the wall's middle, so that the outer diameter is d + t.  Per cross-section

    A = pi d t,      I = pi/8 d t (d^2 + t^2),      W = 2 I / (d + t),

exactly, and the mass of element e with the length l is  rho pi l t_e (d_e + d_{e+1}) / 2.

The height of a design is that of the hub; the tower ends below it by the reference turbine's own
distance.  Nodes are evenly spaced.  Fatigue is judged at evenly spaced stations from base to top.
A joint is a pair of a station and an element that it lies in; a station at a node has two.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import InputError
from pitchopt.turbines import Tower, Turbine

__all__ = ["INSIDE", "Joints", "TowerDesign", "station_joints"]

_TRANSITION = 0.05  # length over which the wall of one element becomes that of the next [m]
INSIDE = 4  # parts of an element between which mass and stiffness are linear


@dataclass(frozen=True)
class Joints:
    """Pairs of a station and an element it lies in, (P,) each.

    Attributes
    ----------
    station, element : int array (P,)
    share : ndarray (P,)
        Place within the element, 0 at its lower and 1 at its upper node.
    """

    station: NDArray[np.intp]
    element: NDArray[np.intp]
    share: FloatArray


def station_joints(stations: int, elements: int) -> Joints:
    """Joints of evenly spaced stations, base and top included."""
    rows: list[tuple[int, int, float]] = []
    for s in range(stations):
        whole, rest = divmod(s * elements, stations - 1)
        if rest:
            rows.append((s, whole, rest / (stations - 1)))
            continue
        rows += [(s, whole - 1, 1.0)] if whole else []
        rows += [(s, whole, 0.0)] if whole < elements else []
    table = np.array(rows)
    return Joints(table[:, 0].astype(np.intp), table[:, 1].astype(np.intp), table[:, 2])


@dataclass(frozen=True, kw_only=True, eq=False)
class TowerDesign:
    """Diameters and wall thicknesses at a hub height.

    Parameters
    ----------
    hub_height : float
        [m].
    diameter : array_like (E + 1,)
        Of the wall's middle at the nodes, base first [m].
    thickness : array_like (E,)
        Of the elements' walls [m].
    reference : Turbine
        What stands on the tower, and the tower's material.

    Raises
    ------
    InputError
        If lengths disagree, a number is not positive, the wall is thicker than half the diameter,
        or the reference's tower has no material.
    """

    hub_height: float
    diameter: FloatArray
    thickness: FloatArray
    reference: Turbine

    def __post_init__(self) -> None:
        wall = finite_array("thickness", self.thickness)
        middle = finite_array("diameter", self.diameter, shape=(wall.size + 1,))
        if wall.min() <= 0.0 or middle.min() <= 0.0:
            raise InputError(
                f"thickness, diameter: got {wall.min():g} and {middle.min():g} m, expected "
                "positive numbers"
            )
        if np.any(wall > np.minimum(middle[1:], middle[:-1]) / 2.0):
            raise InputError("thickness: got more than half the diameter")
        object.__setattr__(self, "thickness", wall)
        object.__setattr__(self, "diameter", middle)
        finite_number("hub_height", self.hub_height, above=self.head_distance)
        tower = self.reference.tower
        if tower.density is None or tower.youngs_modulus is None:
            raise InputError(
                f"turbine {self.reference.name!r}: density or Young's modulus of its tower is not "
                "known"
            )

    @property
    def elements(self) -> int:
        """Number of elements E."""
        return self.thickness.size

    @property
    def head_distance(self) -> float:
        """Hub above the tower's top [m]."""
        return self.reference.rotor.hub_height - self.reference.tower.top

    @property
    def length(self) -> float:
        """Of the tower [m]."""
        return self.hub_height - self.head_distance - self.reference.tower.base

    @property
    def density(self) -> float:
        """Of the wall, outfitting included [kg/m^3]."""
        tower = self.reference.tower
        assert tower.density is not None  # checked
        return tower.density * tower.outfitting_factor

    @property
    def youngs_modulus(self) -> float:
        """[Pa]."""
        modulus = self.reference.tower.youngs_modulus
        assert modulus is not None  # checked
        return modulus

    @cached_property
    def element_masses(self) -> FloatArray:
        """(E,) [kg]."""
        middle = 0.5 * (self.diameter[1:] + self.diameter[:-1])
        part = self.length / self.elements
        return np.asarray(self.density * np.pi * part * self.thickness * middle)

    @property
    def mass(self) -> float:
        """[kg]."""
        return float(self.element_masses.sum())

    def joint_sections(self, joints: Joints) -> tuple[FloatArray, FloatArray]:
        """Diameter of the wall's middle and thickness at joints, (P,) each [m]."""
        below, above = self.diameter[joints.element], self.diameter[joints.element + 1]
        return below + joints.share * (above - below), self.thickness[joints.element]

    @cached_property
    def tower(self) -> Tower:
        """Tower for the dynamic turbine; walls change over a few centimetres at the nodes."""
        part = self.length / self.elements
        reach = 0.5 * _TRANSITION / part
        height, middle, wall = [], [], []
        for e in range(self.elements):
            low = reach if e else 0.0
            high = 1.0 - reach if e < self.elements - 1 else 1.0
            share = np.concatenate([[low], np.linspace(0.0, 1.0, INSIDE + 1)[1:-1], [high]])
            height.append((e + share) * part)
            middle.append(self.diameter[e] + share * (self.diameter[e + 1] - self.diameter[e]))
            wall.append(np.full(share.size, self.thickness[e]))
        base = self.reference.tower
        z, d, t = (np.concatenate(parts) for parts in (height, middle, wall))
        return Tower(
            height=z + base.base,
            diameter=d + t,
            thickness=t,
            density=base.density,
            youngs_modulus=base.youngs_modulus,
            poisson_ratio=base.poisson_ratio,
            outfitting_factor=base.outfitting_factor,
            damping_ratio=base.damping_ratio,
            drag_coefficient=(
                None
                if base.drag_coefficient is None
                else np.interp(
                    z / self.length * (base.top - base.base) + base.base,
                    base.height,
                    base.drag_coefficient,
                )
            ),
        )

    @cached_property
    def turbine(self) -> Turbine:
        """The reference turbine on this tower."""
        rotor = dataclasses.replace(self.reference.rotor, hub_height=self.hub_height)
        return dataclasses.replace(self.reference, rotor=rotor, tower=self.tower)

    def change_from(self, other: TowerDesign) -> float:
        """Largest relative change of a diameter or thickness from another design [-]."""
        return float(
            max(
                np.max(np.abs(self.diameter / other.diameter - 1.0)),
                np.max(np.abs(self.thickness / other.thickness - 1.0)),
            )
        )
