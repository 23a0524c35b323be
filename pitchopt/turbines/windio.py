"""Reader of windIO v2 turbine files (https://github.com/IEAWindSystems/windIO).

What is taken and how it maps to ours:

- blade: chord, twist and the reference axis, linear between the file's grid points.  windIO's
  x points to the suction side (downwind) and y to the trailing edge, which are our prebend and
  sweep, so both keep their sign (an upwind prebend is negative in both).  The aerodynamic centre
  lies ahead of the axis, towards the leading edge, by

      a = section_offset_y - aerodynamic_center * chord,

  and with the twist theta (positive towards feather: leading edge upwind) our offsets become
  prebend = x - a sin theta, sweep = y - a cos theta.  ``section_offset_x`` is left out.
- polars: two airfoils per station, weighted linearly in relative thickness (along the span where
  the thickness of the stations does not fall from root to tip); of several Reynolds numbers the
  largest; several configurations with the file's weights.
- elastic properties: sectional axes follow the twist; bending about y is flap (K55), about x edge
  (K44).  The axial force is released, K_ij - K_3i K_3j / K33, so that stiffness is about the
  tension centre.
- tower: wall linear between grid points; elastic properties of the file where it has them.
- ``overhang`` is horizontal in windIO; ours is along the shaft, overhang / cos(uptilt).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from pitchopt.errors import InputError
from pitchopt.turbines.fields import Fields, FloatArray
from pitchopt.turbines.files import load_yaml
from pitchopt.turbines.model import Turbine
from pitchopt.turbines.records import FORMAT, turbine_from_record
from pitchopt.turbines.windio_parts import airfoil_table, blade_structure, curve, tower

__all__ = ["KEYS", "read_windio", "windio_record"]

KEYS = frozenset(
    [
        "windIO_version",
        "name",
        "comments",
        "comment",
        "assembly",
        "components",
        "airfoils",
        "materials",
        "control",
        "turbine_class",
        "turbulence_class",
        "drivetrain",
        "rotor_orientation",
        "number_of_blades",
        "rotor_diameter",
        "hub_height",
        "rated_power",
        "lifetime",
        "cut_in_wind_speed",
        "cut_out_wind_speed",
        "marine_hydro",
        "min_rotor_speed",
        "max_rotor_speed",
        "rated_rotor_speed",
        "optimal_tsr",
        "fine_pitch",
        "min_pitch",
        "max_pitch",
        "setpoint_pitch",
        "min_pitch_limit",
        "max_pitch_limit",
        "max_pitch_rate",
        "max_torque_rate",
        "max_generator_torque",
        "max_allowable_blade_tip_speed",
        "ps_percent",
        "blade",
        "hub",
        "nacelle",
        "tower",
        "monopile",
        "foundation",
        "floating_platform",
        "mooring",
        "outer_shape",
        "structure",
        "reference_axis",
        "chord",
        "twist",
        "section_offset_x",
        "section_offset_y",
        "rthick",
        "grid",
        "values",
        "x",
        "y",
        "z",
        "spanwise_position",
        "configuration",
        "configurations",
        "weight",
        "weights",
        "diameter",
        "cone_angle",
        "cd",
        "drag_coefficient",
        "spherical_joint_radius",
        "uptilt",
        "overhang",
        "distance_tt_hub",
        "distance_hub_mb",
        "distance_mb_mb",
        "gearbox",
        "gear_ratio",
        "efficiency",
        "gear_configuration",
        "planet_numbers",
        "generator",
        "rpm_efficiency",
        "generator_rpm_efficiency_user",
        "elastic_properties",
        "elastic_properties_mb",
        "mass",
        "inertia",
        "location",
        "system_mass",
        "system_inertia",
        "system_center_mass",
        "inertia_matrix",
        "stiffness_matrix",
        "damping_matrix",
        "structural_damping",
        "point_mass",
        "webs",
        "layers",
        "anchors",
        "joint",
        "joints",
        "root",
        "outfitting_factor",
        "outer_diameter",
        "thickness",
        "material",
        "description",
        "aerodynamic_center",
        "coordinates",
        "polars",
        "re",
        "re_sets",
        "cl",
        "cm",
        "rho",
        "E",
        "G",
        "nu",
        "Xt",
        "Xc",
        "Xy",
        "S",
        "ply_t",
        "unit_cost",
        "waste",
        "roll_mass",
        "orth",
        "alp0",
        "m",
        "GIc",
        "GIIc",
        "A0",
        "cm_x",
        "cm_y",
        "i_edge",
        "i_flap",
        "i_plr",
        "i_cp",
        "i_polar",
    ]
)
"""Names of windIO 2: another one that is nearly that of an optional entry is a slip of the pen."""


def read_windio(path: str | Path, *, nodes: int | None = 30) -> Turbine:
    """Turbine of a windIO v2 file.

    Parameters
    ----------
    path : path
        YAML file.
    nodes : int or None
        Number of blade stations, ends included, denser towards the tip; None keeps the file's
        own grid of the chord.

    Raises
    ------
    InputError
        Naming the file, the dotted key, what arrived and what is allowed.
    """
    return turbine_from_record(windio_record(path, nodes=nodes), str(path))


def windio_record(path: str | Path, *, nodes: int | None = 30) -> dict[str, Any]:
    """Record (see `pitchopt.turbines.records`) of a windIO v2 file."""
    if nodes is not None and (isinstance(nodes, bool) or int(nodes) != nodes or nodes < 2):
        raise InputError(f"nodes: got {nodes!r}, expected a whole number of at least 2, or None")
    top = Fields(load_yaml(path), str(path), known=KEYS)
    _check_version(top)
    parts = top.child("components")
    assembly = top.child("assembly")
    facing = assembly.text("rotor_orientation", "upwind")
    if facing.lower() != "upwind":
        assembly.fail(
            "rotor_orientation",
            f"got {facing[:40]!r}, expected an upwind rotor, no other is supported",
        )
    hub, drive = parts.child("hub"), parts.child("drivetrain")
    nose = drive.child("outer_shape")
    tilt = nose.number("uptilt", at_least=0.0, at_most=45.0, unit="deg")
    overhang = nose.number("overhang", at_least=0.0, at_most=100.0, unit="m") / float(
        np.cos(np.deg2rad(tilt))
    )
    blade, airfoils = _blade(top, parts.child("blade"), nodes)
    record: dict[str, Any] = {
        "format": FORMAT,
        "name": top.text("name"),
        "source": f"windIO file {Path(path).name}",
        "description": " ".join(top.text("comments", "").split()),
        "rotor": {
            "blades": assembly.integer("number_of_blades", at_least=1)
            if assembly.has("number_of_blades")
            else 3,
            "hub_radius": hub.number("diameter", above=0.0, at_most=100.0, unit="m") / 2.0,
            "hub_height": assembly.number("hub_height", above=0.0, at_most=1000.0, unit="m"),
            "overhang": overhang,
            "tilt_deg": tilt,
            "cone_deg": hub.number("cone_angle", at_least=0.0, at_most=45.0, unit="deg"),
        },
        "operation": _operation(assembly, top.child("control")),
        "blade": blade,
        "airfoils": airfoils,
        "tower": tower(top, parts.child("tower")),
        "drivetrain": _drivetrain(drive),
    }
    _check_geometry(assembly, record)
    optional = {
        "blade_structure": blade_structure(parts.child("blade")),
        "hub": _hub(hub),
        "nacelle": _nacelle(drive),
    }
    return record | {key: part for key, part in optional.items() if part is not None}


def _check_version(top: Fields) -> None:
    version = top.text("windIO_version", "")
    if not version:
        blade = _dict(_dict(top.data.get("components")).get("blade"))
        which = "this looks like version 1; " if "outer_shape_bem" in blade else ""
        top.fail("windIO_version", f"the key is missing; {which}expected a windIO version 2 file")
    if version.split(".")[0] != "2":
        top.fail(
            "windIO_version",
            f"got {version[:20]!r}, expected version 2; windIO's own converter turns "
            "version 1 files into version 2",
        )


def _dict(value: object) -> dict[Any, Any]:
    return value if isinstance(value, dict) else {}


def _check_geometry(assembly: Fields, record: dict[str, Any]) -> None:
    """Refuse a rotor or tower that contradicts the file's own summary."""
    rotor = record["rotor"]
    radius = rotor["hub_radius"] + record["blade"]["span"][-1]
    stated = assembly.maybe_number("rotor_diameter", above=0.0, unit="m")
    if stated is not None and abs(stated / (2.0 * radius) - 1.0) > 0.05:
        assembly.fail(
            "rotor_diameter",
            f"got {stated:g} m, but hub and blade make {2.0 * radius:g} m; expected within 5 %",
        )
    top = record["tower"]["height"][-1]
    if top > rotor["hub_height"]:
        assembly.fail(
            "hub_height",
            f"got {rotor['hub_height']:g} m, expected at least the tower top at {top:g} m",
        )


