"""Storage: files are whole or not there, and what is no saved state is refused."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ilc import StateError, load_state, save_state
from ilc.storage import check_settings, part

STATE = {
    "a": np.array([[1.5, np.nan], [-0.0, np.inf]]),
    "b.text": np.array("Wörter"),
    "b.empty": np.empty((4, 0)),
    "b.flag": np.array(True),
}


def test_arrays_come_back_exactly(tmp_path: Path) -> None:
    path = save_state(tmp_path / "state.npz", STATE)
    again = load_state(path)
    assert again.keys() == STATE.keys()
    for name, value in STATE.items():
        assert again[name].dtype == value.dtype
        np.testing.assert_array_equal(again[name], value)
    assert list(part(again, "b.")) == ["text", "empty", "flag"]


@pytest.mark.parametrize("at", ["open", "replace"])
def test_failed_writing_leaves_the_file_of_before(
    at: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = save_state(tmp_path / "state.npz", STATE)
    before = path.read_bytes()

    def fail(*given: Any, **named: Any) -> Any:
        raise OSError("no space left")

    monkeypatch.setattr(Path, at, fail)
    with pytest.raises(OSError, match="no space left"):
        save_state(path, {"a": np.zeros(3)})
    monkeypatch.undo()
    assert path.read_bytes() == before
    assert [entry.name for entry in tmp_path.iterdir()] == ["state.npz"]


def test_objects_are_neither_written_nor_read(tmp_path: Path) -> None:
    path = tmp_path / "objects.npz"
    objects: Any = np.array([{"a": 1}], dtype=object)
    with pytest.raises(ValueError, match="allow_pickle"):
        save_state(path, {"a": objects})
    assert not path.exists()
    with path.open("wb") as stream:
        np.savez(stream, a=objects)
    with pytest.raises(StateError, match=r"objects\.npz"):
        load_state(path)


def test_missing_files_and_folders_are_errors(tmp_path: Path) -> None:
    for path in (tmp_path / "absent.npz", tmp_path):
        with pytest.raises(StateError, match="cannot be read as a saved state"):
            load_state(path)


@pytest.mark.parametrize("kind", ["text", "array", "cut short", "empty"])
def test_what_is_no_npz_file_is_called_so(kind: str, tmp_path: Path) -> None:
    path = tmp_path / "file.npz"
    if kind == "array":
        with path.open("wb") as stream:
            np.save(stream, np.zeros(3))
    else:
        whole = save_state(tmp_path / "whole.npz", STATE).read_bytes()
        path.write_bytes({"text": b"{}", "cut short": whole[:-9], "empty": b""}[kind])
    with pytest.raises(StateError) as error:
        load_state(path)
    assert str(error.value).endswith("(not an NPZ file, or cut short)")


def test_settings_are_compared_as_they_are_saved() -> None:
    mine = {"a": (1.0, 2.0), "b": None, "c": 0.1}
    check_settings("run", np.array(json.dumps(mine)), mine)
    with pytest.raises(StateError, match=r"run: .*other settings \(a, d\)"):
        check_settings("run", np.array(json.dumps({**mine, "a": [1.0], "d": 2})), mine)
    for damaged in ("", "[1, 2]", "{"):
        with pytest.raises(StateError, match="run: damaged settings"):
            check_settings("run", np.array(damaged), mine)


def test_a_write_removes_old_halves_of_its_own_file_alone(tmp_path: Path) -> None:
    old, young, other = (
        tmp_path / name for name in (".s[1].npz.a.part", ".s[1].npz.b.part", ".t.npz.a.part")
    )
    for path in (old, young, other):
        path.write_bytes(b"half")
    for path in (old, other):
        os.utime(path, (0.0, 0.0))
    save_state(tmp_path / "s[1].npz", {"a": np.zeros(2)})
    assert sorted(tmp_path.iterdir()) == sorted([young, other, tmp_path / "s[1].npz"])
