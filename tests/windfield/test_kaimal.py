"""Kaimal turbulence against the formulas of IEC 61400-1, with bounds computed from its law.

A box is Gaussian with independent harmonics: the periodogram of harmonic n is s_n chi2_2 / 2. Sums
over harmonics and seeds have known bounds; each comparison would refuse right boxes with the
probability RISK. The seeds are the same in every run. The formulas are written here a second
time.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize, minimize_scalar
from scipy.special import ndtri
from scipy.stats import chi2

from windfield import BoxCache, WindFieldError, iec_sigma, kaimal_box, kaimal_polar_box
from windfield.correlated import CartesianNoise, GridNoise, PolarNoise
from windfield.iec import band_variance, coherence, kaimal_spectrum, length_scales

Array = NDArray[np.float64]

RISK = 1e-4
SEEDS = 40
U, HUB, DURATION, INTERVAL = 12.0, 90.0, 600.0, 0.5
SIGMA = 0.14 * (0.75 * U + 5.6)
SIGMAS = SIGMA * np.array([1.0, 0.8, 0.5])
LENGTHS = 42.0 * np.array([8.1, 2.7, 0.66])
COMMON: dict[str, Any] = {"hub_height": HUB, "turbulence": "B"}
HARMONICS = np.arange(1, 601) / DURATION


def box(seed: int, **changes: Any) -> Any:
    settings: dict[str, Any] = COMMON | {"width": 40.0, "points": (3, 3)} | changes
    return kaimal_box(U, DURATION, INTERVAL, seed=seed, **settings)


def polar_box(seed: int, **changes: Any) -> Any:
    settings: dict[str, Any] = COMMON | {"radius": 20.0, "rings": 3, "spokes": 4} | changes
    return kaimal_polar_box(U, DURATION, INTERVAL, seed=seed, **settings)


MAKERS: dict[str, Callable[..., Any]] = {"cartesian": box, "polar": polar_box}
# two points 20 m apart, and 40 m, of either grid: indices and position (y, z - hub)
CORNERS = {
    "cartesian": [((1, 1), (0, 0)), ((1, 2), (0, 20)), ((0, 1), (-20, 0)), ((2, 1), (20, 0))],
    "polar": [((0, 0), (0, 0)), ((2, 0), (0, 20)), ((2, 1), (-20, 0)), ((2, 3), (20, 0))],
}


@cache
def harmonics(kind: str, **changes: Any) -> Array:
    """Complex amplitudes (seeds, harmonics, points, 3): velocity = Re sum c exp(i 2 pi f t)."""
    points = tuple(np.array([index for index, _ in CORNERS[kind]]).T)
    out = []
    for seed in range(SEEDS):
        made = MAKERS[kind](seed, scaling="spectrum", **changes)
        series = made.velocity[:, points[0], points[1]].astype(np.float64)
        out.append(np.fft.rfft(series, axis=0)[1:] * (2.0 / len(series)))
    amplitudes = np.array(out)
    amplitudes[:, -1] *= 0.5 * np.sqrt(2.0)  # so that |c|^2 / 2 is the variance there too
    return amplitudes


def spectrum(f: Array) -> Array:
    """S (..., 3) as the standard prints it: f S / sigma^2 = 4 f L / V / (1 + 6 f L / V)^(5/3)."""
    x = f[..., None] * LENGTHS / U
    return SIGMAS**2 * 4.0 * x / (1.0 + 6.0 * x) ** (5.0 / 3.0) / f[..., None]


def bins() -> Array:
    """Variance (harmonics, 3) of the standard's spectrum around each harmonic, by quadrature."""
    nodes, weights = np.polynomial.legendre.leggauss(12)
    half = np.full(HARMONICS.size, 0.5 / DURATION)
    middle = HARMONICS.copy()
    half[-1], middle[-1] = 0.25 / DURATION, 1.0 - 0.25 / DURATION  # up to 1 Hz, half the rate
    f = middle[:, None] + half[:, None] * nodes
    return np.einsum("nqk,q,n->nk", spectrum(f), weights, half)


# --- formulas ---


