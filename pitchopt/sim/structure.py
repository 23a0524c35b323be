"""Elastic blades and tower reduced to their first bending modes.

A blade bends by u(z, t) = q_f U_f(z) + q_e U_e(z), with z the distance from the rotor apex along
the blade and U = (U_x, U_y) in the coned frame at zero pitch; pitch beta turns U by

    (U_x, U_y) -> (U_x cos beta + U_y sin beta, U_y cos beta - U_x sin beta).

U_f and U_e are eigenmodes of the twisted beam at a stated rotor speed, centrifugal force
included, scaled to a tip deflection of 1 m in their larger direction.  What the equations of
motion need of them are integrals over the mass m(z),

    mass, first, second = int m (1, z, z^2) dz,     force_j  = int m U_j dz,
    lever_j = int m z U_j dz,                       coupling_ij = int m U_i (x) U_j dz,
    stiffness_ij = int U_i'' . EI U_j'' dz,
    tension_gravity_ij, tension_rotation_ij = int (int_z m (1, s) ds) U_i' . U_j' dz.

The last two times the axial acceleration of the blade are its geometric stiffness.  The tower
bends by phi(h) with phi = 1 at its top, fore-aft and side-side, in eigenmodes of the clamped
beam with nacelle and rotor on top and under their weight.  Damping is proportional to stiffness
and gives each mode of the blade at rest, and of the tower without its head, its ratio.

The reduction (constrained modes with geometric stiffness) is the usual one of modal aeroelastic
codes; T. Burton et al., Wind Energy Handbook, section 5.8.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pitchopt.checks import FloatArray, finite_array, finite_number
from pitchopt.errors import InputError
from pitchopt.sim.beams import Beam
from pitchopt.turbines import Turbine

__all__ = [
    "GRAVITY",
    "BladeModel",
    "TowerModel",
    "blade_model",
    "head_matrices",
    "tower_model",
    "tower_stations",
]

GRAVITY = 9.80665
_BLADE_DAMPING = 0.005  # where the turbine's data have none
_TOWER_DAMPING = 0.01
_STATIONS = 60  # of the tower's beam
_MODES = 6  # among which the edgewise mode is looked for


@dataclass(frozen=True, kw_only=True, eq=False)
class BladeModel:
    """One blade in its flapwise and edgewise mode, see the module for the integrals.

    Attributes
    ----------
    mass, first, second : float
        [kg, kg m, kg m^2], about the rotor apex.
    force, lever : ndarray (2, 2)
        Mode, direction [kg, kg m].
    coupling : ndarray (2, 2, 2, 2)
        Mode, direction, mode, direction [kg].
    stiffness, damping : ndarray (2, 2)
        [N/m, N s/m].
    tension_gravity, tension_rotation : ndarray (2, 2)
        [kg/m, kg].
    node_shape, node_slope : ndarray (E, 2, 2)
        U and dU/dz at the aerodynamic stations: station, mode, direction [-, 1/m].
    node_shortening : ndarray (E, 2, 2)
        int U_i' . U_j' dz up to the station; half of it times q_i q_j shortens z [1/m].
    node_weight : ndarray (E, 2, 2)
        Weights that turn loads per length at the stations into modal forces [m].
    tip_shape : ndarray (2, 2)
        U at the tip: mode, direction.
    frequency : ndarray (2,)
        Natural frequencies at rest, root clamped [rad/s].
    rotor_speed : float
        Speed at which the modes were taken [rad/s].
    """

    mass: float
    first: float
    second: float
    force: FloatArray
    lever: FloatArray
    coupling: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    tension_gravity: FloatArray
    tension_rotation: FloatArray
    node_shape: FloatArray
    node_slope: FloatArray
    node_shortening: FloatArray
    node_weight: FloatArray
    tip_shape: FloatArray
    frequency: FloatArray
    rotor_speed: float


@dataclass(frozen=True, kw_only=True, eq=False)
class TowerModel:
    """Tower in its first fore-aft and side-side mode.

    Attributes
    ----------
    height : ndarray (H,)
        Stations at which section loads are given, base first, top last [m].
    shape : ndarray (2, H)
        phi of fore-aft and side-side.
    slope : ndarray (2,)
        dphi/dh at the top [1/m].
    mass, stiffness, damping : ndarray (2,)
        Of the tower alone [kg, N/m, N s/m].
    weight_top, weight_own : ndarray (2,)
        int phi'^2 dh and int (int_h mu) phi'^2 dh: times gravity and, the former, the head's
        mass, the stiffness lost to weight [1/m, kg/m].
    mass_above : ndarray (H,)
        Tower mass above the stations [kg].
    inertia_force, inertia_moment, weight_moment : ndarray (2, H)
        int mu phi, int mu (s - h) phi(s), int mu (phi(s) - phi(h)) above the stations.
    frequency : ndarray (2,)
        Natural frequencies with the head, rotor free to turn [rad/s].
    """

    height: FloatArray
    shape: FloatArray
    slope: FloatArray
    mass: FloatArray
    stiffness: FloatArray
    damping: FloatArray
    weight_top: FloatArray
    weight_own: FloatArray
    mass_above: FloatArray
    inertia_force: FloatArray
    inertia_moment: FloatArray
    weight_moment: FloatArray
    frequency: FloatArray


def _directions(angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Flapwise and edgewise unit vectors (..., 2) of sections turned by twist and pitch."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)


def blade_model(
    turbine: Turbine, *, rotor_speed: float | None = None, damping_ratio: float | None = None
) -> BladeModel:
    """Reduce a turbine's blade.

    Parameters
    ----------
    turbine : Turbine
    rotor_speed : float, optional
        Speed at which the mode shapes are taken [rad/s]; rated if absent.
    damping_ratio : float, optional
        Of both modes; the turbine's own if absent, 0.5 % if it has none.

    Raises
    ------
    InputError
        If the turbine has no blade structure.
    """
    data = turbine.blade_structure
    if data is None:
        raise InputError(
            f"turbine {turbine.name!r}: has no blade structure, which a dynamic turbine needs"
        )
    speed = turbine.rated_rotor_speed if rotor_speed is None else rotor_speed
    speed = finite_number("rotor_speed", speed, at_least=0.0)
    ratio = data.damping_ratio if damping_ratio is None else damping_ratio
    ratio = finite_number(
        "damping_ratio", _BLADE_DAMPING if ratio is None else ratio, at_least=0.0, at_most=1.0
    )
    root = turbine.rotor.hub_radius
    flap, edge = _directions(data.structural_twist)
    stiffness = (
        data.flap_stiffness[:, None, None] * flap[:, :, None] * flap[:, None, :]
        + data.edge_stiffness[:, None, None] * edge[:, :, None] * edge[:, None, :]
    )
    if data.coupling_stiffness is not None:
        cross = flap[:, :, None] * edge[:, None, :]
        stiffness = stiffness + data.coupling_stiffness[:, None, None] * (
            cross + np.swapaxes(cross, 1, 2)
        )
    beam = Beam(data.span, data.mass_per_length, stiffness)
    z = beam.points + root
    tension_rotation = beam.beyond(beam.mass * z)
    tension_gravity = beam.beyond(beam.mass)
    inertia = beam.assemble(beam.mass, 0)
    elastic = beam.assemble(beam.stiffness, 2)
    geometric = beam.assemble(tension_rotation, 1)
    in_plane = np.zeros((2, 2))
    in_plane[1, 1] = 1.0
    softening = beam.assemble(beam.mass[..., None, None] * in_plane, 0)
    _, all_shapes = beam.modes(inertia, elastic + speed**2 * (geometric - softening), _MODES)
    shapes = _flap_and_edge(all_shapes)
    modal_stiffness = shapes @ elastic @ shapes.T
    modal_mass = shapes @ inertia @ shapes.T
    # natural frequencies of the two modes at rest
    from scipy.linalg import eigh

    frequency = np.sqrt(eigh(modal_stiffness, modal_mass, eigvals_only=True))
    own = np.sqrt(np.diag(modal_stiffness) / np.diag(modal_mass))
    u = np.stack([beam.sample(shape, 0) for shape in shapes])  # (2, E, P, 2)
    du = np.stack([beam.sample(shape, 1) for shape in shapes])
    dm = beam.weights * beam.mass
    bend = np.einsum("iepd,jepd->ijep", du, du)
    blade = turbine.rotor.blade
    nodes = np.minimum(blade.span, data.span[-1])
    points, weights, hats = _node_rule(blade.span, blade.quadrature, turbine)
    at_points = np.stack([beam.at(shape, np.minimum(points, data.span[-1]), 0) for shape in shapes])
    return BladeModel(
        mass=float(dm.sum()),
        first=float((dm * z).sum()),
        second=float((dm * z * z).sum()),
        force=np.einsum("ep,jepd->jd", dm, u),
        lever=np.einsum("ep,ep,jepd->jd", dm, z, u),
        coupling=np.ascontiguousarray(np.einsum("ep,iepc,jepd->icjd", dm, u, u)),
        stiffness=modal_stiffness,
        damping=ratio * (1.0 / own[:, None] + 1.0 / own) * modal_stiffness,
        tension_gravity=np.einsum("ep,ep,ijep->ij", beam.weights, tension_gravity, bend),
        tension_rotation=np.einsum("ep,ep,ijep->ij", beam.weights, tension_rotation, bend),
        node_shape=np.stack([beam.at(shape, nodes, 0) for shape in shapes], axis=1),
        node_slope=np.stack([beam.at(shape, nodes, 1) for shape in shapes], axis=1),
        node_shortening=_shortening(beam, shapes, nodes),
        node_weight=np.einsum("p,ep,jpd->ejd", weights, hats, at_points),
        tip_shape=np.stack([shape[-4::2] for shape in shapes]),
        frequency=frequency,
        rotor_speed=speed,
    )


def _flap_and_edge(shapes: FloatArray) -> FloatArray:
    """First mode that moves the tip mostly out of plane and first mostly in plane, (2, 4 S)."""
    tips = np.abs(shapes.reshape(shapes.shape[0], -1, 2, 2)[:, -1, :, 0])
    out_of_plane = np.flatnonzero(tips[:, 0] >= tips[:, 1])
    in_plane = np.flatnonzero(tips[:, 0] < tips[:, 1])
    if out_of_plane.size == 0 or in_plane.size == 0:
        raise InputError(
            f"blade_structure: the first {shapes.shape[0]} modes all bend the same way; "
            "check flap and edge stiffness"
        )
    return np.stack([shapes[out_of_plane[0]], shapes[in_plane[0]]])


def _shortening(beam: Beam, shapes: FloatArray, nodes: FloatArray) -> FloatArray:
    """int U_i' . U_j' from the root to each node, (E, 2, 2), by a fine trapezium rule."""
    fine = np.linspace(0.0, beam.station[-1], 801)
    slope = np.stack([beam.at(shape, fine, 1) for shape in shapes])
    product = np.einsum("ipd,jpd->ijp", slope, slope)
    step = float(fine[1] - fine[0])
    steps = 0.5 * step * (product[..., 1:] + product[..., :-1])
    total = np.concatenate([np.zeros((2, 2, 1)), np.cumsum(steps, axis=-1)], axis=-1)
    out = np.empty((nodes.size, 2, 2))
    for i in range(2):
        for j in range(2):
            out[:, i, j] = np.interp(nodes, fine, total[i, j])
    return out


def _node_rule(
    span: FloatArray, quadrature: str, turbine: Turbine
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points (P,), weights (P,) and the stations' interpolants there (E, P).

    With ``nodes`` loads per length are linear between stations, along the curved blade; with
    ``elements`` they are constant over each element.
    """
    gauss = np.polynomial.legendre.leggauss(5)
    x, w = 0.5 * (gauss[0] + 1.0), 0.5 * gauss[1]
    blade = turbine.rotor.blade
    edges = span if quadrature == "nodes" else blade.edges
    gap = np.diff(edges)
    points = (edges[:-1, None] + gap[:, None] * x).ravel()
    weights = (gap[:, None] * w).ravel()
    hats = np.zeros((span.size, points.size))
    per = x.size
    if quadrature == "nodes":
        prebend, sweep = blade.offsets
        stretch = np.sqrt(np.diff(prebend) ** 2 + np.diff(sweep) ** 2 + gap**2) / gap
        weights = weights * np.repeat(stretch, per)
        for e in range(gap.size):
            part = slice(e * per, (e + 1) * per)
            hats[e, part] = 1.0 - x
            hats[e + 1, part] = x
    else:
        for e in range(gap.size):
            hats[e, e * per : (e + 1) * per] = 1.0
    return points, weights, hats


