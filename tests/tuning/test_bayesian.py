"""Bayesian tuner: what it finds, under noise, failures and constraints, in batches, resumed."""

from __future__ import annotations

import json

import numpy as np
import pytest

import pitchopt.tuning.gaussian_process as process_module
from pitchopt.errors import ComputationError, InputError
from pitchopt.tuning import Bayesian, Candidate, Outcome, Parameter, Polar, Space
from pitchopt.tuning.known_functions import branin, forrester, hartmann

ACQUISITIONS = [
    "log-expected-improvement",
    "expected-improvement",
    "noisy-expected-improvement",
    "probability-of-improvement",
    "confidence-bound",
    "thompson",
]
SQUARE = Space([Parameter(name="a", low=-1.0, high=1.0), Parameter(name="b", low=-1.0, high=1.0)])


def run(tuner, function, count):
    for _ in range(count):
        candidate = tuner.ask()[0]
        tuner.tell(candidate, function(candidate.x))
    return tuner


def stored(candidate):
    """A candidate as a journal gives it back."""
    text = json.dumps(
        {
            "index": candidate.index,
            "x": candidate.x.tolist(),
            "origin": candidate.origin,
            "note": dict(candidate.note),
        },
        allow_nan=False,
    )
    back = json.loads(text)
    return Candidate(**{**back, "x": np.array(back["x"])})


@pytest.mark.parametrize(
    ("acquisition", "covariance"),
    [
        *((acquisition, "squared-exponential") for acquisition in ACQUISITIONS),
        ("log-expected-improvement", "matern"),
        ("confidence-bound", "matern"),
    ],
)
def test_every_acquisition_finds_the_minimum_of_forrester(acquisition, covariance):
    tuner = Bayesian(
        forrester().space, seed=1, initial=4, acquisition=acquisition, covariance=covariance
    )
    best = run(tuner, forrester(), 20).best()
    assert best.evaluation.cost - forrester().minimum < 0.02
    assert best.cost == pytest.approx(best.evaluation.cost, abs=0.05)
    assert abs(best.x[0] - forrester().minimisers[0, 0]) < 0.01


@pytest.mark.parametrize(
    ("function", "criterion", "count", "regret"),
    [
        (branin(), "map", 30, 0.01),
        (branin(), "ml", 30, 0.01),
        (hartmann(3), "map", 30, 1e-3),
        (hartmann(4), "map", 45, 0.02),
    ],
    ids=["branin, map", "branin, ml", "hartmann3", "hartmann4"],
)
def test_minima_of_known_functions(function, criterion, count, regret):
    tuner = Bayesian(function.space, seed=2, hyperparameters=criterion)
    best = run(tuner, function, count).best()
    assert function(best.x) - function.minimum < regret
    assert {e.origin for e in tuner.evaluations} == {"design", "log-expected-improvement"}


def test_start_points_come_first_and_count_in_the_design():
    start = [[0.1, 0.2], [-0.3, 0.4]]
    tuner = Bayesian(SQUARE, start=start)
    asked = tuner.ask(6)
    np.testing.assert_array_equal([c.x for c in asked[:2]], start)
    assert [c.origin for c in asked] == ["start", "start"] + ["design"] * 4
    one = Bayesian(SQUARE, start=[0.5, 0.5], initial=3)
    np.testing.assert_array_equal(one.ask()[0].x, [0.5, 0.5])


def test_design_is_the_same_however_it_is_asked_for():
    together = Bayesian(SQUARE, seed=4, initial=20).ask(20)
    one = Bayesian(SQUARE, seed=4, initial=20)
    for candidate in together:
        np.testing.assert_array_equal(one.ask()[0].x, candidate.x)
    other = Bayesian(SQUARE, seed=5, initial=20).ask()[0]
    assert not np.array_equal(other.x, together[0].x)


