"""Blade quadrature, rotor frames and the wind at the sections."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.aero import Blade, Polar, Rotor
from pitchopt.aero.loads import load_map
from pitchopt.aero.rotor import hub_axes
from pitchopt.aero.steady import UniformInflow
from pitchopt.errors import InputError

FLAT = Polar(name="flat", alpha=[-np.pi, np.pi], cl=[0.0, 0.0], cd=[1.0, 1.0])


def blade(**change: object) -> Blade:
    values: dict[str, object] = {
        "span": [0.0, 10.0, 25.0, 30.0],
        "chord": [2.0, 2.0, 1.0, 0.5],
        "twist": [0.2, 0.1, 0.0, 0.0],
        "polars": (FLAT,) * 4,
    }
    return Blade(**{**values, **change})


class TestBlade:
    def test_node_quadrature_is_exact_for_linear_loads(self) -> None:
        zero = np.zeros(4)
        width, _, _, lever = blade().integration(zero, zero)
        load = 3.0 + 2.0 * blade().span
        assert width @ load == pytest.approx(3.0 * 30.0 + 30.0**2)
        assert lever @ load == pytest.approx(3.0 * 30.0**2 / 2 + 2.0 * 30.0**3 / 3)

    def test_element_quadrature(self) -> None:
        elements = blade().elements(6)
        assert elements.span.tolist() == [2.5, 7.5, 12.5, 17.5, 22.5, 27.5]
        assert elements.length == pytest.approx(30.0)
        zero = np.zeros(6)
        width, _, _, lever = elements.integration(zero, zero)
        assert width.tolist() == pytest.approx([5.0] * 6)
        assert lever.sum() == pytest.approx(450.0)
        assert elements.chord[3] == pytest.approx(2.0 - 7.5 / 15.0)

    @pytest.mark.parametrize(
        ("change", "word"),
        [
            ({"span": [0.0, 10.0, 10.0, 30.0]}, "span"),
            ({"chord": [1.0, 1.0, -1.0, 1.0]}, "chord"),
            ({"chord": [1.0, 1.0]}, "chord"),
            ({"twist": [0.0, 0.0, np.inf, 0.0]}, "twist"),
            ({"polars": (FLAT,) * 3}, "polars"),
            ({"quadrature": "gauss"}, "quadrature"),
            ({"quadrature": "elements"}, "span"),
        ],
    )
    def test_bad_input(self, change: dict[str, object], word: str) -> None:
        with pytest.raises(InputError, match=word):
            blade(**change)

    def test_bad_element_count(self) -> None:
        with pytest.raises(InputError, match="elements"):
            blade().elements(0)


class TestRotor:
    @given(st.floats(-0.2, 0.2), st.floats(-0.5, 0.5))
    def test_hub_axes_are_a_frame(self, tilt: float, yaw: float) -> None:
        axes = hub_axes(tilt, yaw)
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-12)
        np.testing.assert_allclose(np.cross(axes[0], axes[1]), axes[2], atol=1e-12)

    def test_directions(self) -> None:
        rotor = Rotor(
            blade=blade(), hub_radius=1.0, tilt=0.1, cone=0.05, overhang=5.0, hub_height=90.0
        )
        assert rotor.apex()[0] < 0.0
        assert hub_axes(0.1, 0.0)[0, 2] < 0.0  # shaft points down downwind
        up = rotor.sections(np.zeros(()), np.zeros(())).position[-1]
        right = rotor.sections(np.array(np.pi / 2), np.zeros(())).position[-1]
        assert up[2] > 115.0
        assert right[1] == pytest.approx(-31.0 * np.cos(0.05))
        straight = Rotor(blade=blade(), hub_radius=1.0, tilt=0.1, overhang=5.0, hub_height=90.0)
        down = np.array(np.pi)
        coned = rotor.sections(down, np.zeros(())).position[-1]
        flat = straight.sections(down, np.zeros(())).position[-1]
        assert coned[0] < flat[0]  # cone bends the tips upwind

    def test_pitch_turns_the_offsets(self) -> None:
        bent = Rotor(blade=blade(prebend=[0.0, 0.1, 0.2, 0.3]), hub_radius=1.0, hub_height=90.0)
        feathered = bent.sections(np.zeros(()), np.array(np.pi / 2))
        # towards feather the leading edge turns upwind: what lay downwind moves to -y_b
        np.testing.assert_allclose(feathered.x, 0.0, atol=1e-15)
        np.testing.assert_allclose(feathered.y, [0.0, -0.1, -0.2, -0.3])

    def test_relative_wind(self) -> None:
        rotor = Rotor(blade=blade(), hub_radius=1.0, hub_height=90.0)
        psi = np.linspace(0.0, 6.0, 7)
        sections = rotor.sections(psi, np.zeros(()))
        wind = rotor.wind(UniformInflow(12.0), sections, psi, 1.5)
        np.testing.assert_allclose(wind.normal, 12.0)
        np.testing.assert_allclose(wind.tangential, np.tile(1.5 * (1.0 + rotor.blade.span), (7, 1)))
        side = rotor.wind(
            UniformInflow(12.0), rotor.sections(psi, np.zeros(()), 0.2), psi, 1.5, 0.2
        )
        np.testing.assert_allclose(side.normal, 12.0 * np.cos(0.2))
        lateral = -12.0 * np.sin(0.2) * np.cos(psi)
        np.testing.assert_allclose(side.tangential - wind.tangential, np.tile(lateral[:, None], 4))

    def test_rotation_of_offset_sections_is_a_rigid_motion(self) -> None:
        """Velocity of the sections from the wind equals the derivative of their positions."""
        rotor = Rotor(
            blade=blade(prebend=[0.0, 0.1, 0.2, -0.4], sweep=[0.0, -0.2, 0.3, 0.5]),
            hub_radius=1.0,
            tilt=0.1,
            cone=0.06,
            overhang=4.0,
            hub_height=90.0,
        )
        psi, omega, step = np.array(0.7), 1.3, 1e-6
        pitch = np.array(0.3)
        ahead = rotor.sections(psi + step, pitch).position
        behind = rotor.sections(psi - step, pitch).position
        velocity = omega * (ahead - behind) / (2 * step)
        hub = hub_axes(rotor.tilt, 0.0)
        e_r = -np.sin(psi) * hub[1] + np.cos(psi) * hub[2]
        y_b = np.cos(psi) * hub[1] + np.sin(psi) * hub[2]
        x_c = np.cos(rotor.cone) * hub[0] + np.sin(rotor.cone) * e_r
        wind = rotor.wind(UniformInflow(0.0), rotor.sections(psi, pitch), psi, omega)
        np.testing.assert_allclose(wind.normal, -velocity @ x_c, atol=1e-7)
        np.testing.assert_allclose(wind.tangential, -velocity @ y_b, atol=1e-7)

    def test_loads_are_force_and_moment(self) -> None:
        """The load map against p x F with explicit vectors, elements of constant load."""
        rotor = Rotor(
            blade=blade(prebend=[0.0, 0.1, 0.2, -0.4], sweep=[0.0, -0.2, 0.3, 0.5]).elements(5),
            hub_radius=1.0,
            cone=0.08,
            hub_height=90.0,
        )
        sections = rotor.sections(np.zeros(()), np.array(0.2))
        rng = np.random.default_rng(3)
        phi, pressure = rng.uniform(0.1, 0.6, 5), rng.uniform(100.0, 3000.0, 5)
        cl, cd, cm = rng.uniform(-1.0, 1.0, (3, 5))
        chord = rotor.blade.chord
        got = load_map(sections, chord, rotor.cone, phi, pressure).apply(cl, cd, cm)
        # psi = 0: e_r = z, y_b = y
        cc, sc = np.cos(0.08), np.sin(0.08)
        x_c, y_c, z_c = np.array([cc, 0, sc]), np.array([0, 1.0, 0]), np.array([-sc, 0, cc])
        width = np.diff(rotor.blade.edges)
        force, moment = np.zeros(3), np.zeros(3)
        for e in range(5):
            qc = pressure[e] * chord[e] * width[e]
            normal = cl[e] * np.cos(phi[e]) + cd[e] * np.sin(phi[e])
            driving = cl[e] * np.sin(phi[e]) - cd[e] * np.cos(phi[e])
            f = qc * (normal * x_c - driving * y_c)
            p = sections.x[e] * x_c + sections.y[e] * y_c + (1.0 + rotor.blade.span[e]) * z_c
            force += f
            moment += np.cross(p, f) + qc * chord[e] * cm[e] * z_c
        np.testing.assert_allclose(got, [moment[0], moment[1], moment[2], force[0]], rtol=1e-12)

    @pytest.mark.parametrize(
        ("change", "word"),
        [
            ({"hub_radius": -1.0}, "hub_radius"),
            ({"hub_radius": 0.0}, "hub_radius"),
            ({"blades": 0}, "blades"),
            ({"tilt": 2.0}, "tilt"),
            ({"hub_height": 0.0}, "hub_height"),
            ({"overhang": np.nan}, "overhang"),
        ],
    )
    def test_bad_input(self, change: dict[str, object], word: str) -> None:
        values: dict[str, object] = {"blade": blade(), "hub_radius": 1.0, "hub_height": 90.0}
        with pytest.raises(InputError, match=word):
            Rotor(**{**values, **change})
