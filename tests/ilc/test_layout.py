"""Layout: stations, tracked positions and variables agree with the plant's convention."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ilc import Layout, LearningError
from ilc.experiment import perturbations

LAYOUTS = st.builds(
    Layout, blades=st.integers(1, 4), positions=st.integers(1, 7), separate=st.booleans()
)


@given(LAYOUTS, st.integers(0, 20))
def test_index_is_where_the_blades_stand(layout: Layout, number: int) -> None:
    m, B = layout.positions, layout.blades
    variables = np.arange(layout.variables)
    profile = layout.profile(variables)
    rows = layout.visit(number)[0]
    assert len(rows) == m
    for k, row in enumerate(rows):
        stations = [((b + number) % B) * m + k for b in range(B)]
        here = layout.index[row]
        if layout.separate:
            np.testing.assert_array_equal(here, [profile[b, s] for b, s in enumerate(stations)])
        else:  # the blades are alike: which of them stands where does not matter
            assert set(here) == {profile[s] for s in stations}


@given(LAYOUTS)
def test_each_variable_is_met_once_in_a_dwell(layout: Layout) -> None:
    met = [layout.index[layout.visit(number)[0]] for number in range(layout.dwell)]
    np.testing.assert_array_equal(np.sort(np.concatenate(met), axis=None), range(layout.variables))
    np.testing.assert_array_equal(layout.visit(layout.dwell)[0], layout.visit(0)[0])


@given(LAYOUTS, st.integers(0, 9))
def test_entries_follow_the_stations_of_the_passage_before(layout: Layout, number: int) -> None:
    profile = layout.profile(np.arange(layout.variables))
    before = layout.index[layout.visit(number)[0]][-1]
    following = layout.ahead[before]
    assert set(following) == set(layout.visit(number + 1)[1][0])
    if layout.separate:  # each blade goes on along its own profile
        np.testing.assert_array_equal(following, layout.visit(number + 1)[1][0])
    assert profile.shape == (
        (layout.blades, layout.stations) if layout.separate else (layout.stations,)
    )


@given(LAYOUTS)
def test_azimuth_and_neighbours(layout: Layout) -> None:
    turn = layout.profile(layout.azimuth)
    expected = 2 * np.pi * np.arange(layout.stations) / layout.stations
    np.testing.assert_allclose(turn, np.broadcast_to(expected, turn.shape), atol=1e-15)
    ahead = layout.profile(layout.azimuth[layout.ahead])
    np.testing.assert_array_equal(ahead, np.roll(turn, -1, axis=-1))


@given(LAYOUTS)
def test_values_and_profile_are_inverse(layout: Layout) -> None:
    variables = np.random.default_rng(0).normal(size=layout.variables)
    np.testing.assert_array_equal(layout.values(layout.profile(variables)), variables)
    constant = layout.values(0.1)
    np.testing.assert_array_equal(constant, np.full(layout.variables, 0.1))
    common = np.arange(layout.stations, dtype=float)
    given_back = layout.profile(layout.values(common))
    np.testing.assert_array_equal(given_back, np.broadcast_to(common, given_back.shape))


def test_values_are_copies() -> None:
    layout = Layout(blades=3, positions=2)
    profile = np.zeros(6)
    layout.values(profile)[0] = 1.0
    variables = np.zeros(6)
    layout.profile(variables)[0] = 1.0
    assert not profile.any()
    assert not variables.any()


@pytest.mark.parametrize("shape", [(5,), (3, 6), (2, 6), (1, 1)])
def test_other_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(LearningError, match=r"profile: got shape .* expected a number or \(6,\)"):
        Layout(blades=3, positions=2).values(np.zeros(shape))


def test_bad_profiles_and_numbers_are_refused() -> None:
    layout = Layout(blades=3, positions=2, separate=True)
    with pytest.raises(LearningError, match=r"\(3, 6\)"):
        layout.values(np.zeros((2, 6)))
    with pytest.raises(LearningError, match="NaN"):
        layout.values(np.full(6, np.nan))
    with pytest.raises(LearningError, match="profile"):
        layout.values("steep")
    with pytest.raises(LearningError, match="blades"):
        Layout(blades=0, positions=2)
    with pytest.raises(LearningError, match="positions"):
        Layout(blades=3, positions=2.5)  # type: ignore[arg-type]


@given(LAYOUTS)
def test_experiment_moves_the_blades_in_all_directions_at_each_position(layout: Layout) -> None:
    offsets = perturbations(layout, 0.01)
    assert len(offsets) * layout.dwell % layout.blades == 0
    assert not offsets[:2].any()
    assert np.abs(offsets).max() == pytest.approx(0.01, rel=1e-12)
    for q in range(layout.tracked):
        pitch = offsets[:, layout.index[q]]
        np.testing.assert_allclose(pitch.sum(axis=0), 0, atol=1e-15)
        assert np.linalg.svd(pitch, compute_uv=False).min() > 0.01
