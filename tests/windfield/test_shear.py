"""Vertical shear laws against their formulas and each other."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from windfield import CubicShear, LogLaw, PowerLaw, VerticalShear, WindFieldError

LAWS = [PowerLaw(exponent=0.2), LogLaw(roughness_length=0.03), CubicShear(exponent=0.2)]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
class TestEveryLaw:
    def test_one_at_the_hub(self, law: VerticalShear) -> None:
        assert law.factor(80.0, 80.0) == pytest.approx(1.0, abs=1e-15)

    @pytest.mark.parametrize("shape", [(), (0,), (3,), (2, 1, 4)])
    def test_keeps_the_shape(self, law: VerticalShear, shape: tuple[int, ...]) -> None:
        assert law.factor(np.full(shape, 50.0), 80.0).shape == shape

    def test_grows_with_height(self, law: VerticalShear) -> None:
        assert (np.diff(law.factor(np.linspace(20.0, 140.0, 50), 80.0)) > 0.0).all()

    def test_depends_on_relative_height_or_roughness(self, law: VerticalShear) -> None:
        if isinstance(law, LogLaw):
            scaled: VerticalShear = LogLaw(roughness_length=2.0 * law.roughness_length)
        else:
            scaled = law
        np.testing.assert_allclose(
            scaled.factor([60.0, 240.0], 160.0), law.factor([30.0, 120.0], 80.0), rtol=1e-13
        )

    def test_refuses_heights_below_ground(self, law: VerticalShear) -> None:
        with pytest.raises(WindFieldError, match=r"height: got -3 m, below ground"):
            law.factor([10.0, -3.0], 80.0)

    def test_refuses_nan_and_bad_hub(self, law: VerticalShear) -> None:
        with pytest.raises(WindFieldError, match="height: got 1 NaN"):
            law.factor([10.0, math.nan], 80.0)
        with pytest.raises(WindFieldError, match="hub_height"):
            law.factor(10.0, 0.0)


def test_power_law_values() -> None:
    law = PowerLaw(exponent=0.2)
    assert law.factor(40.0, 80.0) == pytest.approx(0.5**0.2, rel=1e-15)
    assert law.factor(0.0, 80.0) == 0.0
    np.testing.assert_array_equal(PowerLaw(exponent=0.0).factor([0.0, 40.0, 99.0], 80.0), 1.0)


def test_log_law_values() -> None:
    law = LogLaw(roughness_length=0.05)
    assert law.factor(10.0, 80.0) == pytest.approx(math.log(200.0) / math.log(1600.0), rel=1e-14)
    np.testing.assert_array_equal(law.factor([0.0, 0.01, 0.05], 80.0), 0.0)
    # friction velocity: slope over ln(z) is the same everywhere
    heights = np.geomspace(1.0, 200.0, 20)
    slope = np.diff(law.factor(heights, 80.0)) / np.diff(np.log(heights))
    np.testing.assert_allclose(slope, 1.0 / math.log(1600.0), rtol=1e-11)


@pytest.mark.parametrize("exponent", [-0.1, 0.0, 0.14, 0.2, 1.0, 2.0, 3.0, 0.5])
def test_cubic_matches_power_law_to_fourth_order(exponent: float) -> None:
    cubic, power = CubicShear(exponent=exponent), PowerLaw(exponent=exponent)
    relative = np.array([0.16, 0.08, 0.04, 0.02])
    for sign in (1.0, -1.0):
        height = 80.0 * (1.0 + sign * relative)
        error = power.factor(height, 80.0) - cubic.factor(height, 80.0)
        fourth = exponent * (exponent - 1.0) * (exponent - 2.0) * (exponent - 3.0) / 24.0
        if fourth == 0.0:  # the law is a polynomial of degree three or less
            np.testing.assert_allclose(error, 0.0, atol=1e-14)
        else:
            order = np.log2(error[:-1] / error[1:])
            np.testing.assert_allclose(order, 4.0, atol=0.2)
            assert error[-1] == pytest.approx(fourth * relative[-1] ** 4, rel=0.05)


def test_cubic_is_not_the_printed_one() -> None:
    # with the printed 1/2 instead of 1/6 the third term would be three times as large
    xi, s = 0.2, -0.5
    printed = 1.0 + xi * s + xi * (xi - 1) / 2 * s**2 + xi * (xi - 1) * (xi - 2) / 2 * s**3
    ours = CubicShear(exponent=xi).factor(40.0, 80.0)
    assert 0.003 < abs(ours - 0.5**xi) < 0.004
    assert abs(printed - 0.5**xi) > 0.008
    assert ours == pytest.approx(0.874, abs=1e-12)


@given(st.floats(0.0, 1.0), st.floats(0.1, 300.0), st.floats(0.1, 300.0), st.floats(1.0, 200.0))
def test_power_law_is_multiplicative(xi: float, a: float, b: float, hub: float) -> None:
    law = PowerLaw(exponent=xi)
    assert law.factor(a, hub) / law.factor(b, hub) == pytest.approx(
        float(law.factor(a, b)), rel=1e-10
    )


@pytest.mark.parametrize("value", [math.nan, math.inf, "0.2", None, [0.1, 0.2], 1j])
def test_bad_exponent(value: object) -> None:
    for law in (PowerLaw, CubicShear):
        with pytest.raises(WindFieldError, match=r"exponent: got .*; must be a finite number"):
            law(exponent=value)


@pytest.mark.parametrize("value", [0.0, -0.1, math.nan])
def test_bad_roughness(value: float) -> None:
    with pytest.raises(WindFieldError, match=r"roughness_length: got .*> 0 \[m\]"):
        LogLaw(roughness_length=value)


def test_hub_below_roughness() -> None:
    with pytest.raises(WindFieldError, match="must be below hub_height = 2 m"):
        LogLaw(roughness_length=2.5).factor(3.0, 2.0)


def test_negative_exponent_has_no_value_at_the_ground() -> None:
    law = PowerLaw(exponent=-0.1)
    assert law.factor(40.0, 80.0) == pytest.approx(2.0**0.1)
    with pytest.raises(WindFieldError, match="infinite at the ground"):
        law.factor([0.0, 40.0], 80.0)


def test_laws_are_values() -> None:
    assert PowerLaw(exponent=0.2) == PowerLaw(exponent=0.2) != PowerLaw(exponent=0.1)
    assert len({PowerLaw(exponent=0.2), PowerLaw(exponent=0.2), CubicShear(exponent=0.2)}) == 2
    with pytest.raises(AttributeError):
        PowerLaw(exponent=0.2).exponent = 0.3