def _operation(assembly: Fields, control: Fields) -> dict[str, Any]:
    rated = control.number("rated_rotor_speed", above=0.0, at_most=1000.0, unit="rpm")
    low = control.number("min_pitch_limit", at_least=-90.0, at_most=90.0, unit="deg")
    high = control.number("max_pitch_limit", at_least=-90.0, at_most=90.0, unit="deg")
    if low > high:
        control.fail("min_pitch_limit", f"got {low:g}, expected at most max_pitch_limit = {high:g}")
    cut_in = assembly.maybe_number("cut_in_wind_speed", above=0.0, at_most=100.0, unit="m/s")
    cut_out = assembly.maybe_number("cut_out_wind_speed", above=0.0, at_most=100.0, unit="m/s")
    if cut_in is not None and cut_out is not None and cut_in >= cut_out:
        assembly.fail(
            "cut_in_wind_speed",
            f"got {cut_in:g}, expected less than cut_out_wind_speed = {cut_out:g}",
        )
    slowest = control.number("min_rotor_speed", at_least=0.0, unit="rpm")
    if slowest > rated:
        control.fail(
            "min_rotor_speed", f"got {slowest:g}, expected at most rated_rotor_speed = {rated:g}"
        )
    fastest = control.maybe_number("max_rotor_speed", above=0.0, unit="rpm")
    if fastest is not None and fastest < rated:
        control.fail(
            "max_rotor_speed", f"got {fastest:g}, expected at least rated_rotor_speed = {rated:g}"
        )
    classes = [assembly.text(key, "") for key in ("turbine_class", "turbulence_class")]
    return {
        "rated_power": assembly.number("rated_power", at_least=1e3, at_most=1e9, unit="W"),
        "rated_rotor_speed_rpm": rated,
        "min_rotor_speed_rpm": slowest,
        "max_rotor_speed_rpm": fastest,
        "max_tip_speed": control.maybe_number(
            "max_allowable_blade_tip_speed", above=0.0, unit="m/s"
        ),
        "cut_in_wind_speed": cut_in,
        "cut_out_wind_speed": cut_out,
        "optimal_tip_speed_ratio": control.maybe_number("optimal_tsr", above=0.0),
        "fine_pitch_deg": control.maybe_number(
            "fine_pitch", at_least=-90.0, at_most=90.0, unit="deg"
        ),
        "pitch_range_deg": [low, high],
        "pitch_rate_deg": control.number(
            "max_pitch_rate", at_least=0.0, at_most=360.0, unit="deg/s"
        ),
        "iec_class": "".join(classes).upper() or None,
    }


