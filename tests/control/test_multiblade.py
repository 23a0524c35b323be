"""The multiblade transform: inverses, invariances, the turn by the offset, bad input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.control import from_fixed_frame, to_fixed_frame
from pitchopt.errors import InputError

angles = st.floats(-10.0, 10.0)
parts = st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)).map(np.array)
orders = st.sampled_from([1, 2, 4, 5])


@given(parts, angles, orders)
def test_inverse_then_forward_is_the_identity(part: Any, azimuth: float, n: int) -> None:
    blades = from_fixed_frame(part, azimuth, n)
    assert np.allclose(to_fixed_frame(blades, azimuth, n), part, rtol=0, atol=1e-9)
    assert abs(np.sum(blades)) < 1e-9


@given(st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3), angles, orders)
def test_forward_then_inverse_takes_off_the_mean_alone(
    values: list[float], azimuth: float, n: int
) -> None:
    blades = np.array(values)
    back = from_fixed_frame(to_fixed_frame(blades, azimuth, n), azimuth, n)
    assert np.allclose(back, blades - np.mean(blades), rtol=0, atol=1e-9)


@given(parts, angles, orders, st.floats(-3.0, 3.0))
def test_an_offset_turns_the_pair(part: Any, azimuth: float, n: int, offset: float) -> None:
    turned = to_fixed_frame(from_fixed_frame(part, azimuth, n, offset), azimuth, n)
    c, d = np.cos(n * offset), np.sin(n * offset)
    assert np.allclose(turned, np.array([[c, d], [-d, c]]) @ part, rtol=0, atol=1e-8)
    again = from_fixed_frame(part, azimuth, n, offset + 2 * np.pi / n)
    assert np.allclose(again, from_fixed_frame(part, azimuth, n, offset), rtol=0, atol=1e-8)
    half = from_fixed_frame(-part, azimuth, n, offset + np.pi / n)
    assert np.allclose(half, from_fixed_frame(part, azimuth, n, offset), rtol=0, atol=1e-8)


@pytest.mark.parametrize("n", [1, 2])
def test_signs_and_size(n: int) -> None:
    azimuth = np.linspace(0.0, 2 * np.pi, 50)
    each = azimuth[:, None] + 2 * np.pi / 3 * np.arange(3)
    up = 4.0 + 3.0 * np.cos(n * each) + 2.0 * np.sin(n * each)
    assert np.allclose(to_fixed_frame(up, azimuth, n), [3.0, 2.0])
    # blade 1 up alone: tilt positive; to the right looking downwind: yaw positive
    assert to_fixed_frame([1.0, 0.0, 0.0], 0.0)[0] > 0.0
    assert to_fixed_frame([1.0, 0.0, 0.0], np.pi / 2)[1] > 0.0


def test_a_steady_load_of_order_one_stays_out_of_order_two_but_for_the_third() -> None:
    azimuth = np.linspace(0.0, 2 * np.pi, 90, endpoint=False)
    each = azimuth[:, None] + 2 * np.pi / 3 * np.arange(3)
    seen = to_fixed_frame(np.cos(each), azimuth, 2)
    spectrum = np.abs(np.fft.rfft(seen[:, 0])) / 90
    assert np.isclose(2 * spectrum[3], 1.0) and np.sum(spectrum) - spectrum[3] < 1e-12


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: to_fixed_frame([1.0, 2.0], 0.0), r"values: got shape \(2,\)"),
        (lambda: from_fixed_frame([1.0, 2.0, 3.0], 0.0), r"parts: got shape \(3,\)"),
        (lambda: to_fixed_frame([1.0, 2.0, 3.0], 0.0, 3), "multiple of three"),
        (lambda: from_fixed_frame([1.0, 2.0], 0.0, 0), "order: got 0"),
    ],
)
def test_bad_input(call: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        call()