def test_normal_turbulence_model() -> None:
    # at 15 m/s the intensity of the normal turbulence model is I_ref (0.75 + 5.6 / 15)
    for name, reference in (("A+", 0.18), ("A", 0.16), ("B", 0.14), ("C", 0.12)):
        assert iec_sigma(name, 15.0) == pytest.approx(reference * (0.75 * 15.0 + 5.6))
    assert iec_sigma(0.1, 15.0) == pytest.approx(1.5)


def test_length_scales_follow_the_height_up_to_60_m() -> None:
    np.testing.assert_allclose(length_scales(90.0), LENGTHS)
    np.testing.assert_allclose(length_scales(30.0), 0.5 * LENGTHS)


def test_spectra_are_the_standards() -> None:
    f = np.geomspace(1e-4, 10.0, 30)
    got = kaimal_spectrum(f, sigma=SIGMA, mean_speed=U, hub_height=HUB)
    np.testing.assert_allclose(got, spectrum(f), rtol=1e-12)
    # in the inertial subrange v and w tend to 4/3 of u, which the standard asks for
    high = kaimal_spectrum(1e6, sigma=SIGMA, mean_speed=U, hub_height=HUB)
    np.testing.assert_allclose(high[1:] / high[0], 4.0 / 3.0, rtol=0.01)


def test_band_variance_is_the_integral() -> None:
    settings = {"sigma": SIGMA, "mean_speed": U, "hub_height": HUB}
    edges = np.concatenate([HARMONICS - 0.5 / DURATION, [1.0]])
    got = band_variance(edges[:-1], edges[1:], **settings)
    np.testing.assert_allclose(got, bins(), rtol=1e-6)
    np.testing.assert_allclose(band_variance(0.0, 1e30, **settings), SIGMAS**2)


def test_coherence_is_the_standards() -> None:
    got = coherence([0.0, 0.1], 20.0, mean_speed=U, hub_height=HUB)
    wanted = [np.exp(-12 * 0.12 * 20 / 340.2)]
    wanted += [np.exp(-12 * np.sqrt((0.1 * 20 / 12) ** 2 + (0.12 * 20 / 340.2) ** 2))]
    np.testing.assert_allclose(got, wanted, rtol=1e-12)


# --- correlation over the points ---


def positions(noise: GridNoise) -> Array:
    if isinstance(noise, CartesianNoise):
        y, z = np.meshgrid(np.arange(noise.count[0]), np.arange(noise.count[1]), indexing="ij")
        return np.column_stack([3.0 * y.ravel(), 2.0 * z.ravel()])
    assert isinstance(noise, PolarNoise)
    angle = np.arange(noise.spokes) * 2 * np.pi / noise.spokes
    rings = [np.column_stack([-r * np.sin(angle), r * np.cos(angle)]) for r in noise.radius[1:]]
    return np.vstack([[[0.0, 0.0]], np.stack(rings, axis=1).reshape(-1, 2)])


@pytest.mark.parametrize(
    "noise",
    [CartesianNoise(n, (3.0, 2.0)) for n in ((13, 13), (4, 5), (2, 2), (5, 2), (6, 6))]
    + [PolarNoise(4.0 * np.arange(n), m) for n, m in ((2, 3), (5, 8), (4, 9), (3, 24))],
    ids=lambda noise: f"{type(noise).__name__}{noise.points}",
)
def test_factor_of_the_correlation_is_exact(noise: GridNoise) -> None:
    def correlation(distance: Array) -> Array:
        return np.exp(-np.array([[0.003], [0.05], [1.0]]) * distance)

    unit = np.broadcast_to(np.eye(noise.points), (3, noise.points, noise.points))
    factor = noise.correlate(correlation, unit.copy())
    at = positions(noise)
    distance = np.hypot(*(at[:, None] - at).T)
    wanted = correlation(distance.ravel()).reshape(3, noise.points, noise.points)
    np.testing.assert_allclose(factor @ factor.swapaxes(1, 2), wanted, atol=1e-13)