@pytest.mark.slow
def test_best_under_noise_is_no_lucky_sample():
    """The point that the tuner names has a lower regret than its least sample, on average."""
    function, regrets = forrester(), []
    for seed in range(6):
        tuner = Bayesian(function.space, seed=seed, acquisition="noisy-expected-improvement")
        run(tuner, function.noisy(1.0, seed=seed), 25)
        lucky, best = min(tuner.evaluations, key=lambda e: e.cost), tuner.best()
        assert best.evaluation in tuner.evaluations
        assert best.std > 0.0
        assert abs(best.cost - function(best.x)) < 4 * best.std
        regrets.append([function(x) - function.minimum for x in (best.x, lucky.x)])
    named, least = np.mean(regrets, axis=0)
    assert named < least


def test_variances_of_replicates_are_taken_into_account():
    function = branin().noisy(5.0, seed=3, replicates=6)
    tuner = run(Bayesian(branin().space, seed=3), function, 12)
    cost = tuner.surrogates().cost
    variances = [e.variance for e in tuner.evaluations]
    np.testing.assert_allclose(cost.kriging.noise * cost.scale**2, variances)


@pytest.mark.parametrize(
    "acquisition", [name for name in ACQUISITIONS if name != "probability-of-improvement"]
)
def test_points_asked_for_together_spread(acquisition):
    tuner = run(Bayesian(branin().space, seed=0, acquisition=acquisition), branin(), 12)
    batch = np.array([branin().space.to_unit(c.x) for c in tuner.ask(5)])
    apart = np.linalg.norm(batch[:, None] - batch, axis=2) + np.eye(5)
    assert apart.min() > 1e-2
    # nothing was learned between them: one fit
    notes = [c.note["hyperparameters"] for c in tuner.pending]
    assert all(note == notes[0] for note in notes)


def test_batches_reach_the_minimum_too():
    tuner = Bayesian(branin().space, seed=1)
    for _ in range(9):
        for candidate in reversed(tuner.ask(4)):
            tuner.tell(candidate, branin()(candidate.x))
    assert branin()(tuner.best().x) - branin().minimum < 0.02


@pytest.mark.parametrize("acquisition", ACQUISITIONS)
def test_resumed_study_asks_for_the_same_points_bit_by_bit(acquisition, monkeypatch):
    """Candidates asked two at a time, told late and in another order; taken up without a fit."""
    settings = {"seed": 7, "initial": 4, "acquisition": acquisition}

    def function(x):
        if abs(x[0]) > 0.5:
            return Outcome(cost=np.nan)
        return Outcome(cost=np.sin(3 * x[0]) + x[1] ** 2, constraints=(0.2 - x[1],))

    whole = Bayesian(SQUARE, **settings)
    log: list = []
    for _ in range(6):
        log += [("asked", candidate) for candidate in whole.ask(2)]
        late = whole.pending[:2] if len(log) % 3 else whole.pending
        log += [("told", whole.tell(c, function(c.x))) for c in reversed(late)]
    assert any(e.status == "failed" for e in whole.evaluations)
    for cut in (11, len(log) - 1):
        resumed = Bayesian(SQUARE, **settings)
        with monkeypatch.context() as patch:
            patch.setattr(process_module, "fitted", None)  # any fit would fail
            for kind, what in log[:cut]:
                if kind == "asked":
                    resumed.adopt(stored(what))
                else:
                    resumed.tell(resumed._pending[what.index], what)
        for kind, what in log[cut:]:
            if kind == "asked":
                candidate = resumed.ask()[0]
                np.testing.assert_array_equal(candidate.x, what.x)
                assert dict(candidate.note) == dict(what.note)
            else:
                resumed.tell(resumed._pending[what.index], what)


def test_looking_at_the_best_changes_nothing():
    silent, watched = (Bayesian(branin().space, seed=3) for _ in range(2))
    for _ in range(14):
        one, other = silent.ask()[0], watched.ask()[0]
        np.testing.assert_array_equal(one.x, other.x)
        silent.tell(one, branin()(one.x))
        watched.tell(other, branin()(other.x))
        watched.best()


def test_candidate_of_another_study_is_refused():
    tuner = Bayesian(SQUARE, seed=0, initial=4)
    other = Bayesian(SQUARE, seed=1, initial=4).ask()[0]
    with pytest.raises(InputError, match="it comes from another study"):
        tuner.adopt(stored(other))
    run(tuner, lambda x: float(x @ x), 4)
    broken = Candidate(index=4, x=np.zeros(2), note={"hyperparameters": 3})
    with pytest.raises(InputError, match="got hyperparameters 3"):
        tuner.adopt(broken)


