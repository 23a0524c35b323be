"""The dynamic turbine: what it is made of, and its tables for the time loop."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.aero.flow import loss_constants
from pitchopt.aero.rotor import hub_axes
from pitchopt.checks import FloatArray, finite_number, whole_number
from pitchopt.control.actuator import GeneratorLag, PitchActuator
from pitchopt.errors import InputError
from pitchopt.sim.channels import Channel, channel_list
from pitchopt.sim.structure import GRAVITY, BladeModel, TowerModel, blade_model, tower_model
from pitchopt.sim.wind import Reach
from pitchopt.turbines import Turbine

__all__ = ["FREEDOMS", "DynamicTurbine"]

FREEDOMS = (
    "rotor-speed",
    "tower-fore-aft",
    "tower-side-side",
    "blade-flap",
    "blade-edge",
    "shaft-torsion",
)
_DEFAULT = FREEDOMS[:-1]


@dataclass(frozen=True, kw_only=True, eq=False)
class DynamicTurbine:
    """A turbine that moves.

    Parameters
    ----------
    turbine : Turbine
        With blade structure, tower, hub and nacelle.
    freedoms : iterable of str
        Which degrees of freedom move, of `FREEDOMS`; all but the shaft's torsion by default.
        Without ``rotor-speed`` the rotor turns at its initial speed.
    inflow : {"dynamic", "quasi-steady"}
        Two-stage filter on the induced velocity, or momentum balance at every instant.
    skew : bool
        Redistribution of the induction in a skewed wake.
    actuator : PitchActuator, optional
        The turbine's range and rate without dynamics if absent.
    generator_lag : GeneratorLag, optional
    generator_inertia : float, optional
        About the high-speed shaft [kg m^2], in place of the turbine's own; windIO files hold none.
    yaw : float
        Nacelle yaw [rad], constant.
    step : float
        Of the time loop [s].
    blade_damping, tower_damping : float, optional
        Fractions of critical; see `pitchopt.sim.structure`.
    mode_speed : float, optional
        Rotor speed at which the blade's mode shapes are taken [rad/s], rated if absent.
    tower_sections : int
        Equal parts of the tower at whose ends section loads are given.
    tower_polynomials : array_like (2, 5), optional
        Mode shapes of the tower in place of its eigenmodes, see `tower_model`.
    gravity : bool

    Raises
    ------
    InputError
        If the turbine has not three blades or lacks structural data, a name is unknown or a
        number out of range.
    """

    turbine: Turbine
    freedoms: Iterable[str] = _DEFAULT
    inflow: Literal["dynamic", "quasi-steady"] = "dynamic"
    skew: bool = True
    actuator: PitchActuator | None = None
    generator_lag: GeneratorLag | None = None
    generator_inertia: float | None = None
    yaw: float = 0.0
    step: float = 0.025
    blade_damping: float | None = None
    tower_damping: float | None = None
    mode_speed: float | None = None
    tower_sections: int = 10
    tower_polynomials: ArrayLike | None = None
    gravity: bool = True

    def __post_init__(self) -> None:
        if not isinstance(self.turbine, Turbine):
            raise InputError(f"turbine: got {type(self.turbine).__name__}, expected a Turbine")
        if isinstance(self.freedoms, str):
            raise InputError(f"freedoms: got {self.freedoms!r}, expected several names")
        freedoms = tuple(self.freedoms)
        for name in freedoms:
            if name not in FREEDOMS:
                raise InputError(
                    f"freedoms: got {name!r}, expected names out of {', '.join(FREEDOMS)}"
                )
        object.__setattr__(self, "freedoms", tuple(f for f in FREEDOMS if f in freedoms))
        if self.inflow not in ("dynamic", "quasi-steady"):
            raise InputError(f"inflow: got {self.inflow!r}, expected 'dynamic' or 'quasi-steady'")
        finite_number("yaw", self.yaw, at_least=-math.pi / 3, at_most=math.pi / 3)
        finite_number("step", self.step, above=0.0, at_most=0.2)
        whole_number("tower_sections", self.tower_sections, at_least=1)
        if self.actuator is None:
            low, high = self.turbine.pitch_range
            if self.turbine.pitch_rate <= 0.0:
                raise InputError(
                    f"turbine {self.turbine.name!r}: its pitch rate is zero; give an actuator"
                )
            object.__setattr__(
                self,
                "actuator",
                PitchActuator(lowest=low, highest=high, rate=self.turbine.pitch_rate),
            )
        if self.generator_lag is None:
            object.__setattr__(self, "generator_lag", GeneratorLag())
        if self.blades != 3:
            raise InputError(
                f"turbine {self.turbine.name!r}: got {self.blades} blades, expected 3, as the "
                "signals of the controllers have"
            )
        drivetrain = self.turbine.drivetrain
        if "shaft-torsion" in freedoms and not drivetrain.torsion_stiffness:
            raise InputError(
                f"freedoms: turbine {self.turbine.name!r} has no torsional stiffness of its "
                "shaft, leave 'shaft-torsion' out"
            )
        inertia = drivetrain.generator_inertia
        if self.generator_inertia is not None:
            inertia = finite_number("generator_inertia", self.generator_inertia, at_least=0.0)
        if inertia is None:
            raise InputError(
                f"turbine {self.turbine.name!r}: generator inertia is not known (windIO files do "
                "not hold it); give generator_inertia in kg m^2 about the high-speed shaft"
            )
        object.__setattr__(self, "generator_inertia", inertia)
        self.tower  # noqa: B018  (raises what is missing)

    @cached_property
    def blade(self) -> BladeModel:
        """Blade reduced to its modes."""
        return blade_model(
            self.turbine, rotor_speed=self.mode_speed, damping_ratio=self.blade_damping
        )

    @cached_property
    def tower(self) -> TowerModel:
        """Tower reduced to its modes."""
        return tower_model(
            self.turbine,
            self.blade,
            damping_ratio=self.tower_damping,
            sections=self.tower_sections,
            polynomials=self.tower_polynomials,
        )

    @property
    def blades(self) -> int:
        """Number of blades."""
        return self.turbine.rotor.blades

    @property
    def efficiency(self) -> float:
        """Electrical over mechanical power; 1 where it is not known."""
        known = self.turbine.drivetrain.efficiency
        return 1.0 if known is None else known

    @property
    def rotor_inertia(self) -> float:
        """Rotor and generator about the shaft [kg m^2]."""
        rotor, drivetrain = self.turbine.rotor_inertia, self.turbine.drivetrain
        assert rotor is not None and self.generator_inertia is not None  # checked
        return rotor + self.generator_inertia * drivetrain.gear_ratio**2

    @cached_property
    def channels(self) -> tuple[Channel, ...]:
        """Output channels in the order of the record."""
        return channel_list(self.blades, self.tower_sections - 1)

    @property
    def reach(self) -> Reach:
        """Where blades go in wind along x, deflected by up to a tenth of the radius."""
        return self.reach_in(0.0)

    def reach_in(self, direction: float) -> Reach:
        """As `reach`, in wind of another mean direction [rad]."""
        rotor = self.turbine.rotor
        radius = rotor.radius
        lean = math.sin(abs(rotor.tilt)) + abs(math.sin(self.yaw - direction)) + 0.1
        return Reach(
            low=rotor.hub_height - 1.02 * radius,
            high=rotor.hub_height + 1.02 * radius,
            half_width=1.02 * radius,
            upwind=rotor.overhang + radius * (lean + math.sin(abs(rotor.cone))),
            downwind=max(radius * lean - rotor.overhang * math.cos(self.yaw - direction), 0.0),
        )

    @cached_property
    def rotor_tables(self) -> Any:
        """`RotorTables` of the time loop."""
        from pitchopt.sim.kernels_planes import RotorTables, element_planes, polar_rows

        rotor, model = self.turbine.rotor, self.blade
        blade = rotor.blade
        prebend, sweep = blade.offsets
        width, _, _, lever = blade.integration(np.array(prebend), np.array(sweep))
        outer, inner = loss_constants(rotor)
        first = np.empty(blade.span.size, dtype=np.int64)
        last = np.empty(blade.span.size, dtype=np.int64)
        rows: list[FloatArray] = []
        seen: dict[int, tuple[int, int]] = {}
        total = 0
        for e, polar in enumerate(blade.polars):
            if id(polar) not in seen:
                rows.append(polar_rows(polar.alpha, polar.cl, polar.cd, polar.moment))
                seen[id(polar)] = (total, total + rows[-1].shape[0] - 1)
                total += rows[-1].shape[0]
            first[e], last[e] = seen[id(polar)]
        return RotorTables(
            blades=rotor.blades,
            stations=blade.span.size,
            planes=element_planes(
                blades=rotor.blades,
                hub_radius=rotor.hub_radius,
                span=blade.span,
                chord=blade.chord,
                twist=blade.twist,
                prebend=prebend,
                sweep=sweep,
                width=width,
                lever=lever + rotor.hub_radius * width,
                outer=outer,
                inner=inner,
                shape=model.node_shape,
                slope=model.node_slope,
                shortening=model.node_shortening,
                weight=model.node_weight,
            ),
            radius=rotor.radius,
            cone_cosine=math.cos(rotor.cone),
            cone_sine=math.sin(rotor.cone),
            density=self.turbine.air_density,
            polar=np.concatenate(rows),
            first=first,
            last=last,
            skew=self.skew,
            dynamic=self.inflow == "dynamic",
        )

    @cached_property
    def body_tables(self) -> Any:
        """`BodyTables` of the time loop."""
        from pitchopt.sim.kernels_body import BLADES, BodyTables

        turbine, rotor = self.turbine, self.turbine.rotor
        blade, tower = self.blade, self.tower
        hub, nacelle, drivetrain = turbine.hub, turbine.nacelle, turbine.drivetrain
        assert hub is not None and nacelle is not None  # checked by tower_model
        assert self.generator_inertia is not None
        active = np.zeros(BLADES + 2 * rotor.blades, dtype=np.int64)
        on = set(self.freedoms)
        active[0] = "tower-fore-aft" in on
        active[1] = "tower-side-side" in on
        active[2] = "rotor-speed" in on
        active[3] = "shaft-torsion" in on
        active[BLADES::2] = "blade-flap" in on
        active[BLADES + 1 :: 2] = "blade-edge" in on
        gravity = GRAVITY if self.gravity else 0.0
        head = rotor.blades * blade.mass + hub.mass + nacelle.mass + nacelle.yaw_bearing_mass
        centre = np.zeros(3) if nacelle.centre is None else np.array(nacelle.centre)
        return BodyTables(
            blades=rotor.blades,
            gravity=gravity,
            mass=blade.mass,
            first=blade.first,
            second=blade.second,
            force=blade.force,
            lever=blade.lever,
            coupling=blade.coupling,
            stiffness=blade.stiffness,
            damping=blade.damping,
            tension_gravity=blade.tension_gravity,
            tension_rotation=blade.tension_rotation,
            hub_radius=rotor.hub_radius,
            cone_cosine=math.cos(rotor.cone),
            cone_sine=math.sin(rotor.cone),
            hub_mass=hub.mass,
            hub_inertia=hub.inertia,
            apex=rotor.apex(self.yaw) - np.array([0.0, 0.0, turbine.tower.top]),
            top=turbine.tower.top,
            axes=np.ascontiguousarray(hub_axes(rotor.tilt, self.yaw).T),
            nacelle_mass=nacelle.mass,
            bearing_mass=nacelle.yaw_bearing_mass,
            nacelle=_turned(centre, self.yaw),
            generator_inertia=self.generator_inertia * drivetrain.gear_ratio**2,
            shaft_stiffness=drivetrain.torsion_stiffness or 0.0,
            shaft_damping=drivetrain.torsion_damping or 0.0,
            tower_mass=tower.mass,
            tower_stiffness=tower.stiffness,
            tower_damping=tower.damping,
            tower_slope=tower.slope,
            tower_weight=gravity * (head * tower.weight_top + tower.weight_own),
            active=active,
        )


def _turned(vector: FloatArray, yaw: float) -> FloatArray:
    c, s = math.cos(yaw), math.sin(yaw)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2]])
