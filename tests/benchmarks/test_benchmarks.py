"""Every benchmark runs with tiny sizes and writes the figures that its README promises."""

from __future__ import annotations

import functools
import importlib
import json
import math
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from pitchopt.tuning import run_study

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "benchmarks"
SCRIPTS = sorted(path.stem for path in FOLDER.glob("[a-z]*.py"))
FIGURES = {
    "comparison": {
        "method in wind": ["method", "intensity", "del_cut", "rms_cut", "spent", "seeds"],
        "comparison": ["verdict", "design", "settings", "seconds"],
    },
    "curve": {
        "import": ["seconds", "bare_python_seconds", "seconds_aim"],
        "curve": ["seconds", "points", "certified", "gap_largest_percent", "converged"],
        "command": ["seconds", "files"],
    },
    "direct_vs_cvxpy": {
        "subproblem": ["ratio", "ratio_aim", "direct_solver_share", "direct_assembly_share"],
    },
    "growth": {
        "run, positions": ["seconds", "subproblems", "seconds_per_subproblem", "peak_memory_mb"],
        "exponent, positions": ["exponent_run", "exponent_subproblem", "exponent_bound", "aim"],
        "largest": ["seconds", "point_seconds_aim", "bound_seconds", "peak_memory_mb"],
    },
    "learning": {
        "time of a rotation": ["milliseconds", "milliseconds_rate_binding", "milliseconds_aim"],
        "learner x condition": ["ratio_median_at_10", "ratio_worst_at_10", "seeds"],
    },
    "simulate": {
        "turbulence box": ["seconds", "seconds_aim", "slices"],
        "speed": ["milliseconds_per_second", "milliseconds_aim", "nanoseconds_per_element"],
        "convergence": ["power_ratio", "TwrBsMyt_del_ratio", "error_check"],
    },
    "robust": {
        "design": ["cpu_seconds", "cpu_seconds_own_optima", "gap_percent", "largest_regret"],
        "exponent": ["exponent_design", "exponent_joint", "exponent_bound", "exponent_regret"],
    },
    "proof": {
        "least RMS for a loss": [
            "gap_percent",
            "gap_checked_percent",
            "gap_hull_percent",
            "regions",
        ],
    },
    "random_starts": {
        "point": ["kind", "mu", "gain_percent", "random_kind", "starts", "finished", "cpu_seconds"],
        "flattened optimum": ["applies", "gain_percent", "rms_weighted", "flat_rms_weighted"],
        "case": ["gain_largest_percent", "gains_above_aim", "points", "curve_cpu_seconds"],
    },
    "tuners": {
        "run": ["function", "noise", "tool", "run", "regrets", "seconds_per_suggestion"],
        "regret": ["pitchopt_median", "skopt_median", "p_loss", "p_gain", "better", "worse"],
        "suggestion": ["tool", "samples", "seconds", "seconds_aim"],
    },
    "tuning_problems": {
        "study": ["problem", "method", "gain", "fresh_gain", "evaluations", "simulations"],
        "problem": ["problem", "order", "fresh_gains", "gains", "check_seeds"],
    },
    "tuning_scaling": {
        "study": ["method", "workers", "evaluations_per_second", "share_asking", "share_writing"],
        "limit": ["method", "efficiency", "ask_limit_per_second", "speedup"],
    },
    "sensitivity": {
        "convex program": ["ratio", "ratio_not_judged", "error_high_order", "rows"],
        "set of simulations": ["seconds", "seconds_aim", "simulations"],
        "sizing": ["seconds", "slsqp_seconds", "mass_difference", "slsqp_largest_violation"],
    },
    "rosco": {
        "individual pitch": ["library_less_law_rad", "kernel_less_law_rad", "growth_ratio"],
        "second harmonic": ["library_less_law_rad", "tilt_rate_ratio", "yaw_rate_ratio"],
        "closed loop": ["seconds_ours", "seconds_filter_gain_default", "seconds_filter_gain_1"],
        "open loop": ["rows", "library_less_profile_rad", "travel_rad"],
        "lead": ["actuator", "blade_less_profile_with_lead_rad"],
    },
    "scp_vs_ipopt": {
        "trade-off point": ["ratio", "objective_lead_percent", "ratio_is_lower_bound"],
        "summary": ["formulations", "fastest_formulation"],
    },
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("results")


def run(script, *arguments, **environment):
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, str(FOLDER / f"{script}.py"), "--quick", *arguments],
        check=False,
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": path, **environment},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@functools.cache
def quick(script, out):
    return run(script, "--out", out)


def by_measurement(text):
    lines = [json.loads(line) for line in text.splitlines()]
    return lines, {line["measurement"]: line for line in lines}


