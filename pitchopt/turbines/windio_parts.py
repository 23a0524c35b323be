"""Parts of a windIO v2 file: distributed data, airfoils and their blending, elastic beams.

Helpers of `pitchopt.turbines.windio`, where conventions and signs are stated.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pitchopt.turbines.fields import Fields, FloatArray, one_of

__all__ = ["airfoil_table", "blade_structure", "curve", "tower"]

_EDGE = 1e-6  # tolerance on a grid's first and last value


def curve(
    owner: Fields,
    key: str,
    *,
    above: float | None = None,
    at_least: float | None = None,
    at_most: float | None = None,
    unit: str = "",
) -> tuple[FloatArray, FloatArray]:
    """Grid (n,) from 0 to 1 and values (n,) of the distributed quantity `key`."""
    part = owner.child(key)
    grid = _unit_grid(part)
    values = part.array(
        "values", size=grid.size, above=above, at_least=at_least, at_most=at_most, unit=unit
    )
    return grid, values


def _unit_grid(part: Fields) -> FloatArray:
    grid = part.array("grid", at_least=-_EDGE, at_most=1.0 + _EDGE, increasing=True)
    if grid.size < 2 or abs(grid[0]) > _EDGE or abs(grid[-1] - 1.0) > _EDGE:
        part.fail("grid", f"runs from {grid[0]:g} to {grid[-1]:g}, expected from 0 to 1")
    return grid


def _polar(airfoil: Fields, configuration: str) -> list[tuple[FloatArray, FloatArray]]:
    """Tables (alpha [deg], coefficient) of cl, cd, cm at the largest Reynolds number."""
    polars = {item.text("configuration", "default"): item for item in airfoil.children("polars")}
    if configuration not in polars:
        airfoil.fail("polars", f"no configuration {configuration!r}, there are {sorted(polars)}")
    sets = list(polars[configuration].children("re_sets"))
    chosen = max(sets, key=lambda item: item.maybe_number("re", at_least=0.0) or 0.0)
    tables: list[tuple[FloatArray, FloatArray]] = []
    for key in ("cl", "cd", "cm"):
        if key == "cm" and not chosen.has("cm"):
            tables.append((tables[0][0], np.zeros_like(tables[0][0])))
            continue
        part = chosen.child(key)
        alpha = part.array("grid", at_least=-180.0, at_most=180.0, increasing=True, unit="deg")
        if alpha.size < 2:
            part.fail("grid", "got 1 angle of attack, expected at least 2")
        tables.append((alpha, part.array("values", size=alpha.size)))
    return tables


def _mixed(airfoil: Fields, names: list[str], weights: FloatArray) -> dict[str, Any]:
    """Polar of an airfoil as weighted sum of its configurations, on one grid of angles."""
    tables = [_polar(airfoil, name) for name in names]
    alpha = np.unique(np.concatenate([grid for table in tables for grid, _ in table]))
    record: dict[str, Any] = {"name": airfoil.text("name"), "alpha_deg": alpha.tolist()}
    for i, key in enumerate(("cl", "cd", "cm")):
        parts = [w * np.interp(alpha, *table[i]) for w, table in zip(weights, tables, strict=True)]
        record[key] = np.sum(parts, axis=0).tolist()
    return record


def airfoil_table(
    top: Fields, shape: Fields, grid: FloatArray
) -> tuple[list[dict[str, Any]], list[list[float]], FloatArray, FloatArray]:
    """Airfoils of a blade and their weights at the stations `grid` (E,).

    Returns
    -------
    airfoils : list of dict
        Polars, each once.
    stations : list of [int, int, float], length E
        First airfoil, second airfoil, weight of the second.
    thickness, centre : ndarray (E,)
        Relative thickness and aerodynamic centre (from the leading edge over chord).
    """
    library: dict[str, Fields] = {}
    for entry in top.children("airfoils"):
        library[entry.text("name")] = entry
    airfoils: list[dict[str, Any]] = []
    index: dict[tuple[str, ...], int] = {}
    position, order, thick, centres = [], [], [], []
    for entry in shape.children("airfoils"):
        name = entry.text("name")
        if name not in library:
            entry.fail("name", one_of(name, library))
        airfoil = library[name]
        names = entry.texts("configuration") if entry.has("configuration") else ["default"]
        weights = np.ones(1)
        if entry.has("weight"):
            weights = entry.array("weight", size=len(names), at_least=0.0)
        if abs(float(weights.sum()) - 1.0) > 1e-3:
            entry.fail("weight", f"weights sum to {weights.sum():g}, expected 1")
        label = (name, *names, *(f"{w:g}" for w in weights))
        if label not in index:
            index[label] = len(airfoils)
            airfoils.append(_mixed(airfoil, names, weights))
        order.append(index[label])
        if entry.has("spanwise_position") or not shape.has("rthick"):
            position.append(entry.number("spanwise_position", at_least=0.0, at_most=1.0))
        thick.append(airfoil.number("rthick", above=0.0, at_most=1.0))
        centres.append(airfoil.number("aerodynamic_center", at_least=0.0, at_most=1.0))
    thickness = np.array(thick)
    where = np.array(position)
    if where.size != thickness.size:  # the thickness alone tells; of equals the innermost
        where = np.ones(thickness.size)
    if np.any(np.diff(where) < 0.0):
        i = int(np.argmax(np.diff(where) < 0.0)) + 1
        shape.fail(
            f"airfoils[{i}].spanwise_position",
            f"got {where[i]:g} after {where[i - 1]:g}, expected not less",
        )
    if shape.has("rthick"):
        local = np.interp(grid, *curve(shape, "rthick", above=0.0, at_most=1.0 + _EDGE))
    else:
        local = np.interp(grid, where, thickness)
    low, high, weight = _weights(grid, local, where, thickness)
    stations = [[order[i], order[j], float(w)] for i, j, w in zip(low, high, weight, strict=True)]
    ahead = np.array(centres)
    centre = (1.0 - weight) * ahead[low] + weight * ahead[high]
    return airfoils, stations, np.minimum(local, 1.0), centre


def _weights(
    grid: FloatArray, local: FloatArray, where: FloatArray, thickness: FloatArray
) -> tuple[list[int], list[int], FloatArray]:
    """Neighbouring stations of airfoils and weight of the second, by thickness or by span."""
    last = where.size - 1
    falling = bool(np.all(np.diff(thickness) <= 0.0))
    low, high, weight = [], [], np.zeros(grid.size)
    for n, (s, t) in enumerate(zip(grid, local, strict=True)):
        if falling:
            t = float(np.clip(t, thickness[-1], thickness[0]))
            first = int(np.searchsorted(-thickness, -t, side="left"))  # first as thin as t
            after = int(np.searchsorted(-thickness, -t, side="right"))
            if first < after:  # equally thick airfoils: the one reached by then
                reached = int(np.searchsorted(where, s + _EDGE, side="right")) - 1
                first = after = int(np.clip(reached, first, after - 1))
            else:
                first, after = first - 1, first
                weight[n] = (thickness[first] - t) / (thickness[first] - thickness[after])
        else:
            first = int(np.clip(np.searchsorted(where, s, side="right") - 1, 0, last))
            after = min(first + 1, last)
            gap = where[after] - where[first]
            weight[n] = float(np.clip((s - where[first]) / gap, 0.0, 1.0)) if gap > 0.0 else 0.0
        low.append(first)
        high.append(after)
    return low, high, weight


def _beam(part: Fields) -> tuple[FloatArray, FloatArray, dict[str, FloatArray]]:
    """Grid, mass per length and stiffnesses about the tension centre of windIO's beam."""
    inertia, stiffness = part.child("inertia_matrix"), part.child("stiffness_matrix")
    grid = _unit_grid(inertia)
    mass = inertia.array("mass", size=grid.size, above=0.0)
    own = _unit_grid(stiffness)
    k = {
        key: np.interp(grid, own, stiffness.array(key, size=own.size))
        for key in ("K33", "K34", "K35", "K44", "K45", "K55", "K66")
        if stiffness.has(key)
    }
    zero = np.zeros(grid.size)
    for key in ("K44", "K55"):
        k[key] = np.interp(grid, own, stiffness.array(key, size=own.size, above=0.0))
    axial = k.get("K33")
    x, y = k.get("K34", zero), k.get("K35", zero)
    if axial is not None and np.all(axial > 0.0):
        k["K44"] = k["K44"] - x * x / axial
        k["K55"] = k["K55"] - y * y / axial
        k["K45"] = k.get("K45", zero) - x * y / axial
    for key in ("K44", "K55"):
        if np.any(k[key] <= 0.0):
            stiffness.fail(key, "not positive about the tension centre, expected a stable section")
    return grid, mass, k


