"""From a record (nested dict as the catalogue's JSON files hold it) to a `Turbine`.

A record keeps every airfoil once and gives each blade station two of them with a weight,

    polar = (1 - w) airfoil_i + w airfoil_j        on the union of their angles of attack,

which keeps files small.  Keys that end in ``_deg`` or ``_rpm`` are in degrees (or degrees per
second) and revolutions per minute; everything else is SI.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pitchopt.aero.blade import Blade
from pitchopt.aero.polars import Polar, blend
from pitchopt.aero.rotor import Rotor
from pitchopt.errors import InputError
from pitchopt.turbines.fields import Fields
from pitchopt.turbines.model import Turbine
from pitchopt.turbines.structure import (
    BladeSections,
    BladeStructure,
    Drivetrain,
    Hub,
    Nacelle,
    Tower,
)

__all__ = ["FORMAT", "turbine_from_record"]

FORMAT = "pitchopt-turbine-1"
_RPM = np.pi / 30.0


def turbine_from_record(data: Any, file: str) -> Turbine:
    """Turbine of a record.

    Parameters
    ----------
    data : dict
        Content of the file.
    file : str
        Its name, for messages.

    Raises
    ------
    InputError
        Naming file, dotted key, what arrived and what is allowed.
    """
    top = Fields(data, file)
    if top.text("format", "") != FORMAT:
        top.fail("format", f"got {top.text('format', '')!r}, expected {FORMAT!r}")
    try:
        return _turbine(top)
    except InputError as error:
        message = str(error)
        if message.startswith(f"{file}: "):
            raise
        raise InputError(f"{file}: {message}") from error


def _turbine(top: Fields) -> Turbine:
    geometry = top.child("rotor")
    blade, sections = _blade(top)
    rotor = Rotor(
        blade=blade,
        blades=geometry.integer("blades", at_least=1),
        hub_radius=geometry.number("hub_radius", at_least=0.0),
        tilt=float(np.deg2rad(geometry.number("tilt_deg"))),
        cone=float(np.deg2rad(geometry.number("cone_deg"))),
        overhang=geometry.number("overhang"),
        hub_height=geometry.number("hub_height", above=0.0),
    )
    use = top.child("operation")
    notes = top.optional("notes")
    low, high = use.array("pitch_range_deg", size=2)
    hub, nacelle = top.optional("hub"), top.optional("nacelle")
    train = top.optional("drivetrain")
    return Turbine(
        name=top.text("name"),
        source=top.text("source"),
        description=top.text("description", ""),
        rotor=rotor,
        rated_power=use.number("rated_power", above=0.0),
        rated_rotor_speed=use.number("rated_rotor_speed_rpm", above=0.0) * _RPM,
        min_rotor_speed=use.number("min_rotor_speed_rpm", at_least=0.0) * _RPM,
        max_rotor_speed=_scaled(use, "max_rotor_speed_rpm", _RPM),
        max_tip_speed=use.maybe_number("max_tip_speed", above=0.0),
        rated_wind_speed=use.maybe_number("rated_wind_speed", above=0.0),
        cut_in_wind_speed=use.maybe_number("cut_in_wind_speed", above=0.0),
        cut_out_wind_speed=use.maybe_number("cut_out_wind_speed", above=0.0),
        optimal_tip_speed_ratio=use.maybe_number("optimal_tip_speed_ratio", above=0.0),
        fine_pitch=_scaled(use, "fine_pitch_deg", np.pi / 180.0),
        pitch_range=(float(np.deg2rad(low)), float(np.deg2rad(high))),
        pitch_rate=float(np.deg2rad(use.number("pitch_rate_deg", at_least=0.0))),
        torque_rate=use.maybe_number("torque_rate", above=0.0),
        alpha_limits=(
            _scaled(use, "alpha_min_deg", np.pi / 180.0),
            _scaled(use, "alpha_max_deg", np.pi / 180.0),
        ),
        air_density=use.number("air_density", above=0.0) if use.has("air_density") else 1.225,
        iec_class=use.text("iec_class") if use.has("iec_class") else None,
        tower=_tower(top.child("tower")),
        sections=sections,
        blade_structure=_structure(top.optional("blade_structure")),
        hub=None
        if hub is None
        else Hub(
            mass=hub.number("mass", at_least=0.0), inertia=hub.number("inertia", at_least=0.0)
        ),
        nacelle=None if nacelle is None else _nacelle(nacelle),
        drivetrain=Drivetrain() if train is None else _drivetrain(train),
        notes={} if notes is None else {str(key): notes.text(key) for key in notes.data},
    )


def _scaled(fields: Fields, key: str, factor: float) -> float | None:
    value = fields.maybe_number(key)
    return None if value is None else value * factor


def _polars(top: Fields) -> list[Polar]:
    polars = []
    for airfoil in top.children("airfoils"):
        alpha = airfoil.array("alpha_deg", increasing=True, at_least=-180.0, at_most=180.0)
        if alpha.size < 2:
            airfoil.fail("alpha_deg", "got 1 value, expected at least 2")
        polars.append(
            Polar(
                name=airfoil.text("name"),
                alpha=np.deg2rad(alpha),
                cl=airfoil.array("cl", size=alpha.size),
                cd=airfoil.array("cd", size=alpha.size),
                cm=airfoil.maybe_array("cm", size=alpha.size),
            )
        )
    return polars


def _blade(top: Fields) -> tuple[Blade, BladeSections | None]:
    polars = _polars(top)
    shape = top.child("blade")
    if shape.has("design_wind_speed"):
        return _formula_blade(shape, polars), None
    span = shape.array("span", at_least=0.0, increasing=True)
    stations = shape.value("polars")
    if not isinstance(stations, list) or len(stations) != span.size:
        shape.fail("polars", f"expected {span.size} entries [first, second, weight]")
    used = []
    for i, station in enumerate(stations):
        match station:
            case [int(a), int(b), int() | float() as w] if (
                0 <= a < len(polars) and 0 <= b < len(polars) and 0.0 <= w <= 1.0
            ):
                used.append(blend(polars[a], polars[b], float(w)))
            case _:
                shape.fail(
                    f"polars[{i}]",
                    f"expected [first, second, weight] with airfoils 0 to {len(polars) - 1} "
                    "and a weight from 0 to 1",
                )
    blade = Blade(
        span=span,
        chord=shape.array("chord", size=span.size, above=0.0),
        twist=np.deg2rad(shape.array("twist_deg", size=span.size)),
        prebend=shape.maybe_array("prebend", size=span.size),
        sweep=shape.maybe_array("sweep", size=span.size),
        polars=tuple(used),
    )
    sections = None
    if shape.has("relative_thickness"):
        sections = BladeSections(
            span=span,
            relative_thickness=shape.array("relative_thickness", size=span.size, above=0.0),
            pitch_axis=shape.maybe_array("pitch_axis", size=span.size),
        )
    return blade, sections


def _formula_blade(shape: Fields, polars: list[Polar]) -> Blade:
    """Blade of constant chord whose twist follows the inflow angle of a design point."""
    count = shape.integer("elements", at_least=1)
    root, tip = shape.number("root_radius", at_least=0.0), shape.number("tip_radius", above=0.0)
    if tip <= root:
        shape.fail("tip_radius", f"got {tip:g}, expected more than root_radius = {root:g}")
    if len(polars) != 1:
        raise InputError(f"{shape.file}: airfoils: got {len(polars)} airfoils, expected 1")
    speed = shape.number("design_wind_speed", above=0.0)
    omega = shape.number("design_rotor_speed", above=0.0)
    span = (np.arange(count, dtype=np.float64) + 0.5) * ((tip - root) / count)
    twist = np.arctan(speed / (omega * (root + span))) - float(np.arctan(speed / (omega * tip)))
    return Blade(
        span=span,
        chord=np.full(count, shape.number("chord", above=0.0)),
        twist=twist,
        polars=(polars[0],) * count,
        quadrature="elements",
    )


def _structure(part: Fields | None) -> BladeStructure | None:
    if part is None:
        return None
    span = part.array("span", at_least=0.0, increasing=True)
    return BladeStructure(
        span=span,
        mass_per_length=part.array("mass_per_length", size=span.size, above=0.0),
        flap_stiffness=part.array("flap_stiffness", size=span.size, above=0.0),
        edge_stiffness=part.array("edge_stiffness", size=span.size, above=0.0),
        structural_twist=np.deg2rad(part.array("structural_twist_deg", size=span.size)),
        coupling_stiffness=part.maybe_array("coupling_stiffness", size=span.size),
        torsion_stiffness=part.maybe_array("torsion_stiffness", size=span.size),
        mass_centre_x=part.maybe_array("mass_centre_x", size=span.size),
        mass_centre_y=part.maybe_array("mass_centre_y", size=span.size),
        damping_ratio=part.maybe_number("damping_ratio", at_least=0.0, at_most=1.0),
    )


def _tower(part: Fields) -> Tower:
    height = part.array("height", increasing=True)
    return Tower(
        height=height,
        diameter=part.array("diameter", size=height.size, above=0.0),
        thickness=part.maybe_array("thickness", size=height.size),
        density=part.maybe_number("density", above=0.0),
        youngs_modulus=part.maybe_number("youngs_modulus", above=0.0),
        poisson_ratio=part.maybe_number("poisson_ratio"),
        outfitting_factor=part.number("outfitting_factor", above=0.0)
        if part.has("outfitting_factor")
        else 1.0,
        mass_per_length=part.maybe_array("mass_per_length", size=height.size),
        bending_stiffness=part.maybe_array("bending_stiffness", size=height.size),
        drag_coefficient=part.maybe_array("drag_coefficient", size=height.size),
        damping_ratio=part.maybe_number("damping_ratio", at_least=0.0, at_most=1.0),
    )


def _nacelle(part: Fields) -> Nacelle:
    return Nacelle(
        mass=part.number("mass", at_least=0.0),
        yaw_inertia=part.maybe_number("yaw_inertia", at_least=0.0),
        centre=part.maybe_array("centre", size=3),
        yaw_bearing_mass=part.maybe_number("yaw_bearing_mass", at_least=0.0) or 0.0,
    )


def _drivetrain(part: Fields) -> Drivetrain:
    return Drivetrain(
        gear_ratio=part.number("gear_ratio", above=0.0),
        efficiency=part.maybe_number("efficiency", above=0.0, at_most=1.0),
        generator_inertia=part.maybe_number("generator_inertia", at_least=0.0),
        torsion_stiffness=part.maybe_number("torsion_stiffness", at_least=0.0),
        torsion_damping=part.maybe_number("torsion_damping", at_least=0.0),
    )