def test_points_are_put_where_they_belong() -> None:
    polar = PolarNoise(np.array([0.0, 5.0, 10.0]), 4)
    at = np.broadcast_to(positions(polar), (2, polar.points, 2))
    grid = polar.on_grid(at)
    assert grid.shape == (2, 3, 4, 2)
    np.testing.assert_allclose(grid[0, 0], 0.0)
    np.testing.assert_allclose(grid[1, 2], [[0, 10], [-10, 0], [0, -10], [10, 0]], atol=1e-12)
    flat = CartesianNoise((2, 3), (3.0, 2.0))
    grid = flat.on_grid(positions(flat)[None])
    np.testing.assert_allclose(grid[0, 1, 2], [3.0, 4.0])


# --- statistics of boxes ---


@pytest.mark.parametrize("kind", MAKERS)
@pytest.mark.parametrize("component", range(3))
def test_spectrum_in_bands(kind: str, component: int) -> None:
    power = np.abs(harmonics(kind)[..., component]) ** 2 / 2.0  # (seeds, harmonics, points)
    level = bins()[:, component]
    edges = [0, 1, 2, 4, 8, 16, 32, 64, 128, 256, 599]  # the last harmonic has chi2_1
    for point in range(power.shape[2]):
        for low, high in pairwise(edges):
            ratio = power[:, low:high, point] / level[low:high]
            freedom = 2 * SEEDS * (high - low)
            least, most = chi2.ppf([RISK / 2, 1 - RISK / 2], freedom)
            assert least < 2.0 * ratio.sum() < most, (point, low, high)
        last = power[:, 599, point] / level[599]
        least, most = chi2.ppf([RISK / 2, 1 - RISK / 2], SEEDS)
        assert least < last.sum() < most


@pytest.mark.parametrize("kind", MAKERS)
@pytest.mark.parametrize("component", range(3))
def test_length_scale_from_the_boxes(kind: str, component: int) -> None:
    # maximum likelihood of L in the exponential law of the periodogram, with its own error
    power = np.abs(harmonics(kind)[:, :599, 0, component]) ** 2 / 2.0

    def levels(log_length: float) -> Array:
        x = HARMONICS[:599] * np.exp(log_length) / U
        density = 4.0 * x / (1.0 + 6.0 * x) ** (5.0 / 3.0) / HARMONICS[:599]
        return np.asarray(SIGMAS[component] ** 2 * density / DURATION)

    def loss(log_length: float) -> float:
        level = levels(log_length)
        return float(np.sum(np.log(level) + power / level))

    fitted = minimize_scalar(loss, bracket=(np.log(10.0), np.log(300.0))).x
    x = 6.0 * HARMONICS[:599] * np.exp(fitted) / U
    slope = 1.0 - 5.0 / 3.0 * x / (1.0 + x)  # d log S / d log L
    error = 1.0 / np.sqrt(SEEDS * np.sum(slope**2))
    assert abs(fitted - np.log(LENGTHS[component])) < -ndtri(RISK / 2) * error
    assert error < 0.1


def cross(a: Array, b: Array) -> tuple[complex, int]:
    """Mean of a conj(b) of unit amplitudes, and the number of samples."""
    return complex(np.mean(a * b.conj())), a.size


def white(kind: str, **changes: Any) -> Array:
    return harmonics(kind, **changes)[:, :599] / np.sqrt(2.0 * bins()[:599, None])


@pytest.mark.parametrize("kind", MAKERS)
@pytest.mark.parametrize("component", range(3))
@pytest.mark.parametrize(("a", "b"), [(0, 1), (0, 2), (1, 2), (2, 3)])
def test_coherence_between_points(kind: str, component: int, a: int, b: int) -> None:
    unit = white(kind)[..., component]
    spots = np.array([place for _, place in CORNERS[kind]], dtype=np.float64)
    distance = float(np.hypot(*(spots[a] - spots[b])))
    rate = 12.0 * np.sqrt((HARMONICS[:599] * distance / U) ** 2 + (0.12 * distance / 340.2) ** 2)
    wanted = np.exp(-rate)
    margin = -ndtri(RISK / 2)
    for low, high in ((0, 10), (10, 20), (20, 40), (40, 80), (80, 599)):
        got, samples = cross(unit[:, low:high, a], unit[:, low:high, b])
        level = wanted[low:high]
        # Var Re = (1 + c^2) / 2, Var Im = (1 - c^2) / 2 of one sample
        assert abs(got.real - level.mean()) < margin * np.sqrt(np.mean(1 + level**2) / 2 / samples)
        assert abs(got.imag) < margin * np.sqrt(np.mean(1 - level**2) / 2 / samples)


