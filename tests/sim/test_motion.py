"""Equations of motion against Lagrange's equations of point masses, differentiated numerically.

The reference knows nothing of the integrals or of the frames in which the loop works: it has the
positions of point masses as functions of the coordinates, takes partial velocities J and
accelerations at zero q'' by central differences, and solves sum m J'J q'' = sum m J'(g - r'').
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from pitchopt.aero.rotor import hub_axes
from pitchopt.control import PitchActuator
from pitchopt.sim import DynamicTurbine, TurbineRun
from windfield import StaticField

G = np.array([0.0, 0.0, -9.80665])
POINTS = 7


class Lumps:
    """Point masses on a blade, with mode shapes U and shortening 0.5 q'Aq at each."""

    def __init__(self, seed: int, *, shortening: bool) -> None:
        rng = np.random.default_rng(seed)
        self.mass = rng.uniform(500.0, 3000.0, POINTS)
        self.z = np.linspace(4.0, 60.0, POINTS)
        self.shape = rng.normal(size=(POINTS, 2, 2)) * (self.z / 60.0)[:, None, None] ** 2
        root = rng.normal(size=(POINTS, 2, 2)) * 0.1
        self.short = np.einsum("pik,pjk->pij", root, root) * float(shortening)

    def tables(self) -> dict[str, Any]:
        m, z, u, a = self.mass, self.z, self.shape, self.short
        return {
            "mass": float(m.sum()),
            "first": float(m @ z),
            "second": float(m @ z**2),
            "force": np.einsum("p,pjd->jd", m, u),
            "lever": np.einsum("p,p,pjd->jd", m, z, u),
            "coupling": np.einsum("p,pic,pjd->icjd", m, u, u),
            "tension_gravity": np.einsum("p,pij->ij", m, a),
            "tension_rotation": np.einsum("p,p,pij->ij", m, z, a),
            "stiffness": np.zeros((2, 2)),
            "damping": np.zeros((2, 2)),
            "tower_stiffness": np.zeros(2),
            "tower_damping": np.zeros(2),
            "tower_weight": np.zeros(2),
            "tower_mass": np.zeros(2),
            "hub_inertia": 0.0,
        }

    def positions(
        self, q: np.ndarray, body: Any, tilt: float, yaw: float, pitch: np.ndarray
    ) -> np.ndarray:
        """Blades' points, hub, nacelle and bearing, ((3 P + 3), 3)."""
        theta = np.array([-body.tower_slope[1] * q[1], body.tower_slope[0] * q[0], 0.0])
        cross = np.array(
            [[0, -theta[2], theta[1]], [theta[2], 0, -theta[0]], [-theta[1], theta[0], 0]]
        )
        turn = np.eye(3) + cross + 0.5 * cross @ cross
        top = np.array([q[0], q[1], 0.0])
        apex = top + turn @ body.apex
        axes = turn @ hub_axes(tilt, yaw).T
        cone = math.atan2(body.cone_sine, body.cone_cosine)
        rows = []
        for k in range(3):
            psi = q[2] + 2 * math.pi * k / 3
            radial = -math.sin(psi) * axes[:, 1] + math.cos(psi) * axes[:, 2]
            y = math.cos(psi) * axes[:, 1] + math.sin(psi) * axes[:, 2]
            x = math.cos(cone) * axes[:, 0] + math.sin(cone) * radial
            z = math.cos(cone) * radial - math.sin(cone) * axes[:, 0]
            c, s = math.cos(pitch[k]), math.sin(pitch[k])
            bend = np.einsum("j,pjd->pd", q[4 + 2 * k : 6 + 2 * k], self.shape)
            ux, uy = bend[:, 0] * c + bend[:, 1] * s, bend[:, 1] * c - bend[:, 0] * s
            part = q[4 + 2 * k : 6 + 2 * k]
            w = self.z - 0.5 * np.einsum("i,j,pij->p", part, part, self.short)
            rows.append(apex + np.outer(ux, x) + np.outer(uy, y) + np.outer(w, z))
        rows.append(np.stack([apex, top + turn @ body.nacelle, top]))
        return np.concatenate(rows)


def setup(nrel, lumps: Lumps, freedoms, yaw: float = 0.0) -> tuple[TurbineRun, Any]:
    """A run whose structure is the lumps', in air too thin to matter."""
    actuator = PitchActuator(lowest=-1.0, highest=1.0, rate=1.0)
    dynamic = DynamicTurbine(turbine=nrel, freedoms=freedoms, yaw=yaw, actuator=actuator)
    still = StaticField(speed=1e-3, hub_height=90.0)
    run = TurbineRun(dynamic, still, rotor_speed=1.0, pitch=np.array([0.1, 0.3, -0.2]))
    body = run.model.body._replace(**lumps.tables())
    rotor = run.model.rotor._replace(density=1e-12)
    run.model = run.model._replace(body=body, rotor=rotor)
    return run, body


