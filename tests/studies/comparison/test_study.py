"""The comparison: order, fairness, physics of the profiles, resumption, and its report."""

from __future__ import annotations

import dataclasses
import json
import os
import re
import shutil
import subprocess
from html.parser import HTMLParser

import numpy as np
import pytest

from pitchopt.cases import load_case
from pitchopt.control import PitchProfile, TurbineController
from pitchopt.errors import InputError
from pitchopt.exports import document_text
from pitchopt.plotting import method_figures
from pitchopt.sim import Operation
from pitchopt.studies.comparison import (
    LOADS,
    ComparisonSettings,
    compare,
    comparison_csv,
    comparison_document,
    controller_files,
)
from pitchopt.studies.comparison.report import comparison_report
from pitchopt.studies.simulation import controller_from_table
from pitchopt.studies.tuning import FIRST_FRESH
from windfield import BoxCache


def test_winds_go_by_intensity_and_methods_as_in_tables(result):
    assert result.winds == ("none", "C")
    order = [(entry.wind, entry.method) for entry in result.entries]
    methods = ["collective", "feed-forward", "learned", "ipc-zoo", "feed-forward+ipc"]
    assert order == [(wind, method) for wind in ("none", "C") for method in methods]
    assert {entry.status for entry in result.entries} == {"judged"}
    assert result.intensity("none") == 0.0
    assert result.intensity("C") == pytest.approx(0.12 * (0.75 + 5.6 / 15.0), rel=1e-12)


def test_all_are_judged_in_the_same_winds_that_no_tuner_had(result):
    for wind in result.winds:
        judged = {tuple(run.seed for run in e.runs) for e in result.entries if e.wind == wind}
        assert len(judged) == 1
        assert not set(judged.pop()) & set(result.ground.tuning_seeds(wind))
    fresh = [run.seed for run in result.entry("learned", "C").runs]
    assert fresh == [FIRST_FRESH, FIRST_FRESH + 1]


def test_all_have_the_same_collective_control(result):
    """What methods add changes neither torque law nor pitch regulator."""
    for entry in result.entries:
        controller = entry.prepared.controller
        assert isinstance(controller, TurbineController)
        assert controller.torque == result.ground.base.torque
        assert controller.pitch == result.ground.base.pitch


def test_the_blades_move_as_the_design_says(result):
    """Actuators' lag, azimuth and blades are right: pitch over azimuth is the design."""
    entry = result.entry("feed-forward", "none")
    profile = entry.prepared.profile
    harmonics = profile.feedforward.cosine.size
    assert harmonics >= 4
    kept = PitchProfile.from_samples(profile.whole, harmonics=harmonics)
    np.testing.assert_allclose(kept.deviation(profile.azimuth), profile.deviation, atol=1e-12)
    run = result.ground.judge(entry.prepared.controller, "none")[0]
    rows = run.simulation.after(60.0)
    azimuth = rows[:, run.simulation.place("Azimuth")]
    for blade in range(3):
        pitch = rows[:, run.simulation.place(f"BldPitch{blade + 1}")]
        wanted = kept.deviation(azimuth + 2.0 * np.pi * blade / 3.0)
        seen = pitch - pitch.mean()
        assert np.abs(seen - wanted).max() < 0.05 * np.ptp(wanted)  # commands are held for a step


def test_commands_of_the_design_keep_the_rate(result):
    """No harmonic more would; the actuators' lag multiplies by 1 + i n omega tau."""
    profile = result.entry("feed-forward", "none").prepared.profile
    harmonics, lag = profile.feedforward.cosine.size, result.settings.pitch_lag
    omega = result.ground.rotor_speed
    psi = np.linspace(0.0, 2.0 * np.pi, 20_001)

    def fastest(count: int) -> float:
        beta = PitchProfile.from_samples(profile.whole, harmonics=count).deviation(psi)
        command = beta + lag * omega * np.gradient(beta, psi)
        return float(np.abs(omega * np.gradient(command, psi)).max())

    limit = result.ground.rate
    assert limit == result.ground.base.pitch_range.rate
    assert fastest(harmonics) <= limit * (1.0 + 1e-3)
    if harmonics < profile.whole.size // 2:
        assert fastest(harmonics + 1) > limit


def test_the_design_promises_and_the_turbine_keeps_part_of_it(result):
    profile = result.entry("feed-forward", "none").prepared.profile
    assert profile.wake in ("equilibrium", "frozen")
    seen = result.cuts("feed-forward", "none", "rms")
    for load in ("tilt", "yaw"):
        assert profile.predicted[load] > 0.5
        assert seen[load].mean == pytest.approx(profile.predicted[load], abs=0.25)
    for method in ("feed-forward", "learned"):
        found = result.cuts(method, "none")
        assert found["tilt"].mean > 0.4
        assert found["tilt"].half_width is None


