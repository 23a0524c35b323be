"""The exports in ROSCO's own compiled controller, where it is at hand."""

from __future__ import annotations

import json

import pytest


@pytest.fixture(scope="module")
def figures(tmp_path_factory, law, bench):
    if law.find_library() is None:
        pytest.skip("needs libdiscon of ROSCO 2.10.6: the package rosco, or PITCHOPT_LIBDISCON")
    out = tmp_path_factory.mktemp("rosco") / "rosco.json"
    bench.main(["--quick", "--out", str(out)])
    lines = [json.loads(line) for line in out.read_text().splitlines()]
    return {line["measurement"] + line.get("actuator", ""): line for line in lines}


def test_individual_pitch(figures):
    line = figures["individual pitch"]
    assert line["largest_rad"] > 0.01
    # single precision of the swap array
    assert line["library_less_law_rad"] < 1e-7
    assert line["library_less_kernel_rad"] < 1e-7
    assert line["growth_ratio"] == pytest.approx(1.0, abs=0.02)
    assert line["growth_ratio_filter_gain_1"] == pytest.approx(0.5, abs=0.01)


def test_what_acts_of_the_second_harmonic(figures):
    line = figures["second harmonic"]
    assert line["library_less_law_rad"] < 1e-7
    assert abs(line["yaw_rate_ratio"]) < 1e-4


def test_closed_loop(figures):
    line = figures["closed loop"]
    assert line["seconds_filter_gain_default"] == pytest.approx(line["seconds_ours"], rel=0.2)
    assert line["seconds_filter_gain_1"] > 1.7 * line["seconds_ours"]


def test_open_loop(figures):
    assert figures["open loop"]["library_less_profile_rad"] < 1e-6


@pytest.mark.parametrize("actuator", ["first order", "second order"])
def test_lead(figures, actuator):
    line = figures["lead" + actuator]
    assert line["blade_less_profile_with_lead_rad"] < 1e-4 * line["travel_rad"]
    assert line["blade_less_profile_without_rad"] > 0.2 * line["travel_rad"]