def blade_structure(blade: Fields) -> dict[str, Any] | None:
    """Record of the blade's elastic properties, None where the file has none."""
    structure = blade.optional("structure")
    part = structure.optional("elastic_properties") if structure is not None else None
    if part is None or not (part.has("inertia_matrix") and part.has("stiffness_matrix")):
        return None
    grid, mass, k = _beam(part)
    axis = blade.child("reference_axis")
    fine = np.unique(np.concatenate([grid, *(curve(axis, key)[0] for key in "xyz")]))
    point = np.stack([np.interp(fine, *curve(axis, key)) for key in "xyz"])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(point), axis=0))])
    twist = np.interp(grid, *curve(blade.child("outer_shape"), "twist"))
    record: dict[str, Any] = {
        "span": np.interp(grid, fine, arc).tolist(),
        "mass_per_length": mass.tolist(),
        "flap_stiffness": k["K55"].tolist(),
        "edge_stiffness": k["K44"].tolist(),
        "structural_twist_deg": twist.tolist(),
    }
    if "K45" in k and np.any(k["K45"]):
        record["coupling_stiffness"] = k["K45"].tolist()
    if "K66" in k and np.all(k["K66"] > 0.0):
        record["torsion_stiffness"] = k["K66"].tolist()
    inertia = part.child("inertia_matrix")
    for key, ours in (("cm_x", "mass_centre_x"), ("cm_y", "mass_centre_y")):
        if inertia.has(key):
            record[ours] = inertia.array(key, size=grid.size).tolist()
    return record