def _stations(chord_grid: FloatArray, nodes: int | None) -> FloatArray:
    """Non-dimensional stations, five times as dense at the tip as at the root."""
    if nodes is None:
        return chord_grid
    x = np.linspace(0.0, 1.0, nodes)
    grid = 0.25 * x + 0.75 * np.sin(np.pi / 2.0 * x)
    grid[-1] = 1.0
    return grid


def _blade(
    top: Fields, blade: Fields, nodes: int | None
) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    shape = blade.child("outer_shape")
    chord_grid, chord_values = curve(shape, "chord", above=0.0, at_most=100.0, unit="m")
    grid = _stations(chord_grid, nodes)
    axis = blade.child("reference_axis")
    z_grid, z_values = curve(axis, "z", unit="m")
    if np.any(np.diff(z_values) <= 0.0):
        axis.fail_order("z.values", z_values)
    span = np.interp(grid, z_grid, z_values - z_values[0])
    span[0] = 0.0
    x, y = (np.interp(grid, *curve(axis, key, unit="m")) for key in ("x", "y"))
    chord = np.interp(grid, chord_grid, chord_values)
    twist_deg = np.interp(grid, *curve(shape, "twist", at_least=-180.0, at_most=180.0, unit="deg"))
    offset = np.interp(grid, *curve(shape, "section_offset_y", unit="m"))
    airfoils, stations, thickness, centre = airfoil_table(top, shape, grid)
    ahead = offset - centre * chord
    twist = np.deg2rad(twist_deg)
    record = {
        "span": span.tolist(),
        "chord": chord.tolist(),
        "twist_deg": twist_deg.tolist(),
        "prebend": (x - ahead * np.sin(twist)).tolist(),
        "sweep": (y - ahead * np.cos(twist)).tolist(),
        "relative_thickness": thickness.tolist(),
        "pitch_axis": (offset / chord).tolist(),
        "polars": stations,
    }
    return record, airfoils