def reference(lumps: Lumps, run: TurbineRun, body: Any, torque: float) -> dict[str, np.ndarray]:
    state = run.state
    q, v = state.q.copy(), state.v.copy()
    tilt = run.dynamic.turbine.rotor.tilt
    mass = np.concatenate(
        [*[lumps.mass] * 3, [body.hub_mass, body.nacelle_mass, body.bearing_mass]]
    )

    def at(x: np.ndarray) -> np.ndarray:
        return lumps.positions(x, body, tilt, run.dynamic.yaw, state.pitch)

    h = 1e-5
    size = q.size
    partial = np.empty((size, mass.size, 3))
    for j in range(size):
        side = np.zeros(size)
        side[j] = h
        partial[j] = (at(q + side) - at(q - side)) / (2 * h)
    t = 1e-4
    coriolis = (at(q + t * v) - 2 * at(q) + at(q - t * v)) / t**2
    matrix = np.einsum("p,ipd,jpd->ij", mass, partial, partial)
    right = np.einsum("p,ipd,pd->i", mass, partial, G - coriolis)
    for i in (2, 3):
        right[i] -= torque
        for j in (2, 3):
            matrix[i, j] += body.generator_inertia
    used = np.flatnonzero(body.active)
    a = np.zeros(size)
    a[used] = np.linalg.solve(matrix[np.ix_(used, used)], right[used])
    acceleration = coriolis + np.einsum("j,jpd->pd", a, partial)
    return {"a": a, "force": mass[:, None] * (G - acceleration), "position": at(q)}


def test_accelerations_and_section_loads(nrel) -> None:
    from pitchopt.sim.kernels_march import begin

    freedoms = (
        "rotor-speed", "tower-fore-aft", "tower-side-side", "blade-flap", "blade-edge",
        "shaft-torsion",
    )  # fmt: skip
    for seed in range(4):
        lumps = Lumps(seed, shortening=False)
        run, body = setup(nrel, lumps, freedoms, yaw=0.2 * seed)
        rng = np.random.default_rng(10 + seed)
        state = run.state
        state.q[:] = rng.normal(size=10) * [0, 0, 2, 0, *[1.5, 0.8] * 3]
        state.v[:] = rng.normal(size=10) * [0.5, 0.4, 0.3, 0.0, *[2.0, 1.0] * 3]
        state.v[2] += 1.3
        state.torque[:] = 2e4
        assert begin(run.model, state, run.work)
        expected = reference(lumps, run, body, 2e4 * 97.0)
        assert state.a == pytest.approx(expected["a"], rel=2e-5, abs=2e-5)

        # loads: sums over the points beyond the section
        force, position = expected["force"], expected["position"]
        frames = run.work.rotor.frame
        apex = position[3 * POINTS]
        for k in range(3):
            part = slice(k * POINTS, (k + 1) * POINTS)
            root = apex + body.hub_radius * frames[k, :, 2]
            total = force[part].sum(axis=0)
            moment = np.cross(position[part] - root, force[part]).sum(axis=0)
            scale = np.abs(moment).max()
            assert run.work.root[k, :3] == pytest.approx(
                frames[k].T @ total, abs=3e-5 * np.abs(total).max()
            )
            assert run.work.root[k, 3:] == pytest.approx(frames[k].T @ moment, abs=3e-5 * scale)
        rotor = slice(0, 3 * POINTS + 1)
        moment = np.cross(position[rotor] - apex, force[rotor]).sum(axis=0)
        axes = run.work.rotor.axes
        assert run.work.hub[3:] == pytest.approx(axes.T @ moment, abs=3e-5 * np.abs(moment).max())
        total = force.sum(axis=0)
        moment = np.cross(position - np.array([state.q[0], state.q[1], 0.0]), force).sum(axis=0)
        assert run.work.top[:3] == pytest.approx(total, abs=3e-5 * np.abs(total).max())
        assert run.work.top[3:] == pytest.approx(moment, abs=3e-5 * np.abs(moment).max())


def test_geometric_stiffness(nrel) -> None:
    """To first order in the deflection, shortening adds the stiffness of rotation and weight."""
    from pitchopt.sim.kernels_march import begin

    for seed in range(3):
        lumps = Lumps(seed, shortening=True)
        run, body = setup(nrel, lumps, ("blade-flap", "blade-edge"))
        state = run.state
        sizes = []
        for scale in (1e-3, -1e-3):
            state.q[:] = 0.0
            state.v[:] = 0.0
            state.q[2], state.v[2] = 0.7 + seed, 1.6
            state.q[4:] = scale * np.array([1.0, -0.5, 0.3, 0.8, -0.9, 0.2])
            assert begin(run.model, state, run.work)
            expected = reference(lumps, run, body, 0.0)["a"]
            sizes.append((state.a.copy(), expected))
        ours = (sizes[0][0] - sizes[1][0]) / 2e-3
        theirs = (sizes[0][1] - sizes[1][1]) / 2e-3
        assert ours == pytest.approx(theirs, rel=1e-3, abs=1e-3 * np.abs(theirs).max())
        bare = Lumps(seed, shortening=False)
        run, body = setup(nrel, bare, ("blade-flap", "blade-edge"))
        run.state.q[2], run.state.v[2] = 0.7 + seed, 1.6
        run.state.q[4:] = 1e-3 * np.array([1.0, -0.5, 0.3, 0.8, -0.9, 0.2])
        begin(run.model, run.state, run.work)
        assert np.abs(run.state.a - sizes[0][0]).max() > 1e-5  # the term is not nothing