@pytest.mark.parametrize("kind", MAKERS)
@pytest.mark.parametrize(("a", "b"), [(0, 1), (1, 2), (2, 3)])
def test_decay_and_offset_of_the_coherence_from_the_boxes(kind: str, a: int, b: int) -> None:
    # maximum likelihood in the law of a pair of complex normal amplitudes of coherence c,
    #   -log(1 - c^2) - (|a|^2 + |b|^2 - 2 c Re a b*) / (1 - c^2),
    # with the information 2 (1 + c^2) / (1 - c^2)^2
    # the components are independent and have the same coherence
    unit = np.concatenate([white(kind)[..., k] for k in range(3)])
    samples = len(unit)
    power = np.sum(np.abs(unit[..., a]) ** 2 + np.abs(unit[..., b]) ** 2, axis=0)
    product = np.sum((unit[..., a] * unit[..., b].conj()).real, axis=0)
    spots = np.array([place for _, place in CORNERS[kind]], dtype=np.float64)
    distance = float(np.hypot(*(spots[a] - spots[b])))

    def level(parameters: Array) -> Array:
        decay, offset = np.exp(parameters)
        return np.exp(-decay * distance * np.hypot(HARMONICS[:599] / U, offset / 340.2))

    def loss(parameters: Array) -> float:
        c = level(parameters)
        rest = 1.0 - c**2
        return float(np.sum(samples * np.log(rest) + (power - 2.0 * c * product) / rest))

    true = np.log([12.0, 0.12])
    fitted = minimize(
        loss, true + np.array([0.2, -0.2]), method="Nelder-Mead", options={"xatol": 1e-5}
    ).x
    c, step = level(true), 1e-5
    slopes = np.array([(level(true + d) - level(true - d)) / (2 * step) for d in step * np.eye(2)])
    information = samples * (slopes * 2.0 * (1.0 + c**2) / (1.0 - c**2) ** 2) @ slopes.T
    off = fitted - true
    assert off @ information @ off < chi2.ppf(1.0 - RISK, 2)
    errors = np.sqrt(np.diag(np.linalg.inv(information)))
    assert errors[0] < 0.03 and errors[1] < 0.11  # the test can tell


@pytest.mark.parametrize("kind", MAKERS)
def test_what_is_not_correlated(kind: str) -> None:
    unit = white(kind)
    margin = -ndtri(RISK / 2)
    pairs = [(unit[..., i], unit[..., j]) for i, j in ((0, 1), (0, 2), (1, 2))]  # components
    pairs += [(unit[:, :-1, 0], unit[:, 1:, 0])]  # neighbouring harmonics
    pairs += [(unit[:-1, :, 0], unit[1:, :, 0])]  # seeds
    pairs += [(unit[:, :, 0], unit[:, :, 0].conj())]  # real and imaginary part
    for a, b in pairs:
        # points are correlated with each other, so that one of them is taken
        a, b = (c[:, :, 0] if c.shape[2] == 4 else c for c in (a, b))
        got, samples = cross(a, b)
        assert abs(got.real) < margin * np.sqrt(1.0 / samples)
        assert abs(got.imag) < margin * np.sqrt(1.0 / samples)


@pytest.mark.parametrize("kind", MAKERS)
def test_uncoupled_components(kind: str) -> None:
    unit = white(kind, coupled="u")
    coupled = white(kind)
    margin = -ndtri(RISK / 2)
    for component in (1, 2):
        got, samples = cross(unit[..., 0, component], unit[..., 1, component])
        assert abs(got.real) < margin * np.sqrt(0.5 / samples)
        same, _ = cross(coupled[..., 0, component], coupled[..., 1, component])
        assert same.real > 2 * margin * np.sqrt(0.5 / samples)
    np.testing.assert_allclose(unit[..., 0], coupled[..., 0], rtol=1e-3, atol=1e-5)


