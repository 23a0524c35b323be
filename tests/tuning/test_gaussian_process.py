"""Gaussian process against scikit-learn, closed forms, brute force and finite differences."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.gaussian_process import GaussianProcessRegressor, kernels

from pitchopt.errors import ComputationError, InputError
from pitchopt.tuning import GaussianProcess, Parameter, Polar, Space
from pitchopt.tuning.covariance import Hyperparameters, covariance_named
from pitchopt.tuning.known_functions import branin, forrester, hartmann
from pitchopt.tuning.kriging import Kriging, factorised
from pitchopt.tuning.likelihood import Likelihood, fitted, log_prior

NAMES = ["squared-exponential", "matern"]
MIXED = Space(
    [
        Parameter(name="plain", low=0.0, high=2.0),
        Parameter(name="log", low=0.1, high=10.0, scale="log"),
        Parameter(name="gain", low=-1.0, high=2.0),
        Parameter(name="offset", low=0.0, high=90.0, periodic=True),
        Parameter(name="phase", low=-1.0, high=1.0, periodic=True),
    ],
    polar=[Polar(radius="gain", angle="offset")],
)
HYPER = Hyperparameters(lengths=[0.5, 0.8, 0.4, 0.6], variance=1.7, nugget=0.02)
CUBE = Space([Parameter(name=name, low=0.0, high=1.0) for name in "abc"])


def mixed_data(count=30, seed=0):
    rng = np.random.default_rng(seed)
    u = rng.random((count, len(MIXED)))
    f = MIXED.features(u)
    y = np.sin(3 * f[:, 0]) + f[:, 1] ** 2 + f @ rng.random(f.shape[1])
    return MIXED.from_unit(u), 100.0 + 5.0 * (y + 0.1 * rng.standard_normal(count))


def peer(name, hyper, noise):
    shape = (
        kernels.RBF(hyper.lengths)
        if name == "squared-exponential"
        else kernels.Matern(hyper.lengths, nu=2.5)
    )
    # nugget as a kernel, the samples' own variances as alpha
    kernel = kernels.ConstantKernel(hyper.variance) * shape
    kernel += kernels.WhiteKernel(hyper.variance * hyper.nugget)
    return GaussianProcessRegressor(kernel, alpha=noise, optimizer=None), kernel


@pytest.mark.parametrize("name", NAMES)
def test_mean_and_deviation_are_those_of_scikit_learn(name):
    rng = np.random.default_rng(4)
    hyper = Hyperparameters(lengths=[0.3, 0.7, 1.4], variance=1.3, nugget=0.05)
    x, y = rng.random((25, 3)), 3.0 + 2.0 * rng.standard_normal(25)
    noise = rng.random(25)
    ours = GaussianProcess(CUBE, x, y, noise_variance=noise, covariance=name, hyperparameters=hyper)
    # a constant of very large variance is one that nothing is known of beforehand
    regressor, kernel = peer(name, hyper, noise / ours.scale**2)
    vague = 1e6
    regressor.kernel = kernel + type(kernel.k1.k1)(vague)
    regressor.fit(x, (y - ours.shift) / ours.scale)
    points = rng.random((40, 3))
    mean, std = regressor.predict(points, return_std=True)
    own_mean, own_std = ours.predict(points)
    np.testing.assert_allclose(own_mean, ours.shift + ours.scale * mean, rtol=0, atol=1e-5)
    white = hyper.variance * hyper.nugget  # theirs is of a further sample
    np.testing.assert_allclose((own_std / ours.scale) ** 2, std**2 - white, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_likelihood_and_gradient_are_those_of_scikit_learn(name):
    rng = np.random.default_rng(5)
    hyper = Hyperparameters(lengths=[0.3, 0.7, 1.4], variance=1.3, nugget=0.05)
    x, y, noise = rng.random((25, 3)), rng.standard_normal(25), 0.2 * rng.random(25)
    theta = np.log([*hyper.lengths, hyper.variance, hyper.nugget])
    ours = Likelihood(covariance_named(name), x, CUBE.groups, y, noise)(theta)
    constant = Kriging(CUBE, covariance_named(name), hyper, x, noise).weights(y)[0]
    regressor, kernel = peer(name, hyper, noise)
    regressor.fit(x, y - constant)
    value, gradient = regressor.log_marginal_likelihood(kernel.theta, eval_gradient=True)
    assert ours.value == pytest.approx(value, rel=1e-12)
    # theirs in log (variance, lengths, white), white = variance nugget
    of_variance, lengths, of_white = gradient[0], gradient[1:4], gradient[4]
    expected = [*lengths, of_variance + of_white, of_white]
    np.testing.assert_allclose(ours.gradient, expected, rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_likelihood_gradient_by_differences(name):
    x, y = mixed_data()
    f = MIXED.features(MIXED.to_unit(x))
    likelihood = Likelihood(
        covariance_named(name), f, MIXED.groups, (y - y.mean()) / y.std(), np.full(len(y), 0.01)
    )
    theta = np.log([*HYPER.lengths, HYPER.variance, HYPER.nugget])
    for function in (likelihood, log_prior):
        slopes = [
            (function(theta + step).value - function(theta - step).value) / 2e-5
            for step in 1e-5 * np.eye(len(theta))
        ]
        np.testing.assert_allclose(function(theta).gradient, slopes, rtol=1e-6, atol=1e-7)


def test_priors_are_the_stated_densities():
    # in the length: log-normal, mu = sqrt(2) + log(3) / 2, sigma = sqrt(3)
    mu, sigma = np.sqrt(2) + np.log(3) / 2, np.sqrt(3)

    def log_normal(length):
        return -((np.log(length) - mu) ** 2) / (2 * sigma**2) - np.log(length)

    base = np.log([0.3, 0.3, 0.3, 1.0, 1e-4])
    for length in (0.05, 0.2, 2.0, 9.0):
        other = base.copy()
        other[1] = np.log(length)
        difference = log_prior(other).value - log_prior(base).value
        assert difference == pytest.approx(log_normal(length) - log_normal(0.3))
    wide = base + np.array([0, 0, 0, 1.5, 0])
    assert log_prior(wide).value - log_prior(base).value == pytest.approx(-0.5)
    noisy = base + np.array([0, 0, 0, 0, 4.0])
    assert log_prior(noisy).value - log_prior(base).value == pytest.approx(-0.5)


@pytest.mark.parametrize("name", NAMES)
def test_spectral_density_belongs_to_the_covariance(name):
    covariance = covariance_named(name)
    waves = covariance.frequencies(200_000, 2, np.random.default_rng(0))
    for distance in (0.3, 1.0, 2.0):
        lag = distance * np.array([0.6, 0.8])
        estimate = np.cos(waves @ lag).mean()
        assert covariance.value(np.array(distance**2)) == pytest.approx(estimate, abs=5e-3)


@pytest.mark.parametrize("name", NAMES)
def test_slope_of_the_covariance(name):
    covariance = covariance_named(name)
    q = np.array([1e-4, 0.1, 1.0, 7.0])
    change = covariance.value(q * (1 + 1e-6)) - covariance.value(q * (1 - 1e-6))
    np.testing.assert_allclose(covariance.slope(q), change / (2e-6 * q), rtol=1e-4)
    assert np.isfinite(covariance.slope(np.zeros(1))).all()


def test_equations_of_ordinary_kriging_written_out():
    """Equations (13) to (20) of Zalkind et al., with inverses, nu = sqrt(2) l and no noise."""
    space = Space([Parameter(name="a", low=-1.0, high=3.0), Parameter(name="b", low=0.0, high=5.0)])
    rng = np.random.default_rng(7)
    x, y = space.from_unit(rng.random((9, 2))), rng.standard_normal(9)
    nu = np.array([1.5, 2.0])
    correlation = np.exp(-((np.abs(x[:, None] - x) / nu) ** 2).sum(axis=2))
    inverse, ones = np.linalg.inv(correlation), np.ones(9)
    beta = (ones @ inverse @ y) / (ones @ inverse @ ones)
    process = (y - beta) @ inverse @ (y - beta) / 9
    lengths = nu / np.sqrt(2) / (space.upper - space.lower)
    hyper = Hyperparameters(lengths=lengths, variance=process / y.var(), nugget=0.0)
    ours = GaussianProcess(space, x, y, hyperparameters=hyper)
    assert ours.mean == pytest.approx(beta, rel=1e-9)
    assert ours.process_std == pytest.approx(np.sqrt(process))
    bordered = np.linalg.inv(
        np.block([[np.zeros((1, 1)), ones[None]], [ones[:, None], correlation]])
    )
    for z in space.from_unit(rng.random((10, 2))):
        psi = np.exp(-((np.abs(z - x) / nu) ** 2).sum(axis=1))
        mean, std = ours.predict(z)
        assert mean == pytest.approx(beta + psi @ inverse @ (y - beta), abs=1e-8)
        vector = np.array([1.0, *psi])
        error = process * (1 - vector @ bordered @ vector)
        assert std**2 == pytest.approx(error, rel=1e-6, abs=1e-10)
    mean, std = ours.predict(x)
    np.testing.assert_allclose(mean, y, atol=1e-7)
    assert std.max() < 1e-4


def test_likelihood_alone_ends_at_the_process_variance_of_equation_20():
    x = forrester().space.from_unit(np.linspace(0, 1, 9)[:, None])
    y = forrester().formula(x)
    ours = GaussianProcess.fit(forrester().space, x, y, criterion="ml")
    kriging = ours.kriging
    hyper = ours.hyperparameters
    residual = ours.y - ours.constant
    estimate = residual @ kriging.inverse @ residual * hyper.variance / len(y)
    assert hyper.variance == pytest.approx(estimate, rel=1e-2)


@pytest.mark.parametrize("name", NAMES)
def test_leave_one_out_by_brute_force(name):
    x, y = mixed_data(12)
    noise = np.linspace(0.1, 2.0, 12)
    whole = GaussianProcess(
        MIXED, x, y, noise_variance=noise, covariance=name, hyperparameters=HYPER
    )
    errors, deviations = whole.leave_one_out()
    for left in range(12):
        rest = np.arange(12) != left
        part = y[rest]
        # the same scale of outputs as in the whole
        factor = (whole.scale / part.std()) ** 2
        hyper = Hyperparameters(
            lengths=HYPER.lengths, variance=HYPER.variance * factor, nugget=HYPER.nugget
        )
        process = GaussianProcess(
            MIXED, x[rest], part, noise_variance=noise[rest], covariance=name, hyperparameters=hyper
        )
        mean, std = process.predict(x[left])
        assert errors[left] == pytest.approx(y[left] - mean, rel=1e-9, abs=1e-9)
        sample = std**2 + process.nugget_std**2 + noise[left]
        assert deviations[left] ** 2 == pytest.approx(sample, rel=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_slopes_and_curvature_by_differences(name):
    x, y = mixed_data()
    process = GaussianProcess(MIXED, x, y, covariance=name, hyperparameters=HYPER)
    rng = np.random.default_rng(11)
    u = rng.random((5, 5))
    mean, std, of_mean, of_std = process.moments_with_gradients(u)
    for place, step in enumerate(1e-6 * np.eye(5)):
        above, below = process.moments(u + step), process.moments(u - step)
        np.testing.assert_allclose(of_mean[:, place], (above[0] - below[0]) / 2e-6, atol=1e-7)
        np.testing.assert_allclose(of_std[:, place], (above[1] - below[1]) / 2e-6, atol=1e-7)
    np.testing.assert_allclose(process.moments(u), (mean, std))
    point = MIXED.from_unit(0.1 + 0.8 * u[0])
    gradient, curvature = process.gradient(point), process.curvature(point)
    for place, step in enumerate(2e-4 * np.diag(MIXED.upper - MIXED.lower)):
        h = step[place]
        here, above, below = (process.predict(point + move)[0] for move in (0, step, -step))
        scale = process.scale / (MIXED.upper - MIXED.lower)[place]
        assert gradient[place] == pytest.approx((above - below) / (2 * h), abs=1e-4 * scale)
        second = (above - 2 * here + below) / h**2
        assert curvature[place] == pytest.approx(second, rel=1e-2, abs=1e-2 * scale / h * 1e-3)


def test_curvature_of_a_parabola_is_its_own():
    space = Space(
        [Parameter(name="a", low=-2.0, high=4.0), Parameter(name="b", low=0.0, high=10.0)]
    )
    grid = np.stack(np.meshgrid(np.linspace(-2, 4, 7), np.linspace(0, 10, 7)), -1).reshape(-1, 2)
    y = 3.0 * (grid[:, 0] - 1.0) ** 2 + 0.5 * (grid[:, 1] - 4.0) ** 2 + 7.0
    process = GaussianProcess.fit(space, grid, y)
    np.testing.assert_allclose(process.curvature([1.0, 4.0]), [6.0, 1.0], rtol=0.02)
    lowest = process.minimum()
    np.testing.assert_allclose(lowest.x, [1.0, 4.0], atol=0.02)
    assert lowest.mean == pytest.approx(7.0, abs=0.05)


@pytest.mark.parametrize("function", [branin(), hartmann(3)], ids=lambda f: f.name)
def test_minimum_is_the_least_mean_there_is(function):
    rng = np.random.default_rng(1)
    x = function.space.from_unit(rng.random((40, len(function.space))))
    process = GaussianProcess.fit(function.space, x, function.formula(x))
    lowest = process.minimum(seed=3)
    means, _ = process.predict(function.space.from_unit(rng.random((20_000, len(function.space)))))
    assert lowest.mean <= means.min() + 1e-9
    mean, std = process.predict(lowest.x)
    assert (lowest.mean, lowest.std) == (pytest.approx(mean), pytest.approx(std))


@pytest.mark.parametrize("name", NAMES)
def test_two_descriptions_of_one_controller_are_one_point(name):
    x, y = mixed_data()
    process = GaussianProcess.fit(MIXED, x, y, covariance=name)
    symmetric = Space(
        [Parameter(name="gain", low=-2.0, high=2.0), MIXED.parameters[3]],
        polar=[Polar(radius="gain", angle="offset")],
    )
    rng = np.random.default_rng(2)
    points = symmetric.from_unit(rng.random((20, 2)))
    pair = GaussianProcess.fit(symmetric, points, rng.standard_normal(20), covariance=name)
    for gain in (0.3, 1.7):
        one, other = pair.predict([gain, 10.0]), pair.predict([-gain, 55.0])
        np.testing.assert_allclose(one, other, rtol=1e-9)
        assert abs(one[0] - pair.predict([gain, 55.0])[0]) > 1e-6
    np.testing.assert_allclose(pair.predict([0.0, 10.0]), pair.predict([0.0, 71.0]), rtol=1e-9)
    turn = np.array([0, 0, 0, 90.0, 2.0])
    here = np.array([1.0, 1.0, 0.5, 20.0, 0.3])
    np.testing.assert_allclose(process.predict(here), process.predict(here - turn), rtol=1e-9)
    ends = np.array([[1, 1, 0.5, 20.0, -1.0], [1, 1, 0.5, 20.0, 1.0]])
    mean, _ = process.predict(ends)
    assert mean[0] == pytest.approx(mean[1], rel=1e-9)


@settings(max_examples=15)
@given(
    shift=st.floats(-1e6, 1e6),
    scale=st.floats(1e-3, 1e6),
    seed=st.integers(0, 1000),
)
def test_units_of_the_outputs_do_not_matter(shift, scale, seed):
    rng = np.random.default_rng(seed)
    x, y = rng.random((10, 3)), rng.standard_normal(10)
    noise = rng.random(10)
    points = rng.random((5, 3))
    one = GaussianProcess(
        CUBE, x, y, noise_variance=noise, hyperparameters=Hyperparameters(
            lengths=[0.4, 0.4, 0.4], variance=1.0, nugget=1e-3
        )
    )  # fmt: skip
    other = GaussianProcess(
        CUBE,
        x,
        shift + scale * y,
        noise_variance=noise * scale**2,
        hyperparameters=one.hyperparameters,
    )
    mean, std = one.predict(points)
    slack = 1e-6 * scale + 1e-9 * abs(shift)
    np.testing.assert_allclose(other.predict(points)[0], shift + scale * mean, atol=slack)
    np.testing.assert_allclose(other.predict(points)[1], scale * std, atol=slack)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("spread", [0.0, 1e-12, 1e-8, 1e-4])
def test_clustered_and_repeated_samples_do_no_harm(name, spread):
    rng = np.random.default_rng(3)
    centre = hartmann(3).minimisers[0]
    x = np.clip(np.concatenate([rng.random((10, 3)), centre + spread * rng.random((30, 3))]), 0, 1)
    y = hartmann(3).formula(x)
    process = GaussianProcess.fit(hartmann(3).space, x, y, covariance=name)
    mean, std = process.predict(x)
    assert np.all(np.isfinite(mean)) and np.all(np.isfinite(std))
    np.testing.assert_allclose(mean[10:], hartmann(3).minimum, atol=1e-2)
    exact = Hyperparameters(lengths=[0.5, 0.5, 0.5], variance=1.0, nugget=0.0)
    bare = GaussianProcess(hartmann(3).space, x, y, covariance=name, hyperparameters=exact)
    np.testing.assert_allclose(bare.predict(x)[0], y, atol=1e-3)


def test_matrix_far_from_positive_definite_is_refused():
    with pytest.raises(ComputationError, match="not positive definite"):
        factorised(-np.eye(3))
    with pytest.raises(ComputationError, match="not finite"):
        factorised(np.full((2, 2), np.nan))
    singular = np.ones((4, 4))
    factor = factorised(singular)
    np.testing.assert_allclose(factor @ factor.T, singular, atol=1e-9)


def test_repeated_samples_average_and_their_noise_is_found():
    space = forrester().space
    rng = np.random.default_rng(8)
    x = np.repeat(np.linspace(0, 1, 12), 10)[:, None]
    y = forrester().formula(x) + 0.5 * rng.standard_normal(120)
    process = GaussianProcess.fit(space, x, y)
    assert process.nugget_std == pytest.approx(0.5, rel=0.25)
    mean, std = process.predict(x[::10])
    exact = forrester().formula(x[::10])
    assert np.abs(mean - exact).max() < 4 * 0.5 / np.sqrt(10)
    assert np.all(std < 0.5)


def test_noise_of_each_sample_counts():
    space = Space([Parameter(name="a", low=0.0, high=1.0)])
    x = np.array([[0.1], [0.3], [0.5], [0.5], [0.9]])
    y = np.array([0.0, 1.0, 5.0, 1.0, 0.0])
    noise = np.array([0.0, 0.0, 4.0, 1.0, 0.0])
    # so short a length that the samples at 0.5 know of no others
    hyper = Hyperparameters(lengths=[0.01], variance=1e6, nugget=0.0)
    process = GaussianProcess(space, x, y, noise_variance=noise, hyperparameters=hyper)
    mean, std = process.predict([0.5])
    assert mean == pytest.approx((5.0 / 4 + 1.0 / 1) / (1 / 4 + 1 / 1), rel=1e-4)
    assert std == pytest.approx(np.sqrt(1 / (1 / 4 + 1 / 1)), rel=1e-4)


def test_predictions_are_as_sure_as_they_say():
    """Standardised errors of functions drawn from the prior are standard normal."""
    rng = np.random.default_rng(9)
    space = Space([Parameter(name="a", low=0.0, high=1.0)])
    covariance = covariance_named("matern")
    scores = []
    for _ in range(300):
        u = rng.random((13, 1))
        matrix = covariance.value(((u - u.T) / 0.3) ** 2) + 1e-10 * np.eye(13)
        y = 4.0 + np.linalg.cholesky(matrix) @ rng.standard_normal(13)
        known = y[:12]
        hyper = Hyperparameters(lengths=[0.3], variance=1.0 / known.var(), nugget=1e-10)
        process = GaussianProcess(space, u[:12], known, covariance="matern", hyperparameters=hyper)
        mean, std = process.predict(u[12])
        scores.append((y[12] - mean) / std)
    assert abs(np.mean(scores)) < 4 / np.sqrt(300)
    assert np.std(scores) == pytest.approx(1.0, abs=0.15)


def test_believed_samples_shrink_deviations_alone():
    x, y = mixed_data()
    process = GaussianProcess.fit(MIXED, x, y)
    rng = np.random.default_rng(6)
    pending, points = rng.random((3, 5)), rng.random((50, 5))
    believed = process.believing(pending)
    np.testing.assert_allclose(believed.moments(points)[0], process.moments(points)[0], atol=1e-7)
    assert np.all(believed.moments(points)[1] <= process.moments(points)[1] + 1e-9)
    assert np.all(believed.moments(pending)[1] < 0.5 * process.moments(pending)[1])
    assert process.believing(np.empty((0, 5))) is process


def test_fit_repeats_and_stays_with_a_good_begin():
    x, y = mixed_data()
    first = GaussianProcess.fit(MIXED, x, y, seed=5)
    again = GaussianProcess.fit(MIXED, x, y, seed=5)
    assert first.hyperparameters.document() == again.hyperparameters.document()
    kept = GaussianProcess.fit(MIXED, x, y, begin=first.hyperparameters, starts=0)
    np.testing.assert_allclose(
        kept.hyperparameters.lengths, first.hyperparameters.lengths, rtol=1e-2
    )
    document = first.hyperparameters.document()
    assert Hyperparameters.from_document(document).document() == document


def test_fit_beats_every_start_and_stays_inside():
    x, y = mixed_data(20)
    f = MIXED.features(MIXED.to_unit(x))
    likelihood = Likelihood(
        covariance_named("matern"), f, MIXED.groups, (y - y.mean()) / y.std(), np.zeros(20)
    )
    for criterion in ("ml", "map"):
        found = fitted(likelihood, criterion, starts=8, rng=np.random.default_rng(0))
        best = np.log([*found.lengths, found.variance, found.nugget])

        def score(theta, criterion=criterion):
            prior = log_prior(theta).value if criterion == "map" else 0.0
            return likelihood(theta).value + prior

        rng = np.random.default_rng(1)
        for _ in range(100):
            other = np.clip(best + 0.3 * rng.standard_normal(6), *np.log([1e-2, 30.0]))
            other[-1] = max(best[-1] + 0.3 * rng.standard_normal(), np.log(1e-10))
            assert score(other) <= score(best) + 1e-6


def test_samples_that_are_all_alike():
    process = GaussianProcess.fit(CUBE, np.random.default_rng(0).random((6, 3)), np.full(6, 4e6))
    mean, std = process.predict([0.5, 0.5, 0.5])
    assert mean == pytest.approx(4e6)
    assert np.isfinite(std)


def test_predict_keeps_the_shape_of_a_grid():
    x, y = branin().minimisers, np.array([1.0, 2.0, 3.0])
    process = GaussianProcess.fit(branin().space, x, y)
    grid = np.stack(np.meshgrid(np.linspace(-5, 10, 4), np.linspace(0, 15, 3)), axis=-1)
    mean, std = process.predict(grid)
    assert mean.shape == std.shape == (3, 4)
    assert mean[1, 2] == process.predict(grid[1, 2])[0]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": [[0.1, 0.2]]}, r"x: got shape \(1, 2\), expected 2 of points of 3"),
        ({"x": [[0, 0, 0], [0, 0, 2]]}, "x: got c = 2, expected between 0 and 1"),
        ({"x": [[0, 0, 0], [0, 0, np.nan]]}, "x: got 1 NaN"),
        ({"y": [1.0, np.inf]}, "y: got 1 NaN or infinite"),
        ({"noise_variance": [1.0]}, r"noise_variance: got shape \(1,\), expected \(2,\)"),
        ({"noise_variance": [1.0, -1.0]}, "noise_variance: got -1"),
        ({"covariance": "cubic"}, "covariance: got 'cubic', expected squared-exponential or"),
        ({"criterion": "bayes"}, "hyperparameters: got 'bayes', expected ml or map"),
        ({"starts": 0}, "starts: got 0"),
        ({"x": [[0, 0, 0]], "y": [1.0]}, "y: got 1 sample, expected at least 2"),
    ],
)
def test_bad_input_is_named(change, message):
    given = {"x": [[0, 0, 0], [1, 1, 1]], "y": [1.0, 2.0], **change}
    with pytest.raises(InputError, match=message):
        GaussianProcess.fit(CUBE, given.pop("x"), given.pop("y"), **given)


def test_bad_hyperparameters_are_named():
    with pytest.raises(InputError, match="lengths: got -1, expected positive"):
        Hyperparameters(lengths=[-1.0], variance=1.0, nugget=0.0)
    with pytest.raises(InputError, match="hyperparameters: 'nugget' is missing"):
        Hyperparameters.from_document({"lengths": [1.0], "variance": 1.0})
    hyper = Hyperparameters(lengths=[1.0], variance=1.0, nugget=0.0)
    with pytest.raises(InputError, match="hyperparameters: got 1 lengths, expected 3"):
        GaussianProcess(CUBE, [[0, 0, 0], [1, 1, 1]], [0.0, 1.0], hyperparameters=hyper)


def test_likelihood_has_the_same_bits_with_one_thread_and_with_two():
    script = (
        "import numpy as np\n"
        "from pitchopt.tuning.covariance import covariance_named\n"
        "from pitchopt.tuning.likelihood import Likelihood\n"
        "rng = np.random.default_rng(4)\n"
        "points = rng.random((30, 4))\n"
        "y = np.sin(5.0 * points[:, 0]) + points[:, 1]\n"
        "covariance = covariance_named('squared-exponential')\n"
        "found = Likelihood(covariance, points, np.arange(4), y, np.zeros(30))(np.full(6, -1.0))\n"
        "print(found.value.hex(), found.gradient.tobytes().hex())\n"
    )
    names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
    printed = {
        subprocess.run(
            [sys.executable, "-c", script],
            env=os.environ
            | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
            | dict.fromkeys(names, threads),
            capture_output=True,
            check=True,
        ).stdout
        for threads in ("1", "2")
    }
    assert len(printed) == 1
