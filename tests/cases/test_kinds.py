"""Kinds of values: what is read, shown and refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pitchopt.cases.kinds import Choice, Count, Flag, Number, PathName, Text, Weights, scalar
from pitchopt.design.problem import LoadWeights
from pitchopt.errors import InputError

ANGLE = Number(unit="deg", factor=np.pi / 180, at_least=-180, at_most=180, word="auto")


@given(st.floats(-180.0, 180.0))
def test_numbers_survive_reading_and_showing(value):
    assert ANGLE.show(ANGLE.read("x", value)) == pytest.approx(value, rel=1e-13, abs=1e-13)


@given(st.decimals(-180, 180, places=4))
def test_what_people_write_is_shown_as_written(value):
    assert ANGLE.show(ANGLE.read("x", float(value))) == float(value)


def test_words():
    assert ANGLE.read("x", "auto") is None
    assert ANGLE.parse("x", "auto") is None
    assert ANGLE.show(None) == "auto"
    assert ANGLE.check("x", None) is None


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        (ANGLE, 181.0),
        (ANGLE, float("nan")),
        (ANGLE, float("inf")),
        (ANGLE, 10**400),
        (ANGLE, "5"),
        (ANGLE, True),
        (ANGLE, None),
        (ANGLE, [1.0]),
        (Number(above=0.0), 0.0),
        (Number(), "auto"),
        (Count(at_most=9), 0),
        (Count(at_most=9), 10),
        (Count(at_most=9), 2.0),
        (Count(at_most=9), True),
        (Flag(), 1),
        (Flag(), "true"),
        (Choice(("a", "b")), "c"),
        (Choice(("a", "b")), 1),
        (Text(), ""),
        (Text(), "two\nlines"),
        (Text(), 3),
        (PathName(), 3),
        (Weights(), "towerbase"),
        (Weights(), {}),
        (Weights(), {"torque": 0.0}),
        (Weights(), {"torque": -1.0}),
        (Weights(), {"force": 1.0}),
        (Weights(), {"torque": float("nan")}),
    ],
)
def test_refused(kind, value):
    with pytest.raises(InputError, match=r"^the\.field(\.torque)?: got .+, expected .+") as caught:
        kind.read("the.field", value)
    assert "\n" not in str(caught.value)


def test_inner_values_are_checked_in_the_unit_of_files():
    with pytest.raises(InputError, match=r"^x: got 200\.0, expected .* \[deg\] or 'auto'"):
        ANGLE.check("x", np.deg2rad(200.0))
    with pytest.raises(InputError, match=r"^x: got 'ten'"):
        ANGLE.check("x", "ten")


def test_weights_of_text_and_tables():
    text = Weights().parse("w", "torque=1, tilt=2,thrust=90")
    assert text == Weights().read("w", {"torque": 1, "tilt": 2, "thrust": 90})
    assert isinstance(text, LoadWeights)
    assert (text.yaw, text.blade, text.thrust) == (0.0, 0.0, 90.0)
    assert Weights().parse("w", "tower-base") == "tower-base"
    assert Weights().read("w", Weights().show(text)) == text


@pytest.mark.parametrize("text", ["torque=1,torque=2", "torque=1,", "torque", "torque=x"])
def test_bad_weights_of_text(text):
    with pytest.raises(InputError, match=r"^w(\.torque)?: got"):
        Weights().parse("w", text)


def test_scalars():
    assert [scalar(t) for t in ("3", "-2.5", "1e3", "true", "no", "x y")] == [
        3,
        -2.5,
        1000.0,
        True,
        False,
        "x y",
    ]
