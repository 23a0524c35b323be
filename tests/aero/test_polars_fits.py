"""Polars and their concave and convex fits."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.aero import Polar, blend, fit_polar
from pitchopt.errors import InputError

DEG = float(np.pi / 180.0)


def thin_airfoil(stall: float = 12.0) -> Polar:
    """Lift 2 pi (alpha + 4 deg) to the stall angle and falling beyond."""
    alpha = np.deg2rad(np.arange(-20.0, 25.0, 1.0))
    slope = np.where(alpha <= stall * DEG, 2 * np.pi, -3.0)
    cl = np.concatenate([[0.0], np.cumsum(slope[1:] * np.diff(alpha))])
    cl -= np.interp(-4.0 * DEG, alpha, cl)
    return Polar(name="thin", alpha=alpha, cl=cl, cd=0.01 + 0.5 * alpha**2)


class TestPolar:
    def test_interpolates_and_holds_its_ends(self) -> None:
        polar = Polar(alpha=[0.0, 1.0, 3.0], cl=[0.0, 2.0, 0.0], cd=[1.0, 1.0, 2.0])
        cl, cd, cm = polar.coefficients([[-1.0, 0.5], [2.0, 9.0]])
        assert cl.tolist() == [[0.0, 1.0], [1.0, 0.0]]
        assert cd.tolist() == [[1.0, 1.0], [1.5, 2.0]]
        assert not cm.any()

    def test_stall_and_zero_lift_angle(self, outboard: Polar) -> None:
        assert thin_airfoil().stall_angle() == pytest.approx(12.0 * DEG)
        assert thin_airfoil().zero_lift_angle() == pytest.approx(-4.0 * DEG)
        # the table of the NACA 64-618 has its first maximum, 1.453, in the row of 13.5 degrees
        assert outboard.stall_angle() == pytest.approx(13.5 * DEG)
        assert outboard.zero_lift_angle() == pytest.approx(-(4.0 - 0.017 / 0.105) * DEG)

    def test_cylinder_has_no_attached_range(self) -> None:
        cylinder = Polar(name="cylinder", alpha=[-np.pi, np.pi], cl=[0.0, 0.0], cd=[0.5, 0.5])
        assert not cylinder.lifting
        with pytest.raises(InputError, match="cylinder"):
            cylinder.stall_angle()

    def test_small_wiggles_are_not_stall(self, nrel) -> None:
        du40 = nrel.blade.polars[4]
        assert du40.stall_angle() > 20.0 * DEG

    def test_blend(self) -> None:
        one, two = thin_airfoil(), thin_airfoil(9.0)
        half = blend(one, two, 0.5)
        x = np.linspace(-0.3, 0.4, 57)
        expected = [
            (a + b) / 2 for a, b in zip(one.coefficients(x), two.coefficients(x), strict=True)
        ]
        for got, want in zip(half.coefficients(x), expected, strict=True):
            np.testing.assert_allclose(got, want, atol=1e-14)
        assert blend(one, two, 0.0) is one
        assert blend(one, two, 1.0) is two

    @pytest.mark.parametrize(
        ("change", "word"),
        [
            ({"alpha": [0.0, 0.0, 1.0]}, "alpha"),
            ({"cl": [0.0, 1.0]}, "cl"),
            ({"cd": [0.0, np.nan, 1.0]}, "cd"),
            ({"cm": "text"}, "cm"),
        ],
    )
    def test_bad_tables(self, change: dict[str, object], word: str) -> None:
        good: dict[str, object] = {"alpha": [0.0, 1.0, 2.0], "cl": [0, 1, 0], "cd": [0, 0, 1]}
        with pytest.raises(InputError, match=word):
            Polar(**{**good, **change})

    def test_is_immutable(self, outboard: Polar) -> None:
        with pytest.raises(ValueError, match="read-only"):
            outboard.cl[0] = 1.0


class TestFit:
    @pytest.mark.parametrize("segments", [1, 2, 7, 40])
    def test_shape(self, outboard: Polar, segments: int) -> None:
        fit = fit_polar(outboard, (-5.0 * DEG, outboard.stall_angle()), segments)
        assert fit.alpha.size == segments + 1
        assert fit.limits == (-5.0 * DEG, outboard.stall_angle())
        if segments > 1:
            assert np.diff(fit.cl, 2).max() <= 1e-14
            assert np.diff(fit.cd, 2).min() >= -1e-14

    @pytest.mark.parametrize("segments", [3, 13, 40])
    def test_reported_error_is_exact(self, outboard: Polar, segments: int) -> None:
        fit = fit_polar(outboard, (-6.3 * DEG, 12.9 * DEG), segments)
        x = np.linspace(*fit.limits, 200_001)
        points = np.union1d(fit.alpha, outboard.alpha[np.abs(outboard.alpha) < 0.3])
        points = points[(points >= x[0]) & (points <= x[-1])]
        for index, error in ((0, fit.cl_error), (1, fit.cd_error), (2, fit.cm_error)):
            dense = np.abs(fit.coefficients(x)[index] - outboard.coefficients(x)[index]).max()
            exact = np.abs(
                fit.coefficients(points)[index] - outboard.coefficients(points)[index]
            ).max()
            assert dense <= error + 1e-12
            assert exact == pytest.approx(error, rel=1e-9)

    def test_concave_polar_is_reproduced(self) -> None:
        alpha = np.linspace(-0.1, 0.2, 31)
        polar = Polar(alpha=alpha, cl=1.0 - (alpha - 0.2) ** 2, cd=alpha**2)
        fit = fit_polar(polar, (-0.1, 0.2), 30)
        assert max(fit.cl_error, fit.cd_error) < 1e-8

    def test_error_meets_the_lower_bound(self) -> None:
        """A kink upwards of height h needs a largest error of h / 2 with any concave fit."""
        polar = Polar(alpha=[-0.2, 0.0, 0.2], cl=[0.0, 0.1, 0.6], cd=[0.1, 0.1, 0.1])
        gap = 0.3 - 0.1
        fit = fit_polar(polar, (-0.2, 0.2), 20)
        assert fit.cl_error >= gap / 2 - 1e-9
        assert fit.cl_error <= 1.051 * gap / 2
        low, high = -0.2, 0.2
        assert polar.coefficients([low, high])[0].tolist() == [0.0, 0.6]

    def test_not_an_envelope(self, outboard: Polar) -> None:
        fit = fit_polar(outboard, (-10.0 * DEG, outboard.stall_angle()), 40)
        x = np.linspace(*fit.limits, 2001)
        deviation = fit.coefficients(x)[0] - outboard.coefficients(x)[0]
        assert deviation.min() < -0.8 * fit.cl_error
        assert deviation.max() > 0.8 * fit.cl_error

    def test_more_segments_do_not_hurt(self, outboard: Polar) -> None:
        limits = (-5.0 * DEG, 13.5 * DEG)
        errors = [fit_polar(outboard, limits, d).cl_error for d in (5, 10, 20, 40)]
        assert all(b <= 1.06 * a for a, b in pairwise(errors))
        assert errors[-1] < 0.006

    @given(
        st.lists(st.floats(-0.05, 0.05), min_size=12, max_size=12),
        st.integers(1, 25),
    )
    def test_random_polars(self, noise: list[float], segments: int) -> None:
        alpha = np.linspace(-0.15, 0.25, 12)
        bumps = np.array(noise)
        polar = Polar(alpha=alpha, cl=5 * alpha - 6 * alpha**2 + bumps, cd=0.01 + alpha**2 + bumps)
        fit = fit_polar(polar, (-0.12, 0.21), segments)
        if segments > 1:
            assert np.diff(fit.cl, 2).max() <= 1e-13
            assert np.diff(fit.cd, 2).min() >= -1e-13
        x = np.linspace(*fit.limits, 997)
        for k, error in enumerate((fit.cl_error, fit.cd_error)):
            found = np.abs(fit.coefficients(x)[k] - polar.coefficients(x)[k]).max()
            assert found <= error + 1e-9

    @pytest.mark.parametrize(
        ("limits", "segments", "word"),
        [
            ((0.2, 0.1), 5, "alpha_limits"),
            ((-9.0, 0.1), 5, "covers"),
            ((0.0, 0.1), 0, "segments"),
            ((np.nan, 0.1), 3, "alpha_limits"),
        ],
    )
    def test_bad_input(
        self, outboard: Polar, limits: tuple[float, float], segments: int, word: str
    ) -> None:
        with pytest.raises(InputError, match=word):
            fit_polar(outboard, limits, segments)

    def test_concave_range_keeps_its_promise(self, nrel) -> None:
        for polar in {id(p): p for p in nrel.blade.polars if p.lifting}.values():
            fit = fit_polar(polar, polar.concave_range(), 60)
            # 0.01 for freely placed knots; uniform ones and the tie-break add a little
            assert fit.cl_error < 0.0125
            assert fit.cd_error < 0.0025
