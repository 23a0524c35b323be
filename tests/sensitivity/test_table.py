"""Estimates from values alone."""

import numpy as np
import pytest

from pitchopt.errors import InputError
from pitchopt.sensitivity import PostOptimum

DC = np.array([0.0, 0.03, 0.06, 0.1, 0.3])


def limits(c):
    return np.stack([0.5 * np.exp(-3.0 * c) - 0.5, -0.2 + c], axis=-1)


def made(**options):
    return PostOptimum.from_table(
        DC, 100.0 + 0.0 * DC, limits(DC), multipliers=[8.0, 0.0], names="damage", **options
    )


def test_paper_form_forward_step_and_high_order():
    po = made(step=0.03)
    for dc in DC:
        e = po.estimate(dc)
        assert e.high_order == pytest.approx(8.0 * 0.5 * (np.exp(-3.0 * dc) - 1.0), abs=1e-14)
        slope = 8.0 * 0.5 * (np.exp(-0.09) - 1.0) / 0.03
        assert e.first_order == pytest.approx(slope * dc, rel=1e-12)
    assert e.first_order_error is None
    assert e.reference == 100.0
    assert [k.name for k in e.largest()] == ["damage[0]"]


def test_two_shortest_steps_are_extrapolated_with_an_error():
    e = made().estimate(0.3)
    exact = -12.0 * 0.3
    assert abs(e.first_order - exact) < e.first_order_error
    assert abs(e.first_order - exact) < 0.01 * abs(exact)
    assert e.step == 0.03


def test_maximum_turns_the_sign():
    po = PostOptimum.from_table(
        DC, 100.0 + 0.0 * DC, limits(DC), multipliers=[8.0, 0.0], sense="max"
    )
    assert po.estimate(0.1).high_order == pytest.approx(-made().estimate(0.1).high_order)


def test_re_evaluated_constraint_that_becomes_violated_is_named_and_the_rest_not_judged():
    fine, broken = made().estimate(0.1), made().estimate(0.3)
    assert fine.active_set.verdict == "not judged"
    assert broken.active_set.verdict == "broken"
    assert "violated at the old design: damage[1]" in broken.active_set.message
    for e in (fine, broken):
        assert e.coupling.verdict == e.linearity.verdict == e.stationarity.verdict == "not judged"
        assert e.attained is None


def test_vector_parameter_and_equalities():
    dcs = np.array([[0.0, 0.0], [0.1, 0.0], [0.2, 0.0], [0.1, 0.1]])
    h = dcs[:, :1] + 2.0 * dcs[:, 1:]
    po = PostOptimum.from_table(dcs, np.zeros(4), None, h, equality_multipliers=[3.0], c=[1.0, 1.0])
    assert po.estimate([0.2, 0.0]).first_order == pytest.approx(0.6)
    e = po.estimate([0.1, 0.1])
    assert e.first_order == pytest.approx(e.high_order) == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: made().estimate(0.2), r"dc: got \[0\.2\], which is not in the table"),
        (lambda: made(step=0.05).estimate(0.1), r"step: 0\.05 is not in the table"),
        (
            lambda: PostOptimum.from_table([0.1, 0.2], [1.0, 1.0], [[0.0], [0.0]], multipliers=[1]),
            "dcs: got 0 that are zero, expected one",
        ),
        (
            lambda: PostOptimum.from_table(DC, DC[:3], limits(DC), multipliers=[1.0, 1.0]),
            r"f: got shape \(3,\), expected \(5,\)",
        ),
        (
            lambda: PostOptimum.from_table(DC, DC, limits(DC), multipliers=[1.0]),
            r"g: got shape \(5, 2\), expected \(5, 1\)",
        ),
        (
            lambda: PostOptimum.from_table(DC, DC, limits(DC)),
            "g: expected the values and their multipliers, or neither",
        ),
        (
            lambda: PostOptimum.from_table(DC, DC, limits(DC), multipliers=[1.0, -1.0]),
            "multipliers: number 1 is -1, expected none below zero",
        ),
        (
            lambda: PostOptimum.from_table(DC, DC * np.nan, limits(DC), multipliers=[1.0, 1.0]),
            "f: got .* expected finite numbers",
        ),
        (
            lambda: PostOptimum.from_table(
                DC, DC, limits(DC), multipliers=[1.0, 1.0], names=["one"]
            ),
            "names of g: got 1, expected 2",
        ),
    ],
)  # fmt: skip
def test_bad_tables(make, message):
    with pytest.raises(InputError, match=message):
        make()