def test_every_script_is_listed():
    assert sorted(FIGURES) == SCRIPTS


@pytest.mark.slow
@pytest.mark.parametrize("script", SCRIPTS)
def test_quick_run(script, folder):
    if script == "scp_vs_ipopt":
        pytest.importorskip("casadi", reason="comes with the extra 'bench'")
    if script == "tuners":
        pytest.importorskip("skopt", reason="comes with the extra 'bench'")
    if script.startswith("tuning"):
        pytest.importorskip("cma", reason="comes with the extra 'cma'")
    out = folder / script / f"{script}.json"
    text = quick(script, str(out))
    if script == "rosco" and "no library" in text:
        pytest.skip("needs ROSCO's library, see benchmarks/_rosco.py")
    assert out.read_text(encoding="utf-8") == text
    assert [path.name for path in out.parent.iterdir()] == [out.name]
    lines, found = by_measurement(text)
    assert set(FIGURES[script]) == set(found)
    for line in lines:
        assert line["benchmark"] == script
        assert line["quick"] is True
        assert line["seed"] == 0
        where = line["environment"]
        assert {"python", "numpy", "scipy", "clarabel", "cvxpy", "casadi"} == set(where["versions"])
        assert where["cpu"] and where["cores"] >= 1
        assert str(ROOT) not in json.dumps(line)
    for measurement, figures in FIGURES[script].items():
        assert set(figures) <= set(found[measurement])
    for line in lines:
        for name in ("ratio", "seconds", "peak_memory_mb"):
            if name in line and line["measurement"] != "import":  # a difference, may be noise
                assert line[name] > 0
        for name, value in line.items():
            assert not isinstance(value, float) or math.isfinite(value), name


def test_paths_agree(folder):
    out = folder / "direct_vs_cvxpy" / "direct_vs_cvxpy.json"
    _, found = by_measurement(quick("direct_vs_cvxpy", str(out)))
    line = found["subproblem"]
    assert line["solved_by_direct"] == line["solved_by_cvxpy"] == line["subproblems"]
    assert line["value_difference_largest"] < 1e-5


def test_random_starts_go_on_where_a_run_ended(folder):
    out = folder / "random_starts" / "random_starts.json"
    text = quick("random_starts", str(out))
    assert run("random_starts", "--out", str(out)) == ""
    assert out.read_text(encoding="utf-8") == text


def test_tuning_problems_go_on_where_a_run_ended(folder):
    out = folder / "tuning_problems" / "tuning_problems.json"
    lines = quick("tuning_problems", str(out)).splitlines()
    studies = [line for line in lines if json.loads(line)["measurement"] == "study"]
    out.write_text("\n".join(studies[:-1]) + "\n", encoding="utf-8")
    again = run("tuning_problems", "--out", str(out)).splitlines()
    (made,) = [line for line in again if json.loads(line)["measurement"] == "study"]
    before, after = ({**json.loads(x), "evaluation_seconds": None} for x in (studies[-1], made))
    assert before == after


@pytest.mark.parametrize("method", ["sobol", "cma-es", "zoo", "bayes"])
@pytest.mark.parametrize("workers", [1, 4])
def test_simulated_study_asks_what_a_real_one_does(method, workers, monkeypatch):
    if method == "cma-es":
        pytest.importorskip("cma", reason="comes with the extra 'cma'")
    monkeypatch.syspath_prepend(str(FOLDER))
    scaling = importlib.import_module("tuning_scaling")
    simulated, real = (scaling.tuner_of(method, 20) for _ in range(2))
    figures = scaling.simulated(simulated, workers, 20)
    with ThreadPoolExecutor(workers) as executor:
        run_study(scaling.landscape(), real, evaluations=20, parallel=workers, executor=executor)
    assert [e.x.tolist() for e in simulated.evaluations] == [e.x.tolist() for e in real.evaluations]
    assert figures["evaluations"] == len(real.evaluations)
    assert figures["simulated_seconds"] > 0.9 * figures["evaluations"] / workers


def test_scaling_is_drawn(tmp_path):
    pytest.importorskip("cma", reason="comes with the extra 'cma'")
    picture = tmp_path / "scaling.png"
    run("tuning_scaling", "--plot", str(picture))
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_without_casadi_the_comparison_is_skipped(tmp_path):
    (tmp_path / "casadi.py").write_text("raise ImportError\n", encoding="utf-8")
    path = os.pathsep.join([str(tmp_path), str(ROOT)])
    lines, found = by_measurement(run("scp_vs_ipopt", PYTHONPATH=path))
    assert len(lines) == 1
    assert "casadi" in found["skipped"]["reason"]