def tower(top: Fields, part: Fields) -> dict[str, Any]:
    """Record of the tower."""
    z_grid, z = curve(part.child("reference_axis"), "z", unit="m")
    if np.any(np.diff(z) <= 0.0):
        part.child("reference_axis").fail_order("z.values", z)
    shape = part.child("outer_shape")
    d_grid, d = curve(shape, "outer_diameter", above=0.0, at_most=100.0, unit="m")
    structure = part.optional("structure")
    walls = []
    if structure is not None and structure.has("layers"):
        walls = [
            (layer, *curve(layer, "thickness", above=0.0, at_most=10.0, unit="m"))
            for layer in structure.children("layers")
        ]
    beam = structure.optional("elastic_properties") if structure is not None else None
    grids = [z_grid, d_grid, *(g for _, g, _ in walls)]
    grid = _merged(np.concatenate(grids))
    record: dict[str, Any] = {
        "height": np.interp(grid, z_grid, z).tolist(),
        "diameter": np.interp(grid, d_grid, d).tolist(),
    }
    if walls and structure is not None:
        wall = np.sum([np.interp(grid, g, t) for _, g, t in walls], axis=0)
        record["thickness"] = wall.tolist()
        record["outfitting_factor"] = (
            structure.maybe_number("outfitting_factor", at_least=1.0) or 1.0
        )
        steel = _material(top, walls[0][0])
        record["density"] = steel.number("rho", above=0.0, unit="kg/m3")
        record["youngs_modulus"] = steel.number("E", above=0.0, unit="Pa")
        if steel.has("nu"):
            record["poisson_ratio"] = steel.number("nu", above=-1.0, at_most=0.5)
    if beam is not None and beam.has("inertia_matrix") and beam.has("stiffness_matrix"):
        own, mass, k = _beam(beam)
        record["mass_per_length"] = np.interp(grid, own, mass).tolist()
        record["bending_stiffness"] = np.interp(grid, own, k["K55"]).tolist()
    if shape.has("cd"):
        record["drag_coefficient"] = np.interp(grid, *curve(shape, "cd", at_least=0.0)).tolist()
    return record


def _merged(grid: FloatArray) -> FloatArray:
    """Sorted grid without points closer than the tolerance."""
    grid = np.unique(np.clip(grid, 0.0, 1.0))
    keep = np.concatenate([[True], np.diff(grid) > _EDGE])
    kept: FloatArray = grid[keep]
    kept[-1] = 1.0
    return kept


def _material(top: Fields, layer: Fields) -> Fields:
    name = layer.text("material")
    known = {}
    for entry in top.children("materials"):
        known[entry.text("name")] = entry
    if name not in known:
        layer.fail("material", one_of(name, known))
    return known[name]