def test_turbulence_leaves_little_of_it(result):
    steady, rough = (result.cut("feed-forward", wind, "del", "tilt").mean for wind in ("none", "C"))
    assert rough < 0.4 * steady


def test_efforts_are_counted(result):
    settings, omega = result.settings, result.ground.rotor_speed
    zoo = result.entry("ipc-zoo", "C").prepared.spent
    run = settings.duration + settings.skip
    assert zoo.turbine_time == zoo.simulations * run
    assert zoo.rotations == pytest.approx(zoo.turbine_time * omega / (2.0 * np.pi), rel=1e-12)
    assert zoo.evaluations <= settings.evaluations
    both = result.entry("feed-forward+ipc", "C").prepared.spent
    design = result.entry("feed-forward", "C").prepared.spent
    assert both.rotations > design.rotations
    learned = result.entry("learned", "C").prepared.spent
    turns = learned.evaluations / 3 * (1 + 3 * settings.averaged)
    assert learned.rotations == pytest.approx(turns + 40 + 72, rel=0.03)


def test_beside_individual_pitch_the_design_starts_at_twice_a_turn(result):
    alone = result.entry("feed-forward", "none").prepared.controller.feedforward
    beside = result.entry("feed-forward+ipc", "none").prepared.controller.feedforward
    assert (beside.cosine[0], beside.sine[0]) == (0.0, 0.0)
    np.testing.assert_array_equal(beside.cosine[1:], alone.cosine[1:])
    np.testing.assert_array_equal(beside.sine[1:], alone.sine[1:])


def test_going_on_from_journals_gives_the_same_and_simulates_no_candidate_again(
    result, case, folder
):
    methods = ("ipc-zoo",)
    settings = dataclasses.replace(result.settings, methods=methods, turbulence=("C",))
    again = compare(
        case, settings, workers=1, cache=BoxCache(folder / "boxes"), journals=folder / "journals"
    )
    first, second = result.entry("ipc-zoo", "C"), again.entry("ipc-zoo", "C")
    assert second.prepared.point == first.prepared.point
    assert second.prepared.spent.evaluations == first.prepared.spent.evaluations
    assert second.runs == first.runs
    # only the judged runs of both methods were made
    assert again.ground.plant("C").simulations <= 2 * settings.seeds + 1


def test_document_is_plain_and_csv_has_a_row_for_each(result):
    document = json.loads(document_text(comparison_document(result)))
    assert [w["wind"] for w in document["winds"]] == ["none", "C"]
    for record in document["entries"]:
        assert set(record["del"]) == set(record["rms"]) == set(LOADS)
    tilt = next(
        r for r in document["entries"] if (r["wind"], r["method"]) == ("none", "feed-forward")
    )
    base = next(
        r for r in document["entries"] if (r["wind"], r["method"]) == ("none", "collective")
    )
    assert tilt["del_cut"]["tilt"]["mean"] == pytest.approx(
        1.0 - tilt["del"]["tilt"] / base["del"]["tilt"], rel=1e-12
    )
    lines = comparison_csv(document).splitlines()
    assert len(lines) == 1 + len(document["entries"])


def test_controller_files_give_the_same_controllers(result, tmp_path):
    import tomllib

    operation: Operation = result.ground.operation
    files = controller_files(result)
    assert len(files) == len(result.entries) - len(result.winds)
    for entry in result.entries:
        if entry.method == "collective":
            continue
        name = f"{entry.method.replace('+', '-')}-{entry.wind}.toml"
        mine = entry.prepared.controller
        read = controller_from_table(tomllib.loads(files[name]), operation, folder=tmp_path)
        for part, names in (
            ("feedforward", ("cosine", "sine", "time_constant")),
            ("individual", ("gain", "offset", "order", "limit")),
        ):
            ours, theirs = getattr(mine, part), getattr(read, part)
            assert (ours is None) == (theirs is None)
            for key in names if ours is not None else ():
                np.testing.assert_allclose(getattr(theirs, key), getattr(ours, key), rtol=1e-12)


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ({"wind.shear": "log"}, "wind: got shear 'log'"),
        ({"wind.horizontal_shear": 1e-4}, "wind.horizontal_shear"),
        ({"wind.direction": 0.1}, "wind.direction_deg"),
        ({"operation.yaw": 0.1}, "operation.yaw_deg"),
        ({"wind.speed": 60.0}, "60 m/s"),
    ],
)
def test_a_case_that_cannot_be_simulated_is_refused(case, values, word):
    with pytest.raises(InputError, match=word):
        compare(case.with_values(values), ComparisonSettings())


