"""Files that are missing, odd or hostile end in one InputError that names the file."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pitchopt.errors import InputError
from pitchopt.turbines import load_turbine, read_windio
from pitchopt.turbines.files import MAX_BYTES, load_json, load_yaml

SAMPLE = Path(__file__).parent / "data" / "nrel5mw_small.yaml"


def refused(path: Path, what: str) -> None:
    """Check that both readers refuse `path` in one line that says `what`."""
    for reader in (read_windio, load_turbine):
        with pytest.raises(InputError) as caught:
            reader(path)
        message = str(caught.value)
        assert str(path) in message
        assert what in message, message
        assert "\n" not in message
        assert len(message) < 400


def test_missing(tmp_path: Path) -> None:
    refused(tmp_path / "none.yaml", "no such file")


def test_directory(tmp_path: Path) -> None:
    folder = tmp_path / "folder.yaml"
    folder.mkdir()
    refused(folder, "is a directory")


def test_name_that_no_file_can_have() -> None:
    with pytest.raises(InputError, match=r"not a file name|no such file"):
        load_turbine("a\0b.yaml")


def test_name_that_is_too_long() -> None:
    with pytest.raises(InputError, match="cannot be read"):
        load_turbine("a" * 5000 + ".yaml")


@pytest.mark.parametrize("text", ["", "  \n\n"])
def test_empty(tmp_path: Path, text: str) -> None:
    file = tmp_path / "empty.yaml"
    file.write_text(text)
    refused(file, "empty")


def test_huge(tmp_path: Path) -> None:
    file = tmp_path / "huge.yaml"
    with file.open("wb") as handle:
        handle.truncate(MAX_BYTES + 1)
    refused(file, f"at most {MAX_BYTES}")


@pytest.mark.parametrize("data", [b"windIO\0version", b"\xff\xfe\x00name", b"name: \xff\xfe"])
def test_binary(tmp_path: Path, data: bytes) -> None:
    file = tmp_path / "binary.yaml"
    file.write_bytes(data)
    with pytest.raises(InputError, match=r"binary file|not UTF-8"):
        read_windio(file)


@pytest.mark.parametrize("keep", [0.3, 0.6, 0.95])
def test_truncated_yaml(tmp_path: Path, keep: float) -> None:
    file = tmp_path / "cut.yaml"
    text = SAMPLE.read_text()
    file.write_text(text[: int(keep * len(text))])
    with pytest.raises(InputError) as caught:
        read_windio(file)
    assert str(file) in str(caught.value)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("a: [1, 2\nb: {", "not valid YAML at line"),
        ("a: !!python/object/apply:os.system ['true']", "explicit tag"),
        ("a: !shell ls", "explicit tag"),
        ("a: &a {x: 1}\nb: {<<: *a}", "merge keys"),
        ("a: 1\nb: 2\na: 3", "key 'a' stands there twice"),
        ("a: *nowhere", "not valid YAML"),
        ("[" * 200_000, "nested more than"),
        ("a: {" * 1000, "nested more than"),
        ("a: 2024-13-45", "not valid YAML"),
        ("? [1, 2]\n: 3", "not valid YAML"),
        ("a: 1\n---\nb: 2", "not valid YAML"),
        ("just a sentence", "expected a mapping"),
        ("[1, 2, 3]", "expected a mapping"),
        ("a: 1", "windIO_version: the key is missing"),
    ],
)
def test_yaml_that_is_not_welcome(tmp_path: Path, text: str, what: str) -> None:
    file = tmp_path / "odd.yaml"
    file.write_text(text)
    refused(file, what)


def test_alias_bomb_and_loop_do_no_harm(tmp_path: Path) -> None:
    lines = ["a0: &a0 [1, 2, 3]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 40)]
    lines += ["loop: &loop [*loop]", "windIO_version: *a39"]
    file = tmp_path / "bomb.yaml"
    file.write_text("\n".join(lines))
    refused(file, "windIO_version: got [[")


def test_json_records(tmp_path: Path) -> None:
    data = Path(load_json.__code__.co_filename).parent / "data" / "nrel-5mw.json"
    record = load_json(data)
    own = tmp_path / "own.json"
    own.write_text(json.dumps(record))
    assert load_turbine(own).rated_power == 5e6
    del record["tower"]["diameter"]
    own.write_text(json.dumps(record))
    with pytest.raises(InputError, match=r"own\.json: tower\.diameter: the key is missing"):
        load_turbine(own)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("{", "not valid JSON at line 1"),
        ("[" * 100_000, "not valid JSON"),
        ("[]", "expected a mapping"),
        ("{}", "format: got ''"),
        ('{"format": "other"}', "format: got 'other'"),
    ],
)
def test_json_that_is_not_welcome(tmp_path: Path, text: str, what: str) -> None:
    file = tmp_path / "odd.json"
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        load_turbine(file)
    assert str(file) in str(caught.value)
    assert what in str(caught.value)


def test_loaders_agree_without_libyaml(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import yaml

    file = tmp_path / "small.yaml"
    file.write_text("a: [1, 2.5, 5e-05]\nb: {c: text}\n")
    fast = load_yaml(file)
    monkeypatch.delattr(yaml, "CSafeLoader", raising=False)
    assert load_yaml(file) == fast == {"a": [1, 2.5, "5e-05"], "b": {"c": "text"}}