def tower_model(
    turbine: Turbine,
    blade: BladeModel,
    *,
    damping_ratio: float | None = None,
    sections: int = 10,
    polynomials: ArrayLike | None = None,
) -> TowerModel:
    """Reduce a turbine's tower.

    Parameters
    ----------
    turbine : Turbine
    blade : BladeModel
        For the rotor's mass and inertia on the tower's top.
    damping_ratio : float, optional
        Of both modes of the tower alone, without the head, as NREL/TP-500-38060 and ElastoDyn
        define it; the turbine's own if absent, 1 % if it has none.
    sections : int
        Number of equal parts between base and top at whose ends section loads are given.
    polynomials : array_like (2, 5), optional
        Coefficients of the powers 2 to 6 of the relative height that give the fore-aft and the
        side-side shape, as ElastoDyn's input has them, in place of the eigenmodes.

    Raises
    ------
    InputError
        If masses or stiffnesses of tower, hub or nacelle are not known.
    """
    tower, hub, nacelle = turbine.tower, turbine.hub, turbine.nacelle
    if tower.mass_per_length is None or tower.bending_stiffness is None:
        raise InputError(f"turbine {turbine.name!r}: tower without mass or bending stiffness")
    if hub is None or nacelle is None:
        raise InputError(f"turbine {turbine.name!r}: mass of hub or nacelle is not known")
    ratio = tower.damping_ratio if damping_ratio is None else damping_ratio
    ratio = finite_number(
        "damping_ratio", _TOWER_DAMPING if ratio is None else ratio, at_least=0.0, at_most=1.0
    )
    length = tower.top - tower.base
    station = tower_stations(tower.height - tower.base)
    mu = np.interp(station + tower.base, tower.height, tower.mass_per_length)
    ei = np.interp(station + tower.base, tower.height, tower.bending_stiffness)
    beam = Beam(station, mu, ei[:, None, None] * np.eye(2))
    head_mass, head = head_matrices(turbine, blade)
    above = beam.beyond(beam.mass)
    inertia = beam.assemble(beam.mass, 0)
    elastic = beam.assemble(beam.stiffness, 2)
    stiff = elastic - GRAVITY * beam.assemble(head_mass + above, 1)
    top = 4 * (station.size - 1)
    for d in range(2):
        part = slice(top + 2 * d, top + 2 * d + 2)
        inertia[part, part] += head[d]
        # weight of a head whose centre lies above the top tips it over
        stiff[top + 2 * d + 1, top + 2 * d + 1] -= GRAVITY * head[d][0, 1]
    heights = np.linspace(0.0, length, sections + 1)
    shapes, slopes, frequency = np.empty((2, heights.size)), np.empty(2), np.empty(2)
    integrals = {
        key: np.empty(2) for key in ("mass", "stiffness", "damping", "weight_top", "weight_own")
    }
    sections_of = {
        key: np.zeros((2, heights.size))
        for key in ("inertia_force", "inertia_moment", "weight_moment")
    }
    dm = beam.weights * beam.mass
    fine = np.linspace(0.0, length, 2001)
    mu_fine = np.interp(fine, station, mu)
    for d in range(2):
        keep = np.arange(4 * station.size) % 4 // 2 == d
        if polynomials is None:
            values, vectors = beam.modes(
                np.where(np.outer(keep, keep), inertia, np.diag(~keep * 1.0)),
                np.where(np.outer(keep, keep), stiff, np.diag(~keep * 1e12)),
                1,
            )
            frequency[d], shape = values[0], vectors[0]
        else:
            shape = _polynomial_shape(station / length, length, polynomials, d)
            frequency[d] = np.sqrt((shape @ stiff @ shape) / (shape @ inertia @ shape))
        shape = shape / shape[top + 2 * d]
        slopes[d] = shape[top + 2 * d + 1]
        phi = beam.sample(shape, 0)[..., d]
        dphi = beam.sample(shape, 1)[..., d]
        integrals["mass"][d] = (dm * phi**2).sum()
        integrals["stiffness"][d] = shape @ elastic @ shape
        integrals["damping"][d] = (
            2.0 * ratio * np.sqrt(integrals["stiffness"][d] * integrals["mass"][d])
        )
        integrals["weight_top"][d] = (beam.weights * dphi**2).sum()
        integrals["weight_own"][d] = (beam.weights * above * dphi**2).sum()
        shapes[d] = beam.at(shape, heights, 0)[:, d]
        phi_fine = beam.at(shape, fine, 0)[:, d]
        for h, low in enumerate(heights[:-1]):
            up = fine >= low - 1e-9
            s, m, p = fine[up], mu_fine[up], phi_fine[up]
            sections_of["inertia_force"][d, h] = np.trapezoid(m * p, s)
            sections_of["inertia_moment"][d, h] = np.trapezoid(m * (s - low) * p, s)
            sections_of["weight_moment"][d, h] = np.trapezoid(m * (p - shapes[d, h]), s)
    cumulative = np.concatenate(
        [[0.0], np.cumsum(0.5 * np.diff(fine) * (mu_fine[1:] + mu_fine[:-1]))]
    )
    return TowerModel(
        height=heights + tower.base,
        shape=shapes,
        slope=slopes,
        mass_above=np.interp(heights, fine, cumulative[-1] - cumulative),
        frequency=frequency,
        **integrals,
        **sections_of,
    )