@pytest.mark.slow
def test_failures_are_learned_and_avoided():
    """A third of the space fails, with one of the three minima in it."""

    def function(x):
        return np.nan if x[0] < 0.0 else branin()(x)

    tuner = run(Bayesian(branin().space, seed=0), function, 36)
    searching = [e for e in tuner.evaluations if e.origin != "design"][:15]
    assert sum(e.status == "failed" for e in searching) <= 3
    assert branin()(tuner.best().x) - branin().minimum < 0.01
    assert set(tuner.surrogates().limits) == {"failure"}
    points = branin().space.to_unit(np.array([e.x for e in tuner.evaluations]))
    chance = tuner.surrogates().chance(points)
    failed = np.array([e.status == "failed" for e in tuner.evaluations])
    assert np.median(chance[failed]) < 0.05 and np.median(chance[~failed]) > 0.95


def test_minimum_at_the_edge_of_failure_is_found():
    """Forrester's minimum lies at 0.757; above 0.7 every evaluation fails."""

    def function(x):
        return np.nan if x[0] > 0.7 else forrester()(x)

    tuner = run(Bayesian(forrester().space, seed=0, initial=5), function, 25)
    assert 0.695 < tuner.best().x[0] <= 0.7


@pytest.mark.slow
def test_constraints_are_learned():
    """x + y least on a disc: -sqrt(2) r at (-r, -r) / sqrt(2)."""

    def function(x):
        return Outcome(cost=float(x.sum()), constraints=(float(x @ x) - 0.25, x[0] - x[1] - 0.8))

    tuner = run(Bayesian(SQUARE, seed=0), function, 30)
    best = tuner.best()
    assert best.evaluation.feasible
    assert best.evaluation.cost == pytest.approx(-np.sqrt(2) * 0.5, abs=5e-3)
    assert set(tuner.surrogates().limits) == {"constraint 0", "constraint 1"}


@pytest.mark.slow
@pytest.mark.parametrize("acquisition", ACQUISITIONS)
def test_every_acquisition_keeps_to_constraints(acquisition):
    def function(x):
        return Outcome(cost=float(x.sum()), constraints=(float(x @ x) - 0.25,))

    tuner = run(Bayesian(SQUARE, seed=1, acquisition=acquisition), function, 22)
    assert tuner.best().evaluation.cost < -0.6


def test_feasible_points_are_looked_for_where_none_is_known():
    """Nothing but a small disc is feasible, and the design misses it."""

    def function(x):
        away = float(np.sum((x - [0.62, -0.57]) ** 2)) - 0.1**2
        return Outcome(cost=1.0, constraints=(away,))

    tuner = Bayesian(SQUARE, seed=0, initial=5)
    run(tuner, function, 5)
    with pytest.raises(ComputationError, match="none of 5 evaluations is feasible"):
        tuner.best()
    run(tuner, function, 10)
    assert tuner.best().evaluation.feasible


def test_design_goes_on_while_everything_fails():
    tuner = run(Bayesian(SQUARE, seed=0, initial=3), lambda _: np.nan, 20)
    assert {e.origin for e in tuner.evaluations} == {"design"}
    assert len({tuple(e.x) for e in tuner.evaluations}) == 20
    with pytest.raises(ComputationError, match="none of 20 evaluations is feasible"):
        tuner.best()
    with pytest.raises(InputError, match="fewer than two points"):
        tuner.surrogates()
    run(tuner, lambda x: float(x @ x), 12)
    assert tuner.best().evaluation.cost < 1e-2


def test_constant_and_repeated_costs_do_no_harm():
    tuner = run(Bayesian(SQUARE, seed=0), lambda _: 3.0, 15)
    assert tuner.best().cost == pytest.approx(3.0)
    same = Bayesian(SQUARE, seed=0, start=np.zeros((8, 2)), initial=0)
    run(same, lambda x: float(x.sum()), 12)
    assert same.best().evaluation.cost < 0.0