def _rigid_body(part: Fields) -> tuple[float, FloatArray, FloatArray | None]:
    """Mass, inertia (6,) and location (3,) of windIO's rigid body, in its old or new names."""
    old = part.has("system_mass")
    mass = part.number("system_mass" if old else "mass", at_least=0.0, unit="kg")
    inertia = part.array("system_inertia" if old else "inertia", size=6)
    where = "location" if part.has("location") else "system_center_mass"
    return mass, inertia, part.maybe_array(where, size=3)


def _hub(hub: Fields) -> dict[str, Any] | None:
    part = hub.optional("elastic_properties") or hub.optional("elastic_properties_mb")
    if part is None:
        return None
    mass, inertia, _ = _rigid_body(part)
    return {"mass": mass, "inertia": float(inertia[0])}


def _nacelle(drive: Fields) -> dict[str, Any] | None:
    part = drive.optional("elastic_properties") or drive.optional("elastic_properties_mb")
    if part is None or not (part.has("mass") or part.has("system_mass")):
        return None
    mass, inertia, centre = _rigid_body(part)
    record: dict[str, Any] = {"mass": mass, "yaw_inertia": float(max(inertia[2], inertia[5]))}
    if centre is not None:
        record["centre"] = centre.tolist()
    return record


def _drivetrain(drive: Fields) -> dict[str, Any]:
    record: dict[str, Any] = {"gear_ratio": 1.0}
    efficiency = 1.0
    box = drive.optional("gearbox")
    if box is not None:
        if box.has("gear_ratio"):
            record["gear_ratio"] = box.number("gear_ratio", above=0.0)
        efficiency = box.maybe_number("efficiency", above=0.0, at_most=1.0) or 1.0
    generator = drive.optional("generator")
    for key in ("rpm_efficiency", "generator_rpm_efficiency_user"):
        if generator is not None and generator.has(key):
            table = generator.child(key).array("values", at_least=0.0, at_most=1.0)
            if table[-1] > 0.0:
                record["efficiency"] = efficiency * float(table[-1])
    return record