@pytest.mark.parametrize("kind", MAKERS)
def test_expected_standard_deviation(kind: str) -> None:
    power = np.zeros(3)
    for seed in range(SEEDS):
        velocity = MAKERS[kind](seed).velocity[:, 1, 1].astype(np.float64)
        np.testing.assert_allclose(velocity.mean(axis=0), 0.0, atol=1e-6)
        power += velocity.var(axis=0)
    share = bins() / bins().sum(axis=0)
    # a sum of independent chi2_2 of unequal weights: freedom of the chi2 with its variance
    freedom = 2.0 * SEEDS / np.sum(share**2, axis=0)
    for component in range(3):
        least, most = chi2.ppf([RISK / 2, 1 - RISK / 2], freedom[component])
        ratio = power[component] / SEEDS / SIGMAS[component] ** 2
        assert least < freedom[component] * ratio < most


def test_scalings_differ_by_one_factor_a_component() -> None:
    boxes = {name: box(7, scaling=name).velocity for name in ("spectrum", "expectation", "box")}
    held = bins().sum(axis=0) / SIGMAS**2
    assert 0.8 < held[0] < 0.95  # slow variations and fast ones are not in the box
    np.testing.assert_allclose(
        boxes["expectation"], boxes["spectrum"] / np.sqrt(held), rtol=1e-5, atol=1e-6
    )
    in_time = np.sqrt(boxes["box"].astype(np.float64).var(axis=0).mean(axis=(0, 1)))
    np.testing.assert_allclose(in_time, SIGMAS, rtol=1e-6)
    ratio = boxes["box"] / boxes["spectrum"]
    np.testing.assert_allclose(ratio, np.broadcast_to(ratio[:1, :1, :1], ratio.shape), rtol=1e-3)


def test_scaling_of_a_polar_box_counts_the_centre_once() -> None:
    velocity = polar_box(7, scaling="box").velocity.astype(np.float64)
    variance = velocity.var(axis=0)
    points = np.concatenate([variance[0, :1], variance[1:].reshape(-1, 3)])
    np.testing.assert_allclose(np.sqrt(points.mean(axis=0)), SIGMAS, rtol=1e-6)


def test_odd_numbers_of_slices() -> None:
    made = kaimal_box(U, 50.5, 0.5, seed=1, width=40.0, scaling="box", **COMMON)
    assert len(made.velocity) == 101 and made.duration == pytest.approx(50.5)
    in_time = np.sqrt(made.velocity.astype(np.float64).var(axis=0).mean(axis=(0, 1)))
    np.testing.assert_allclose(in_time, SIGMAS, rtol=1e-6)


def test_geometry_of_the_boxes() -> None:
    made = kaimal_box(
        10.0, 60.01, 0.1, hub_height=90.0, width=150.0, height=100.0, points=(4, 3), seed=2
    )
    assert made.velocity.shape == (601, 4, 3, 3) and made.periodic and made.offset == 0.0
    np.testing.assert_allclose(made.y, [-75.0, -25.0, 25.0, 75.0])
    np.testing.assert_allclose(made.z, [40.0, 90.0, 140.0])
    assert made.spacing == pytest.approx(1.0) and made.mean_speed == 10.0
    assert made.label == "Kaimal, class B, 10 m/s, seed 2"
    made.require(40.0, 140.0, 75.0, 60.0)
    round_one = kaimal_polar_box(10.0, 60.0, 0.1, hub_height=90.0, radius=65.0, seed=2)
    assert round_one.velocity.shape == (600, 11, 24, 3) and round_one.centre_height == 90.0
    round_one.require(25.0, 155.0, 65.0, 60.0)


# --- seeds ---


@pytest.mark.parametrize("kind", MAKERS)
def test_seeds(kind: str) -> None:
    make = MAKERS[kind]
    assert make(3) == make(3)
    assert (make(3).velocity != make(4).velocity).mean() > 0.99
    generator = np.random.default_rng(3)
    np.testing.assert_array_equal(make(generator).velocity, make(3).velocity)
    assert (make(generator).velocity != make(3).velocity).mean() > 0.99  # it has moved on
    assert make(generator).label.endswith("a generator")


