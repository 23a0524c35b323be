"""Every example runs, shortened, in a folder of its own."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parents[2] / "examples"
EXAMPLES = sorted(FOLDER.glob("[0-9]*.py"))

WRITES = {
    "01_wind_field": ["01_wind_field.png"],
    "02_polar_fit": ["02_polar_fit.png"],
    "03_tradeoff_curve": ["03_tradeoff_curve.png"],
    "04_profiles_and_loads": ["04_loads.png", "04_profiles.png"],
    "05_own_turbine": ["05_loads.png"],
    "06_max_power_loss": ["06_harmonics.csv"],
    "07_own_wind": ["07_own_wind.png"],
    "08_curves_from_another_code": ["08_curves.csv"],
    "09_aerodyn_motion_files": ["09_aerodyn"],
    "10_own_constraints": ["10_own_constraints.csv"],
    "11_several_winds": [
        "11_profiles_mean.png",
        "11_profiles_regret.png",
        "11_regrets_mean.png",
        "11_regrets_regret.png",
    ],
    "12_schedule": ["12_schedule.csv"],
    "13_learning": ["13_adaptive.png", "13_paper.png"],
    "14_own_plant": ["14_convergence.png"],
    "15_turbulence": [
        "15_individual_pitch.png",
        "15_series.csv",
        "15_tower_damper.png",
        "15_tuned.png",
    ],
    "16_steady_curves": ["16_steady_curves.png"],
    "17_learning_on_the_turbine": ["17_flexible.png", "17_rigid.png", "17_turbulent.png"],
    "18_campbell": ["18_campbell.png"],
    "19_bayesian_steps": ["19_design_space.png", "19_steps.png"],
    "20_tune_speed_regulator": ["20_design_space.png", "20_samples.png", "20_series.png"],
    "21_torque_gain": ["21_8_alone.png", "21_three_winds.png", "21_torque.png"],
    "22_tune_individual_pitch": [
        "22_progress.png",
        "22_samples.png",
        "22_samples_rectangular.png",
    ],
    "23_minimum_pitch": ["23_nrel-5mw_breakpoint.png", "23_nrel-5mw_tables.png"],
    "24_grid_comparison": ["24_comparison.png"],
    "25_sequence": ["25_checks.png", "25_lowest_pitch.png"],
    "26_dask_cluster": ["26_evaluations.csv", "26_study.sqlite"],
    "27_sensitivity_quadratic": [
        "27_c2_linearity.png",
        "27_c2_with_one_half.png",
        "27_c4_coupling.png",
        "27_c5_active_set.png",
    ],
    "28_sensitivity_design": ["28_curves.png", "28_sensitivity.csv", "28_sensitivity.png"],
    "29_tower": ["29_tower.png"],
    "30_rosco_open_loop": ["30_lead.png", "30_rosco"],
    "31_rosco_individual_pitch": ["31_band_pass.png", "31_discon_ipc.txt"],
    "32_csv_and_harmonics": ["32_harmonics.csv", "32_profile.csv"],
    "33_compare": ["33_changes.png", "33_compare.html"],
}
MORE = {"26_dask_cluster": ["--lose-a-worker"]}
SAYS = {"26_dask_cluster": ("killed midway", "both tables are the same")}
SLOW = ["05", "09", "11", "15", "16", "17", "22", "23", "24", "25", "26", "27", "28", "29"]
NEEDS = {"26_dask_cluster": "distributed"}


def load(path):
    spec = importlib.util.spec_from_file_location(f"example_{path.stem}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_example_is_listed():
    assert [path.stem for path in EXAMPLES] == list(WRITES)
    page = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| `([^`]+)\.py`", page, re.MULTILINE) == list(WRITES)


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=[pytest.mark.slow] * (path.stem[:2] in SLOW)) for path in EXAMPLES],
    ids=[path.stem for path in EXAMPLES],
)
def test_example(path, tmp_path, monkeypatch, capsys):
    if path.stem in NEEDS:
        pytest.importorskip(NEEDS[path.stem], reason="comes with an extra")
    monkeypatch.chdir(tmp_path)
    assert not load(path).main(["out", "--quick", *MORE.get(path.stem, ())])
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == WRITES[path.stem]
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
    text = capsys.readouterr().out
    assert text.strip()
    for word in ("infeasible", "failed", "iteration limit"):
        assert word not in text
    for word in SAYS.get(path.stem, ()):
        assert word in text


def test_cluster_without_dask_says_what_to_install(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(SystemExit) as end:
        load(FOLDER / "26_dask_cluster.py").main([str(tmp_path / "out"), "--quick"])
    assert end.value.code == 1
    assert capsys.readouterr().err == "Dask is not installed: pip install 'pitchopt[dask]'\n"
    assert not (tmp_path / "out").exists()
