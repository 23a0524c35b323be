"""The tracked model: exact on loads of its own form, and a Kalman filter by the book."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from ilc import Layout
from ilc.experiment import perturbations
from ilc.local_model import LocalModel

SCALE = np.array([1e4, 3e3, 5e3, 200.0])


class Curved:
    """Loads with values, slopes and curvatures of the form that the model has."""

    def __init__(self, layout: Layout, seed: int, bend: float = 1.0) -> None:
        random = np.random.default_rng(seed)
        self.layout = layout
        shape = (4, layout.tracked, layout.blades)
        psi = layout.azimuth[layout.index]
        waves = np.stack([np.ones_like(psi), np.cos(psi), np.sin(psi)], axis=2)
        self.value = SCALE[:, None] * random.normal(size=shape[:2])
        self.slope = 10 * SCALE[:, None, None] * random.normal(size=shape)
        series = bend * 50 * random.normal(size=(4, 3))
        self.curvature = SCALE[:, None, None] * np.einsum("pbw,lw->lpb", waves, series)

    def loads(self, pitch: np.ndarray) -> np.ndarray:
        """Loads (4, P) at pitches (P, B)."""
        linear = np.einsum("lpb,pb->lp", self.slope, pitch)
        return self.value + linear + 0.5 * np.einsum("lpb,pb->lp", self.curvature, pitch**2)

    def slopes(self, pitch: np.ndarray) -> np.ndarray:
        return self.slope + self.curvature * pitch


def experiment(plant: Curved, noise: float = 0.0, seed: int = 0) -> Any:
    offsets = perturbations(plant.layout, 0.01)
    pitch = offsets[:, plant.layout.index]
    loads = np.array([plant.loads(p) for p in pitch])
    random = np.random.default_rng(seed)
    loads += noise * SCALE[:, None] * random.normal(size=loads.shape)
    return pitch, loads, int((~offsets.any(axis=1)).sum())


@pytest.mark.parametrize("blades", [1, 2, 3])
@pytest.mark.parametrize("separate", [False, True])
def test_experiment_gives_the_model(blades: int, separate: bool) -> None:
    layout = Layout(blades=blades, positions=6, separate=separate)
    plant, model = Curved(layout, 1), LocalModel(layout)
    model.identify(*experiment(plant))
    scale = model.scale[:, None, None]
    # to what the least noise that is reckoned with, 1e-4 of the RMS, leaves of the curvature
    error = model.value * scale[..., 0] - plant.value
    assert np.abs(error / SCALE[:, None]).max() < 1e-5
    error = model.slope * scale - plant.slope
    assert np.abs(error / SCALE[:, None, None]).max() < 1e-3
    found, wanted = model.curvature * scale, plant.curvature
    if blades == 2:  # opposite blades move alike or oppositely: their sum is all that shows
        found, wanted = found.sum(axis=2), wanted.sum(axis=2)
    error = np.abs(found - wanted).max(axis=tuple(range(1, found.ndim)))
    assert np.all(error < 1e-3 * np.abs(wanted).max(axis=tuple(range(1, wanted.ndim))))
    np.testing.assert_allclose(model.scale, plant.value.std(axis=1))


def test_missing_samples_are_left_out() -> None:
    layout = Layout(blades=3, positions=8)
    plant, model = Curved(layout, 2), LocalModel(layout)
    pitch, loads, repeats = experiment(plant)
    random = np.random.default_rng(0)
    loads[random.random(loads.shape) < 0.1] = np.nan
    loads[3:, 1, 4] = np.nan  # tilt at position 4 is known at rest alone
    model.identify(pitch, loads, repeats)
    known = np.ones((4, 8), dtype=bool)
    known[1, 4] = False
    error = np.abs(model.slope * model.scale[:, None, None] - plant.slope).max(axis=2)
    assert np.all(error[known] < 1e-3 * np.abs(plant.slope).max())
    # and what is not known is known not to be
    spread = np.sqrt(model.covariance[1, 4].diagonal()[1:].max())
    assert spread > 0.5 * np.abs(model.slope[1]).mean()
    assert spread > 100 * np.sqrt(model.covariance[1, 3].diagonal()[1:].max())


def test_noise_is_seen_and_slopes_have_its_covariance() -> None:
    layout = Layout(blades=3, positions=60)
    plant, model = Curved(layout, 3, bend=0.0), LocalModel(layout)
    off = []
    for seed in range(20):
        model.identify(*experiment(plant, 0.02, seed))
        std = np.sqrt(model.noise) * model.scale
        assert std == pytest.approx(0.02 * SCALE, rel=0.35)
        deviation = np.sqrt(model.covariance[..., [1, 2, 3], [1, 2, 3]])
        off.append((model.slope - plant.slope / model.scale[:, None, None]) / deviation)
    assert np.std(off) == pytest.approx(1.0, rel=0.1)


@pytest.mark.parametrize("separate", [False, True])
def test_moves_along_the_model_are_no_surprise(separate: bool) -> None:
    layout = Layout(blades=3, positions=6, separate=separate)
    plant, model = Curved(layout, 4), LocalModel(layout)
    model.identify(*experiment(plant))
    random = np.random.default_rng(1)
    pitch = np.zeros((layout.tracked, 3))
    for number in range(9):
        rows, _ = layout.visit(number)
        pitch[rows] += 0.005 * random.normal(size=(rows.size, 3))
        model.update(rows, pitch[rows], plant.loads(pitch)[:, rows])
        assert model.surprise.max() < 1e-2
    scale = model.scale[:, None, None]
    error = model.slope * scale - plant.slopes(pitch)
    assert np.abs(error / SCALE[:, None, None]).max() < 0.01


def test_update_is_the_kalman_filter() -> None:
    """One position and load, written out with matrices."""
    layout = Layout(blades=3, positions=5)
    plant, model = Curved(layout, 5), LocalModel(layout)
    model.identify(*experiment(plant, 0.05))
    load, row = 2, 3
    state = np.array([model.value[load, row], *model.slope[load, row]])
    bend, P = model.curvature[load, row], model.covariance[load, row].copy()
    random = np.random.default_rng(2)
    pitch = model.at.copy()
    for _ in range(5):
        d = 0.001 * random.normal(size=(5, 3))
        pitch = pitch + d
        # less noise than in the experiment, so that nothing is left unexplained
        loads = plant.loads(pitch) + 0.01 * SCALE[:, None] * random.normal(size=(4, 5))
        model.update(np.arange(5), pitch, loads)
        move = d[row]
        F = np.eye(4)
        F[0, 1:] = move
        state = F @ state
        state[0] += 0.5 * bend @ move**2
        state[1:] += bend * move
        unknown = model.unknown[load] ** 2 * (move @ move)
        Q = np.diag([0.25 * unknown * (move @ move) + 1e-10, unknown, unknown, unknown])
        P = F @ P @ F.T + Q
        gain = P[:, 0] / (P[0, 0] + model.noise[load])
        state = state + gain * (loads[load, row] / model.scale[load] - state[0])
        P = P - np.outer(gain, P[0])
    np.testing.assert_allclose([model.value[load, row], *model.slope[load, row]], state, rtol=1e-9)
    np.testing.assert_allclose(model.covariance[load, row], P, rtol=1e-7, atol=1e-12)


def test_change_of_wind_is_a_surprise_and_is_followed() -> None:
    layout = Layout(blades=3, positions=8)
    plant, model = Curved(layout, 6), LocalModel(layout)
    model.identify(*experiment(plant, 0.01))
    rest = np.zeros((8, 3))
    rows = np.arange(8)
    for _ in range(5):
        model.update(rows, rest, plant.loads(rest))
    calm = model.covariance[..., 0, 0].max()
    after = Curved(layout, 7)
    model.update(rows, rest, after.loads(rest))
    assert model.surprise.min() > 100
    # the value is the new one at once, or nearly, and slopes are uncertain again
    off = model.value - after.loads(rest) / model.scale[:, None]
    assert np.abs(off).max() < 0.1 * np.abs(after.loads(rest) / model.scale[:, None]).max()
    assert model.covariance[..., 0, 0].max() > calm
    assert np.all(model.covariance[..., 1, 1] > 0.05 * (model.slope**2).mean(axis=(1, 2))[:, None])


def test_covariance_stays_positive() -> None:
    layout = Layout(blades=3, positions=4)
    plant, model = Curved(layout, 8), LocalModel(layout)
    model.identify(*experiment(plant))
    random = np.random.default_rng(3)
    pitch = np.zeros((4, 3))
    for number in range(200):
        pitch = pitch + random.choice([0.0, 1e-6, 0.01]) * random.normal(size=pitch.shape)
        loads = plant.loads(pitch) * (3.0 if number % 50 == 49 else 1.0)
        loads[random.random(loads.shape) < 0.2] = np.nan
        model.update(np.arange(4), pitch, loads)
        eigenvalues = np.linalg.eigvalsh(model.covariance)
        assert np.all(eigenvalues > -1e-9 * eigenvalues.max(axis=-1, keepdims=True))