def test_chunks_do_not_show(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = box(3)
    monkeypatch.setattr("windfield.kaimal.CHUNK", 1000)
    np.testing.assert_allclose(box(3).velocity, whole.velocity, rtol=0, atol=1e-6)


def test_number_of_threads_changes_rounding_only() -> None:
    program = (
        "import sys, numpy as np, windfield\n"
        "box = windfield.kaimal_box(12.0, 60.0, 0.1, hub_height=90.0, width=145.0, seed=1)\n"
        "sys.stdout.buffer.write(box.velocity.tobytes())\n"
    )
    boxes = []
    for threads in ("1", "2"):
        names = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
        environment = os.environ | dict.fromkeys(names, threads)
        out = subprocess.run(
            [sys.executable, "-c", program], env=environment, capture_output=True, check=True
        )
        boxes.append(np.frombuffer(out.stdout, dtype=np.float32))
    assert boxes[0].size == 600 * 169 * 3
    np.testing.assert_allclose(boxes[0], boxes[1], rtol=0, atol=2e-6)


# --- bad input ---


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"turbulence": "D"}, "turbulence: got 'D'; must be one of A"),
        ({"turbulence": 0.0}, "turbulence: got 0"),
        ({"hub_height": -90.0}, "hub_height: got -90"),
        ({"width": 0.0}, "width: got 0"),
        ({"width": 200.0}, "height: got 200 m about hub_height = 90 m"),
        ({"height": 181.0}, "height: got 181 m"),
        ({"points": (1, 3)}, "points: got 1"),
        ({"points": (3, 3, 3)}, "points: got"),
        ({"scaling": "hub"}, "scaling: got 'hub'"),
        ({"coupled": "v"}, "coupled: got 'v'"),
        ({"seed": -1}, "seed: got -1"),
        ({"seed": 1.5}, "seed: got 1.5"),
        ({"mean_speed": 0.0}, "mean_speed: got 0"),
        ({"duration": 0.0}, "duration: got 0"),
        ({"duration": 1.0}, "duration: got 1 s, 2 interval"),
        ({"interval": np.nan}, "interval: got nan"),
    ],
)
def test_bad_settings(changes: dict[str, Any], message: str) -> None:
    settings: dict[str, Any] = {
        "mean_speed": U, "duration": 60.0, "interval": 0.5, "width": 40.0, "seed": 1,
    }  # fmt: skip
    with pytest.raises(WindFieldError, match=message):
        kaimal_box(**(settings | COMMON | changes))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius": 91.0}, "radius: got 91 m about hub_height = 90 m"),
        ({"rings": 1}, "rings: got 1"),
        ({"spokes": 2}, "spokes: got 2"),
    ],
)
def test_bad_polar_settings(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(WindFieldError, match=message):
        polar_box(1, **changes)


def test_frequencies_below_zero() -> None:
    with pytest.raises(WindFieldError, match="frequency: got -1"):
        kaimal_spectrum([1.0, -1.0], sigma=1.0, mean_speed=U, hub_height=HUB)


# --- boxes kept on disk ---


def test_kept_boxes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = BoxCache(tmp_path / "boxes")
    first = box(1, cache=kept)
    assert first == box(1)
    with monkeypatch.context() as patch:
        patch.setattr("windfield.kaimal._Spectrum._synthesis", lambda *_: pytest.fail("made again"))
        assert box(1, cache=kept) == first
        assert box(1, cache=BoxCache(tmp_path / "boxes")) == first
    # any setting makes it another box
    for changes in ({"scaling": "box"}, {"coupled": "u"}, {"turbulence": "A"}, {"width": 41.0},
                    {"height": 39.0}, {"points": (3, 4)}, {"hub_height": 50.0}):  # fmt: skip
        assert box(1, cache=kept, **changes) == box(1, **changes)
    assert box(2, cache=kept) == box(2)
    assert polar_box(1, cache=kept) == polar_box(1)
    with pytest.raises(WindFieldError, match="seed: got a generator"):
        box(np.random.default_rng(1), cache=kept)  # type: ignore[arg-type]
    assert kept.clear() == 10
    assert replace(box(1, cache=kept), label="x") == replace(first, label="x")
