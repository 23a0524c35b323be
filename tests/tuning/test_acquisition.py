"""Acquisition functions against integrals, closed forms, sampling and differences."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import log_ndtr, ndtr

from pitchopt.tuning import GaussianProcess, Parameter, Polar, Space
from pitchopt.tuning.acquisition import (
    ConfidenceBound,
    ExpectedImprovement,
    LogExpectedImprovement,
    NoisyExpectedImprovement,
    ProbabilityOfImprovement,
    ThompsonSample,
    log_improvement,
)
from pitchopt.tuning.acquisition_search import maximise
from pitchopt.tuning.covariance import Hyperparameters
from pitchopt.tuning.quasi_random import sobol
from pitchopt.tuning.surrogates import Weighed

SPACE = Space(
    [
        Parameter(name="plain", low=0.0, high=2.0),
        Parameter(name="gain", low=0.0, high=2.0),
        Parameter(name="offset", low=0.0, high=360.0, periodic=True),
        Parameter(name="phase", low=0.0, high=1.0, periodic=True),
    ],
    polar=[Polar(radius="gain", angle="offset")],
)


def process_of(covariance="squared-exponential", *, nugget=0.05, count=14, seed=0):
    rng = np.random.default_rng(seed)
    u = rng.random((count, len(SPACE)))
    f = SPACE.features(u)
    y = np.sin(4 * f[:, 0]) + 2 * f[:, 1] ** 2 + f @ rng.random(f.shape[1])
    hyper = Hyperparameters(lengths=[0.4, 0.5, 0.6], variance=1.2, nugget=nugget)
    return GaussianProcess(
        SPACE,
        SPACE.from_unit(u),
        y,
        noise_variance=0.01 * rng.random(count),
        covariance=covariance,
        hyperparameters=hyper,
    )


def noisy(process, *, pending=0, exponent=5):
    return NoisyExpectedImprovement(
        process,
        candidates=np.ones(len(process.y), dtype=bool),
        pending=np.random.default_rng(5).random((pending, len(SPACE))),
        rng=np.random.default_rng(1),
        exponent=exponent,
    )


MAKERS = {
    "expected": lambda p: ExpectedImprovement(p, -1.0),
    "log expected": lambda p: LogExpectedImprovement(p, -1.0),
    "log expected, far": lambda p: LogExpectedImprovement(p, -500.0),
    "probability": lambda p: ProbabilityOfImprovement(p, -1.0),
    "bound": lambda p: ConfidenceBound(p, 2.0),
    "noisy": noisy,
    "noisy, pending": lambda p: noisy(p, pending=3),
    "thompson": lambda p: ThompsonSample(p, rng=np.random.default_rng(2)),
    "feasible alone": lambda p: Weighed(None, [ProbabilityOfImprovement(p, 0.3)], logarithmic=True),
    "weighed logarithm": lambda p: Weighed(
        LogExpectedImprovement(p, -1.0),
        [ProbabilityOfImprovement(p, 0.3), ProbabilityOfImprovement(p, 0.7)],
        logarithmic=True,
    ),
    "weighed": lambda p: Weighed(
        ExpectedImprovement(p, -1.0), [ProbabilityOfImprovement(p, 0.3)], logarithmic=False
    ),
    "weighed from a floor": lambda p: Weighed(
        ConfidenceBound(p, 2.0), [ProbabilityOfImprovement(p, 0.3)], logarithmic=False, floor=-0.5
    ),
}


@pytest.mark.parametrize("covariance", ["squared-exponential", "matern"])
@pytest.mark.parametrize("name", MAKERS)
def test_gradients_by_differences(name, covariance):
    acquisition = MAKERS[name](process_of(covariance))
    u = np.random.default_rng(3).random((6, len(SPACE)))
    value, gradient = acquisition.gradients(u)
    np.testing.assert_allclose(acquisition.values(u), value, rtol=1e-12)
    assert np.abs(gradient).max() > 1e-3
    h = 1e-5
    for place, step in enumerate(h * np.eye(len(SPACE))):
        change = (acquisition.values(u + step) - acquisition.values(u - step)) / (2 * h)
        scale = np.abs(gradient).max()
        np.testing.assert_allclose(gradient[:, place], change, rtol=1e-5, atol=2e-7 * scale)


@pytest.mark.parametrize("z", [-1e-3, -0.5, -1.0, -2.0, -30.0, -199.0, -201.0, -1e3, -1e6])
def test_logarithm_of_improvement_by_quadrature(z):
    # h(z) = phi(z) / z^2 int_0^oo s exp(-s^2 / 2 z^2 - s) ds with s = |z| t
    integral, _ = quad(lambda s: s * np.exp(-0.5 * (s / z) ** 2 - s), 0, np.inf, epsabs=0)
    exact = np.log(integral) - 2 * np.log(-z) - 0.5 * z * z - 0.5 * np.log(2 * np.pi)
    assert log_improvement(np.array(z)) == pytest.approx(exact, rel=1e-11)


def test_logarithm_of_improvement_has_no_steps_where_its_branches_meet():
    for z in (-1.0, -200.0):
        sides = log_improvement(z + np.array([-1e-9, 1e-9]) * abs(z))
        slope = np.exp(log_ndtr(z) - log_improvement(np.array(z)))  # d log h / dz = Phi / h
        assert np.diff(sides)[0] == pytest.approx(2e-9 * abs(z) * slope, abs=1e-11 * z * z)
    z = np.linspace(-3, 40, 200)
    with np.errstate(under="ignore"):
        direct = np.exp(-0.5 * z**2) / np.sqrt(2 * np.pi) + z * ndtr(z)
    np.testing.assert_allclose(np.exp(log_improvement(z)), direct, rtol=1e-9)


@pytest.mark.parametrize("z", [-1e5, -1e7, -1e9, -1e12])
def test_slopes_far_in_the_tail(z):
    # Phi / phi = 1 / |z| (1 - 1 / z^2 + ...), h / phi = 1 / z^2 (1 - 3 / z^2 + ...)
    mean, std = np.array([-z]), np.array([1.0])
    _, by_mean, by_std = LogExpectedImprovement(process_of(), 0.0)._of(mean, std)
    assert by_mean[0] == pytest.approx(z, rel=1e-9)
    assert by_std[0] == pytest.approx(z * z, rel=1e-9)
    _, by_mean, by_std = ProbabilityOfImprovement(process_of(), 0.0)._of(mean, std)
    assert by_mean[0] == pytest.approx(z, rel=1e-9)
    assert by_std[0] == pytest.approx(z * z, rel=1e-9)


def test_closed_forms_against_the_integral_over_the_posterior():
    process = process_of()
    u = np.random.default_rng(4).random((5, len(SPACE)))
    mean, std = process.moments(u)
    for best in (-1.0, 0.2):
        expected = ExpectedImprovement(process, best).values(u)
        for place in range(len(u)):
            m, s = mean[place], std[place]
            z = (best - m) / s
            integral, _ = quad(
                lambda t, m=m, s=s, best=best: (
                    (best - m - s * t) * np.exp(-0.5 * t * t) / np.sqrt(2 * np.pi)
                ),
                -40,
                z,
                epsabs=1e-14,
                points=[min(0.0, z)],
            )
            assert expected[place] == pytest.approx(integral, rel=1e-7)
        np.testing.assert_allclose(
            np.exp(LogExpectedImprovement(process, best).values(u)), expected, rtol=1e-12
        )
        chance = np.exp(ProbabilityOfImprovement(process, best).values(u))
        np.testing.assert_allclose(chance, ndtr((best - mean) / std), rtol=1e-12)
    np.testing.assert_allclose(ConfidenceBound(process, 1.5).values(u), 1.5 * std - mean)


def test_logarithm_climbs_where_improvement_is_zero_to_rounding():
    process = process_of()
    u = np.random.default_rng(6).random((20, len(SPACE)))
    assert np.all(ExpectedImprovement(process, -300.0).values(u) == 0.0)
    value, gradient = LogExpectedImprovement(process, -300.0).gradients(u)
    assert np.all(np.isfinite(value)) and np.all(np.isfinite(gradient))
    assert np.linalg.norm(gradient, axis=1).min() > 1.0
    chance, slope = ProbabilityOfImprovement(process, -300.0).gradients(u)
    assert np.all(np.isfinite(chance)) and np.all(np.isfinite(slope))


def test_noisy_improvement_by_sampling_the_joint_posterior():
    process = process_of(nugget=0.3)
    points = np.random.default_rng(7).random((4, len(SPACE)))
    pending = np.random.default_rng(5).random((2, len(SPACE)))
    value = np.exp(noisy(process, pending=2, exponent=11).values(points))
    kriging = process.kriging
    everywhere = np.concatenate([kriging.u, pending, points])
    scaled = SPACE.features(everywhere) / kriging.lengths
    distance = ((scaled[:, None] - scaled) ** 2).sum(axis=2)
    prior = kriging.hyperparameters.variance * kriging.covariance.value(distance)
    k = kriging.cross(everywhere)
    joint = kriging.covariances(k, prior)
    mean = process.moments(everywhere)[0]
    root = np.linalg.cholesky(joint + 1e-9 * np.eye(len(joint)))
    draws = mean + np.random.default_rng(8).standard_normal((200_000, len(mean))) @ root.T
    best = draws[:, :-4].min(axis=1)
    gain = np.maximum(best[:, None] - draws[:, -4:], 0.0)
    error = gain.std(axis=0) / np.sqrt(len(draws))
    assert np.all(np.abs(value - gain.mean(axis=0)) < 5 * error + 0.03 * gain.mean(axis=0))


def test_noisy_improvement_without_noise_is_the_plain_one():
    process = process_of(nugget=1e-8)
    exact = GaussianProcess(
        SPACE,
        SPACE.from_unit(process.kriging.u),
        process.shift + process.scale * process.y,
        hyperparameters=process.hyperparameters,
    )
    u = np.random.default_rng(9).random((30, len(SPACE)))
    plain = np.exp(LogExpectedImprovement(exact, exact.y.min()).values(u))
    np.testing.assert_allclose(np.exp(noisy(exact).values(u)), plain, rtol=2e-3, atol=1e-6)


def test_samples_that_may_not_be_best_do_not_bound_the_improvement():
    process = process_of(nugget=1e-8)
    u = np.random.default_rng(9).random((30, len(SPACE)))
    able = process.y > np.median(process.y)
    without = NoisyExpectedImprovement(
        process, candidates=able, pending=np.empty((0, 4)), rng=np.random.default_rng(1)
    )
    assert np.all(without.values(u) > noisy(process).values(u))


@pytest.mark.parametrize("covariance", ["squared-exponential", "matern"])
def test_thompson_draws_have_the_posterior_mean_and_deviation(covariance):
    process = process_of(covariance)
    u = np.random.default_rng(10).random((6, len(SPACE)))
    rng = np.random.default_rng(11)
    draws = -np.array([ThompsonSample(process, rng=rng, waves=256).values(u) for _ in range(1500)])
    mean, std = process.moments(u)
    assert np.all(np.abs(draws.mean(axis=0) - mean) < 4.5 * std / np.sqrt(1500))
    np.testing.assert_allclose(draws.std(axis=0), std, rtol=0.1)


def test_thompson_draw_passes_through_exact_samples():
    exact = GaussianProcess(
        SPACE,
        SPACE.from_unit(np.random.default_rng(0).random((8, 4))),
        np.arange(8.0),
        hyperparameters=Hyperparameters(lengths=[0.4, 0.4, 0.4], variance=1.0, nugget=0.0),
    )
    draw = ThompsonSample(exact, rng=np.random.default_rng(1))
    np.testing.assert_allclose(-draw.values(exact.kriging.u), exact.y, atol=1e-6)


class Hill:
    """-|features - target|^2, whose maximum is known."""

    def __init__(self, target):
        self.target = SPACE.features(np.asarray(target))

    def values(self, u):
        return -((SPACE.features(u) - self.target) ** 2).sum(axis=1)

    def gradients(self, u):
        slope = -2.0 * (SPACE.features(u) - self.target)
        return self.values(u), np.einsum("mf,mfd->md", slope, SPACE.jacobian(u))


@pytest.mark.parametrize("target", [[0.3, 0.7, 0.0, 0.999], [1.0, 0.2, 0.5, 0.0], [0, 1, 0.9, 0.5]])
def test_search_finds_a_known_maximum_across_the_seam(target):
    near = np.array([[0.9, 0.9, 0.45, 0.5]])
    u, value = maximise(SPACE, Hill(target), near=near, rng=np.random.default_rng(0))
    assert value == pytest.approx(0.0, abs=1e-10)
    np.testing.assert_allclose(SPACE.features(u), SPACE.features(np.array(target)), atol=1e-5)
    assert np.all((u >= 0.0) & (u <= 1.0))
    again, _ = maximise(SPACE, Hill(target), near=near, rng=np.random.default_rng(0))
    np.testing.assert_array_equal(u, again)


@pytest.mark.parametrize("name", [name for name in MAKERS if "far" not in name])
def test_search_beats_a_dense_sample(name):
    process = process_of()
    acquisition = MAKERS[name](process)
    near = process.kriging.u[np.argsort(process.y)[:3]]
    u, value = maximise(SPACE, acquisition, near=near, rng=np.random.default_rng(0))
    dense = np.random.default_rng(1).random((20_000, len(SPACE)))
    assert value >= acquisition.values(dense).max()
    assert value == pytest.approx(acquisition.values(u[None])[0])


def test_longer_quasi_random_sequences_begin_as_shorter_ones():
    short = sobol(3, 4, np.random.default_rng(2))
    np.testing.assert_array_equal(short, sobol(6, 4, np.random.default_rng(2))[:8])
    assert np.abs(sobol(9, 2, np.random.default_rng(0)).mean(axis=0) - 0.5).max() < 1e-3
