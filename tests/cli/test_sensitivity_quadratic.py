"""``pitchopt sensitivity --problem quadratic``."""

import json

import pytest
from click.testing import CliRunner

from pitchopt.cli.main import main, program


def test_document_and_files(tmp_path):
    found = CliRunner().invoke(
        program, ["sensitivity", "--problem", "quadratic", "--json", "--out", str(tmp_path / "q")]
    )
    assert found.exit_code == 0
    document = json.loads(found.stdout)
    assert [family["key"] for family in document["families"]] == ["c2", "c4", "c5"]
    assert [len(family["curves"]) for family in document["families"]] == [3, 3, 1]
    last = document["families"][2]["curves"][0]
    place = last["dc"].index(0.5)
    # -5 c^2 + 6 c + 1 = 2.75 at c = 0.5, where h0 = 2 holds x1: 0.1 (4 - 1) - 5 (2 - 1)
    assert last["truth"][place] == pytest.approx(-4.7, abs=1e-6)
    # the old design and its multiplier 5 - 0.2 know 2.75 alone
    assert last["high_order"][place] == pytest.approx(-4.8 * 1.75, abs=1e-4)
    assert last["broken"]["A3 active set"] == pytest.approx(0.2, abs=0.03)
    names = sorted(path.name for path in (tmp_path / "q").iterdir())
    assert names == ["c2.png", "c4.png", "c5.png", "sensitivity.json"]


def test_table(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["sensitivity", "--problem", "quadratic", "--no-plots", "--out", "q"]) == 0
    text = capsys.readouterr().out
    assert "solved again" in text and "A2 coupling looks broken" in text


def test_options_of_other_problems_are_refused(capsys):
    assert main(["sensitivity", "--problem", "quadratic", "--mu", "3"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "--mu: got it with --problem quadratic" in error
