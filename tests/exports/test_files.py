"""Files are written whole or not at all, and nothing else is touched."""

from __future__ import annotations

from pathlib import Path

import pytest

from pitchopt.errors import InputError
from pitchopt.exports import check_folder, write_files, write_whole
from pitchopt.exports.files import read_text


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_files_are_written_and_folders_made(tmp_path):
    paths = write_files(tmp_path / "a" / "b", {"x.txt": "één\n", "y.bin": b"\0\1"})
    assert [p.name for p in paths] == ["x.txt", "y.bin"]
    assert paths[0].read_text(encoding="utf-8") == "één\n"
    assert paths[1].read_bytes() == b"\0\1"


def test_same_names_are_replaced_and_others_stay(tmp_path):
    (tmp_path / "mine.txt").write_text("mine")
    (tmp_path / "x.txt").write_text("old")
    write_whole(tmp_path / "x.txt", "new")
    assert names(tmp_path) == ["mine.txt", "x.txt"]
    assert (tmp_path / "x.txt").read_text() == "new"
    assert (tmp_path / "mine.txt").read_text() == "mine"


def test_one_failure_leaves_nothing(tmp_path):
    (tmp_path / "a.txt").write_text("old")
    with pytest.raises(OSError, match=r"a\.txt"):
        write_files(tmp_path, {"a.txt": "new", "a.txt/b.txt": "a file is no folder"})
    assert names(tmp_path) == ["a.txt"]
    assert (tmp_path / "a.txt").read_text() == "old"


def test_a_name_may_have_a_folder(tmp_path):
    write_files(tmp_path, {"a.txt": "one", "inner/b.txt": "two"})
    assert (tmp_path / "inner" / "b.txt").read_text() == "two"


def test_interruption_while_writing_leaves_nothing(tmp_path, monkeypatch):
    def interrupted(self, target):
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_files(tmp_path, {"a.txt": "new"})
    assert names(tmp_path) == []


def test_permissions_are_those_of_ordinary_files(tmp_path):
    (tmp_path / "plain").touch()
    made = write_whole(tmp_path / "made", "x")
    assert made.stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_check_leaves_nothing_behind(tmp_path):
    folder = tmp_path / "new" / "deeper"
    assert check_folder(folder) == folder
    assert check_folder(tmp_path) == tmp_path
    assert names(tmp_path) == []


@pytest.mark.parametrize("below", ["", "sub"])
def test_check_refuses_a_file(tmp_path, below):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"--out: got .*expected a folder"):
        check_folder(tmp_path / "file" / below, "--out")


def test_check_refuses_a_folder_without_permission(tmp_path, monkeypatch):
    def refused(self, *args, **kwargs):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "open", refused)
    with pytest.raises(InputError, match=r"--out: cannot write to .*Permission denied"):
        check_folder(tmp_path, "--out")


def test_names_that_are_none_are_refused(tmp_path):
    with pytest.raises(InputError, match="out: cannot write"):
        check_folder("a\0b")
    with pytest.raises(InputError, match="table"):
        read_text("a\0b", "table")


@pytest.mark.parametrize(
    ("content", "message"),
    [(b" \n", "empty"), (b"\xff\xfe\x00", "binary|UTF-8"), (b"x" * 101, "101 bytes")],
)
def test_text_that_cannot_be_read(tmp_path, content, message):
    file = tmp_path / "t.csv"
    file.write_bytes(content)
    with pytest.raises(InputError, match=rf"table: .*({message})"):
        read_text(file, "table", max_bytes=100)


def test_missing_text(tmp_path):
    with pytest.raises(InputError, match=r"table: .*no such file"):
        read_text(tmp_path / "none.csv", "table")