def test_points_from_elsewhere_are_used():
    tuner = Bayesian(branin().space, seed=0, initial=2)
    for x in branin().space.from_unit(np.random.default_rng(0).random((30, 2))):
        tuner.tell(x, branin()(x))
    run(tuner, branin(), 8)
    assert branin()(tuner.best().x) - branin().minimum < 0.02


@pytest.mark.parametrize("centre", [0.0, 359.0, 120.0])
def test_minimum_of_a_phase_across_the_seam(centre):
    space = Space([Parameter(name="phase", low=0.0, high=360.0, periodic=True)])

    def function(x):
        return float(-np.cos(np.deg2rad(x[0] - centre)) + 0.3 * np.sin(2 * np.deg2rad(x[0])))

    dense = np.linspace(0, 360, 3601)
    least = min(function([x]) for x in dense)
    tuner = run(Bayesian(space, seed=0), function, 14)
    assert function(tuner.best().x) - least < 1e-3


def test_gain_and_offset_of_either_sign():
    """A bowl in the plane of gain cos, gain sin, around gain 1 and offset 200 of 180 + 20."""
    space = Space(
        [
            Parameter(name="gain", low=-2.0, high=2.0),
            Parameter(name="offset", low=0.0, high=360.0, periodic=True),
        ],
        polar=[Polar(radius="gain", angle="offset")],
    )

    def plane(x):
        return x[0] * np.exp(1j * np.deg2rad(x[1]))

    target = plane([1.0, 200.0])
    tuner = run(Bayesian(space, seed=0), lambda x: float(abs(plane(x) - target) ** 2), 16)
    assert abs(plane(tuner.best().x) - target) < 0.02


def test_settings_are_plain_data_and_make_the_tuner_again():
    tuner = Bayesian(SQUARE, seed=3, start=[0.5, 0.5], confidence=1.0, covariance="matern")
    settings = json.loads(json.dumps(tuner.settings()))
    assert settings.pop("method") == "bayes"
    again = Bayesian(SQUARE, **settings)
    assert again.settings() == tuner.settings()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"acquisition": "luck"}, "acquisition: got 'luck', expected one of log-expected-"),
        ({"covariance": "luck"}, "covariance: got 'luck'"),
        ({"hyperparameters": "luck"}, "hyperparameters: got 'luck', expected ml or map"),
        ({"initial": 1}, "initial: got 1 with 0 start points, expected at least two"),
        ({"confidence": -1.0}, "confidence: got -1"),
        ({"start": [0.0, 2.0]}, "x: got b = 2, expected between -1 and 1"),
        ({"start": [[0.0]]}, r"x: got shape \(1,\), expected \(2,\)"),
    ],
)
def test_bad_settings_are_named(change, message):
    with pytest.raises(InputError, match=message):
        Bayesian(SQUARE, **change)


def test_constraints_of_varying_number_are_refused():
    tuner = run(Bayesian(SQUARE, initial=2), lambda _: Outcome(cost=1.0, constraints=(0.0,)), 1)
    tuner.tell(tuner.ask()[0], 2.0)
    with pytest.raises(InputError, match=r"constraints: got \[0, 1\] at different points"):
        tuner.ask()


def test_variances_count_as_noise_unless_they_are_to_be_fitted():
    rng = np.random.default_rng(0)
    points = rng.uniform(-1.0, 1.0, (6, 2))
    variances = [0.1, None, 0.3, 0.2, None, 0.2]
    found = {}
    for noise in ("told", "fitted"):
        tuner = Bayesian(SQUARE, noise=noise)
        for x, variance in zip(points, variances, strict=True):
            tuner.tell(x, float(x @ x), variance)
        process = tuner.surrogates().cost
        found[noise] = process.kriging.noise * process.scale**2
    np.testing.assert_allclose(found["told"], [0.1, 0.2, 0.3, 0.2, 0.2, 0.2])  # the mean of told
    np.testing.assert_array_equal(found["fitted"], 0.0)
    with pytest.raises(InputError, match="noise: got 'none', expected told or fitted"):
        Bayesian(SQUARE, noise="none")