def _polynomial_shape(
    share: FloatArray, length: float, polynomials: ArrayLike, direction: int
) -> FloatArray:
    """Unknowns (4 S,) of a beam that follows a polynomial of the relative height `share` (S,)."""
    rows = finite_array("polynomials", polynomials, shape=(2, 5))
    polynomial = np.polynomial.Polynomial([0.0, 0.0, *rows[direction]])
    if abs(polynomial(1.0)) < 1e-6:
        raise InputError("polynomials: got a shape that is zero at the tower top")
    nodes = np.zeros((share.size, 2, 2))
    nodes[:, direction, 0] = polynomial(share)
    nodes[:, direction, 1] = polynomial.deriv()(share) / length
    return nodes.ravel()


def tower_stations(height: FloatArray) -> FloatArray:
    """Stations of the tower's beam: those given, from 0 [m], and evenly spaced ones between.

    Some 60 in all, and more where the given ones lie close.
    """
    station = height
    length = float(station[-1])
    parts = np.maximum(np.round(np.diff(station) / length * _STATIONS), 1).astype(int)
    pieces = [
        np.linspace(a, b, int(n), endpoint=False)
        for a, b, n in zip(station[:-1], station[1:], parts, strict=True)
    ]
    return np.concatenate([*pieces, [length]])