def test_a_turbine_without_structure_is_refused():
    with pytest.raises(InputError, match="structure"):
        compare(load_case("biegel2011"), ComparisonSettings())


@pytest.mark.parametrize(
    ("values", "word"),
    [
        ({"methods": ("ipc-bayse",)}, "did you mean 'ipc-bayes'"),
        ({"turbulence": ("D",)}, "turbulence: got 'D'"),
        ({"turbulence": ("1.5",)}, "intensity"),
        ({"turbulence": ()}, "at least one wind"),
        ({"seeds": 0}, "seeds"),
        ({"evaluations": 0}, "evaluations"),
        ({"duration": 1.0}, "duration"),
        ({"pitch_lag": -1.0}, "pitch_lag"),
    ],
)
def test_bad_settings(values, word):
    with pytest.raises(InputError, match=word):
        ComparisonSettings(**values)


def test_a_method_that_cannot_be_had_says_so_and_the_others_go_on(case):
    """A learner puts no price on travel."""
    settings = ComparisonSettings(
        turbulence=("none",), methods=("learned",), duration=20.0, skip=20.0
    )
    result = compare(case.with_values({"objective.travel": 1.0}), settings)
    entry = result.entry("learned", "none")
    assert entry.status == "failed"
    assert "travel" in entry.message
    assert result.entry("collective", "none").status == "judged"
    document = comparison_document(result)
    assert "del" not in document["entries"][1]


# ---- the HTML report ---------------------------------------------------------------------
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


@pytest.fixture(scope="module")
def page(result):
    document = comparison_document(result)
    command = 'pitchopt compare --out "a <b>" --report'
    return comparison_report(document, method_figures(document, result.excerpts), command=command)


class _Links(HTMLParser):
    """All that a page could load, and its tags."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.tags: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        if tag not in ("meta", "link", "img"):
            self.open.append(tag)
        self.links += [value for key, value in attrs if key in ("src", "href", "srcset")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_everything_is_in_the_page(page):
    found = _Links()
    found.feed(page)
    assert found.open == []
    assert all(link.startswith("data:") for link in found.links)
    assert "script" not in found.tags
    assert found.tags.count("img") == 3
    assert not re.search(r"url\(|@import|http-equiv=.refresh", page)
    assert "default-src 'none'" in page


def test_text_is_escaped(page):
    assert "a &lt;b&gt;" in page
    assert "<b>" not in page


def test_it_says_what_was_found(page):
    for words in (
        "Where the feed-forward profile pays",
        "Where the learned profile pays",
        "What each had to know",
        "What each took",
        "What the tuners chose",
        "Turbulence of class C, intensity 13.5 %, 15 m/s",
        "seeds that no method has met: 2",
        "Fewer than 6 are too few to conclude from",
        "The static model (",
    ):
        assert words in page


@pytest.mark.slow
def test_a_browser_without_network_draws_it(page, tmp_path):
    browser = next((path for name in BROWSERS if (path := shutil.which(name))), None)
    if browser is None:
        pytest.skip(f"no browser: none of {', '.join(BROWSERS)} on PATH")
    from matplotlib.image import imread

    target, picture = tmp_path / "report.html", tmp_path / "report.png"
    target.write_text(page, encoding="utf-8")
    arguments = [
        browser, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync",
        "--host-resolver-rules=MAP * ~NOTFOUND", "--enable-logging=stderr", "--v=0",
        f"--user-data-dir={tmp_path / 'profile'}", "--window-size=1200,4000",
    ]  # fmt: skip
    environment = {**os.environ, "HOME": str(tmp_path)}
    done = subprocess.run(
        [*arguments, f"--screenshot={picture}", target.as_uri()],
        capture_output=True, text=True, timeout=120, env=environment, check=False,
    )  # fmt: skip
    assert picture.is_file(), done.stderr[-2000:]
    assert "CONSOLE" not in done.stderr, done.stderr[-2000:]  # nothing refused, nothing missing
    drawn = imread(picture)[..., :3]
    assert drawn.shape[:2] == (4000, 1200)
    # bars of the pictures in their colours, which the text has not
    for colour in ((0x00, 0x72, 0xB2), (0x00, 0x9E, 0x73)):
        near = np.abs(drawn - np.array(colour) / 255.0).max(axis=2) < 0.02
        assert near.sum() > 200
