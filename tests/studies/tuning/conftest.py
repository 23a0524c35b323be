"""Plants with short runs and coarse boxes."""

from __future__ import annotations

import pytest

from pitchopt.studies.tuning import SpeedRegulator, TorqueGain, TuningPlant


@pytest.fixture(scope="package")
def small():
    return TuningPlant(duration=60.0, skip=10.0, box_points=5, box_interval=0.25, workers=1)


@pytest.fixture(scope="package")
def regulator(small):
    return SpeedRegulator(small)


@pytest.fixture(scope="package")
def two_seeds(small):
    return SpeedRegulator(small, seeds=(1, 2))


@pytest.fixture(scope="package")
def gain(small):
    return TorqueGain(small)