def head_matrices(turbine: Turbine, blade: BladeModel) -> tuple[float, list[FloatArray]]:
    """Mass of nacelle and rotor, and their 2 x 2 mass matrices for (top deflection, slope).

    Fore-aft, then side-side, about the tower's top.

    The rotor is free to turn about its shaft, so its polar inertia stays out of side-side.
    """
    rotor, hub, nacelle = turbine.rotor, turbine.hub, turbine.nacelle
    if hub is None or nacelle is None:
        raise InputError(f"turbine {turbine.name!r}: mass of hub or nacelle is not known")
    rotor_mass = hub.mass + rotor.blades * blade.mass
    apex = rotor.apex() - np.array([0.0, 0.0, turbine.tower.top])
    cone = rotor.cone
    shaft = -rotor.blades * blade.first * float(np.sin(cone)) / rotor_mass
    centre = apex + shaft * np.array([np.cos(rotor.tilt), 0.0, -np.sin(rotor.tilt)])
    body = np.zeros(3) if nacelle.centre is None else nacelle.centre
    diametral = (
        0.5
        * rotor.blades
        * blade.second
        * (float(np.cos(cone)) ** 2 + 2.0 * float(np.sin(cone)) ** 2)
    )
    mass = rotor_mass + nacelle.mass + nacelle.yaw_bearing_mass
    lever = rotor_mass * centre[2] + nacelle.mass * body[2]
    # second moments about the lateral axis through the tower top: blades about the apex, apex
    # about the top, and the product of both for blades that lean out of the rotor plane
    distance = float(apex[0] ** 2 + apex[2] ** 2)
    along_shaft = float(apex[0] * np.cos(rotor.tilt) - apex[2] * np.sin(rotor.tilt))
    fore_aft = (
        diametral
        + rotor_mass * distance
        - 2.0 * rotor.blades * blade.first * float(np.sin(cone)) * along_shaft
        + nacelle.mass * float(body[0] ** 2 + body[2] ** 2)
    )
    side_side = rotor_mass * float(centre[2]) ** 2 + nacelle.mass * float(
        body[1] ** 2 + body[2] ** 2
    )
    return mass, [
        np.array([[mass, lever], [lever, fore_aft]]),
        np.array([[mass, lever], [lever, side_side]]),
    ]
