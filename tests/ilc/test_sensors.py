"""Sensors: statistics of each imperfection, the delay across passages, going on exactly."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from ilc import LearningError, Sensors, StateError, load_state, save_state

ALL: dict[str, Any] = {
    "noise": [3.0, 1.0, 2.0, 0.5],
    "quantisation": [0.5, 0.0, 1.0, 0.25],
    "delay": 3,
    "dropout": 0.1,
    "passage_dropout": 0.05,
    "seed": 7,
}


def passages(count: int, m: int = 5) -> np.ndarray:
    """Loads that count samples, each load from its own thousand."""
    stream = np.arange(count * m) + 1000.0 * np.arange(4)[:, None]
    return stream.reshape(4, count, m).transpose(1, 0, 2)


def test_perfect_sensors_change_nothing() -> None:
    exact = passages(1)[0]
    np.testing.assert_array_equal(Sensors().read(exact), exact)


def test_noise_has_its_standard_deviation_and_no_bias() -> None:
    sigma = np.array([3.0, 1.0, 2.0, 0.0])
    count = 40_000
    error = Sensors(noise=sigma, seed=1).read(np.zeros((4, count)))
    # five standard errors of a sample's mean and standard deviation
    assert np.all(np.abs(error.mean(axis=1)) <= 5 * sigma / np.sqrt(count))
    assert np.all(np.abs(error.std(axis=1) - sigma) <= 5 * sigma / np.sqrt(2 * count))
    correlation = np.corrcoef(error[:3]) - np.eye(3)
    assert np.abs(correlation).max() < 5 / np.sqrt(count)


@pytest.mark.parametrize("share", [0.02, [0.02, 0.01, 0.0, 0.1]])
def test_share_of_given_loads(share: Any) -> None:
    of = np.array([100.0, -40.0, 20.0, 10.0])
    sensors = Sensors.with_share(share, of, delay=2, seed=3)
    np.testing.assert_allclose(sensors.noise, share * np.abs(of))
    assert (sensors.delay, sensors.seed) == (2, 3)


def test_quantisation_rounds_to_multiples_of_the_step() -> None:
    exact = np.random.default_rng(0).normal(size=(4, 300))
    step = np.array([0.5, 0.1, 0.0, 2.0])
    measured = Sensors(quantisation=step).read(exact)
    np.testing.assert_array_equal(measured[2], exact[2])
    for load in (0, 1, 3):
        ratio = measured[load] / step[load]
        np.testing.assert_allclose(ratio, np.round(ratio), atol=1e-9)
        assert np.abs(measured[load] - exact[load]).max() <= step[load] / 2 + 1e-12


@pytest.mark.parametrize("step", [5e-324, 1e-300, 1e-20])
def test_a_step_too_fine_to_show_changes_nothing(step: float) -> None:
    exact = 1e5 * np.random.default_rng(0).normal(size=(4, 30))
    np.testing.assert_array_equal(Sensors(quantisation=np.full(4, step)).read(exact), exact)


@pytest.mark.parametrize("delay", [0, 1, 4, 5])
def test_delay_runs_on_across_passages(delay: int) -> None:
    exact = passages(4)
    sensors = Sensors(delay=delay)
    measured = np.concatenate([sensors.read(loads) for loads in exact], axis=1)
    stream = np.concatenate(list(exact), axis=1)
    assert np.isnan(measured[:, :delay]).all()
    np.testing.assert_array_equal(measured[:, delay:], stream[:, : stream.shape[1] - delay])


def test_dropout_takes_samples_and_whole_passages_at_their_rates() -> None:
    count = 20_000
    lost = np.isnan(Sensors(dropout=0.1, seed=5).read(np.zeros((4, count))))
    assert np.all(np.abs(lost.mean(axis=1) - 0.1) < 5 * np.sqrt(0.09 / count))
    assert abs((lost[0] & lost[1]).mean() - 0.01) < 5 * np.sqrt(0.01 / count)  # independent
    sensors = Sensors(passage_dropout=0.25, seed=6)
    shares = np.array([np.isnan(sensors.read(np.zeros((4, 3)))).mean() for _ in range(4000)])
    assert set(shares) == {0.0, 1.0}
    assert abs(shares.mean() - 0.25) < 5 * np.sqrt(0.25 * 0.75 / 4000)


def test_noise_of_a_seed_is_the_same_with_dropout_and_without() -> None:
    exact = passages(3)
    plain, lossy = Sensors(noise=1.0, seed=2), Sensors(noise=1.0, seed=2, dropout=0.3)
    for loads in exact:
        one, other = plain.read(loads), lossy.read(loads)
        seen = np.isfinite(other)
        assert 0 < seen.sum() < seen.size
        np.testing.assert_array_equal(one[seen], other[seen])


def test_seed_repeats_and_another_differs() -> None:
    exact = passages(1)[0]
    first = Sensors(noise=1.0, seed=1).read(exact)
    np.testing.assert_array_equal(first, Sensors(noise=1.0, seed=1).read(exact))
    assert not np.array_equal(first, Sensors(noise=1.0, seed=2).read(exact))


@pytest.mark.parametrize("after", [0, 1, 4])
def test_state_goes_on_exactly(after: int, tmp_path: Any) -> None:
    exact = passages(8)
    sensors = Sensors(**ALL)
    for loads in exact[:after]:
        sensors.read(loads)
    save_state(tmp_path / "sensors.npz", sensors.state())
    expected = [sensors.read(loads) for loads in exact[after:]]
    again = Sensors(**ALL)
    again.read(exact[0])  # whatever it has read before
    again.restore(load_state(tmp_path / "sensors.npz"))
    for loads, value in zip(exact[after:], expected, strict=True):
        np.testing.assert_array_equal(again.read(loads), value)


def test_state_of_other_settings_or_damaged_is_refused_and_changes_nothing() -> None:
    exact = passages(2)
    state = Sensors(**ALL).state()
    for name, value in {"delay": 2, "seed": 8, "noise": 1.0, "dropout": 0.2}.items():
        with pytest.raises(StateError, match=name):
            Sensors(**(ALL | {name: value})).restore(state)
    broken = [
        {**state, "random": np.array("{}")},
        {**state, "random": np.array("not JSON")},
        {**state, "lagging": np.zeros((4, 2))},
        {**state, "settings": np.array(json.dumps([1, 2]))},
        {name: value for name, value in state.items() if name != "lagging"},
        {},
    ]
    for bad in broken:
        sensors = Sensors(**ALL)
        with pytest.raises(StateError):
            sensors.restore(bad)
        np.testing.assert_array_equal(sensors.read(exact[0]), Sensors(**ALL).read(exact[0]))


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("noise", -1.0),
        ("noise", [1.0, 2.0, 3.0]),
        ("noise", np.nan),
        ("noise", "much"),
        ("quantisation", [0, 0, 0, -1]),
        ("delay", -1),
        ("delay", 1.5),
        ("dropout", 1.1),
        ("passage_dropout", -0.1),
        ("seed", -1),
        ("seed", None),
    ],
)
def test_bad_values_are_named(name: str, value: Any) -> None:
    with pytest.raises(LearningError, match=name):
        Sensors(**{name: value})


@pytest.mark.parametrize("shape", [(4,), (3, 5), (4, 2), (4, 0)])
def test_loads_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(LearningError, match=r"exact.*\(4, m\).*3"):
        Sensors(delay=3).read(np.zeros(shape))
