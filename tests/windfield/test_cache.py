"""Boxes kept on disk: damage, foreign files, limits."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from windfield import BoxCache, WindFieldError
from windfield.cache import SUFFIX

SETTINGS = {"kind": "test", "seed": 1}
VALUES = np.random.default_rng(0).standard_normal((4, 3, 3, 3)).astype(np.float32)


class Maker:
    """Gives the velocities and counts how often it was asked."""

    calls = 0

    def __call__(self) -> np.ndarray:
        self.calls += 1
        return VALUES


def only_file(folder: Path) -> Path:
    (path,) = folder.iterdir()
    return path


def test_made_once(tmp_path: Path) -> None:
    make, kept = Maker(), BoxCache(tmp_path)
    for _ in range(3):
        np.testing.assert_array_equal(kept.velocity(SETTINGS, make), VALUES)
    assert make.calls == 1
    kept.velocity(SETTINGS | {"seed": 2}, make)
    assert make.calls == 2 and len(list(tmp_path.iterdir())) == 2
    # the order of the settings does not matter
    kept.velocity({"seed": 1, "kind": "test"}, make)
    assert make.calls == 2


def damage_cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-200])


def damage_flip(path: Path) -> None:
    raw = bytearray(path.read_bytes())
    start = raw.find(VALUES.tobytes()[:16])
    assert start > 0
    raw[start + 40] ^= 1
    path.write_bytes(bytes(raw))


def damage_empty(path: Path) -> None:
    path.write_bytes(b"")


def damage_text(path: Path) -> None:
    path.write_text("not a box")


def damage_other_settings(path: Path) -> None:
    with path.open("wb") as stream:
        np.savez(stream, velocity=VALUES + 1, settings=np.array(json.dumps({"kind": "other"})))


def damage_pickle(path: Path) -> None:
    text = str(np.load(path)["settings"])
    with path.open("wb") as stream:
        np.savez(stream, velocity=np.array([{}], dtype=object), settings=np.array(text))


def damage_type(path: Path) -> None:
    text = str(np.load(path)["settings"])
    with path.open("wb") as stream:
        np.savez(stream, velocity=VALUES.astype(np.float64), settings=np.array(text))


def damage_plain_array(path: Path) -> None:
    with path.open("wb") as stream:
        np.save(stream, VALUES)


def damage_missing(path: Path) -> None:
    text = str(np.load(path)["settings"])
    with path.open("wb") as stream:
        np.savez(stream, settings=np.array(text))


@pytest.mark.parametrize(
    "damage",
    [damage_cut, damage_flip, damage_empty, damage_text, damage_other_settings, damage_pickle,
     damage_type, damage_missing, damage_plain_array],
)  # fmt: skip
def test_damaged_files_are_made_again(tmp_path: Path, damage: object) -> None:
    make, kept = Maker(), BoxCache(tmp_path)
    kept.velocity(SETTINGS, make)
    damage(only_file(tmp_path))  # type: ignore[operator]
    np.testing.assert_array_equal(kept.velocity(SETTINGS, make), VALUES)
    assert make.calls == 2
    np.testing.assert_array_equal(kept.velocity(SETTINGS, make), VALUES)
    assert make.calls == 2


def test_least_recently_used_go_first(tmp_path: Path) -> None:
    make = Maker()
    kept = BoxCache(tmp_path)
    for seed in range(4):
        kept.velocity({"seed": seed}, make)
    size = only_file_size(tmp_path)
    for age, path in enumerate(sorted(tmp_path.iterdir())):
        os.utime(path, (1e9 - age, 1e9 - age))
    kept.velocity({"seed": 0}, make)  # used now
    small = BoxCache(tmp_path, limit=2 * size)
    small.velocity({"seed": 9}, make)
    assert make.calls == 5 and len(list(tmp_path.iterdir())) == 2
    small.velocity({"seed": 0}, make)
    small.velocity({"seed": 9}, make)
    assert make.calls == 5
    none = BoxCache(tmp_path, limit=0)
    none.velocity({"seed": 10}, make)
    assert len(list(tmp_path.iterdir())) == 1  # the last one stays


def only_file_size(folder: Path) -> int:
    (size,) = {path.stat().st_size for path in folder.iterdir()}
    return size


def test_clearing_leaves_other_files(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    kept = BoxCache(tmp_path)
    kept.velocity(SETTINGS, Maker())
    assert kept.clear() == 1 and kept.clear() == 0
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


def test_folder_of_the_user(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert BoxCache().folder == tmp_path / "cache" / "windfield"
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    for value in ("", "relative"):
        monkeypatch.setenv("XDG_CACHE_HOME", value)
        assert BoxCache().folder == tmp_path / "home" / ".cache" / "windfield"


def test_a_folder_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(WindFieldError, match="file: cannot be made or is not a folder"):
        BoxCache(tmp_path / "file")
    with pytest.raises(WindFieldError, match="limit: got -1"):
        BoxCache(tmp_path, limit=-1)


def test_a_box_that_cannot_be_stored_is_returned(tmp_path: Path) -> None:
    make, kept = Maker(), BoxCache(tmp_path / "boxes")
    (tmp_path / "boxes").rmdir()
    for calls in (1, 2):
        np.testing.assert_array_equal(kept.velocity(SETTINGS, make), VALUES)
        assert make.calls == calls


def test_nothing_temporary_is_left(tmp_path: Path) -> None:
    BoxCache(tmp_path).velocity(SETTINGS, Maker())
    assert only_file(tmp_path).name.endswith(SUFFIX)
