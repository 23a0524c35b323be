"""What a shell may complete: names, several names, files with an ending, folders.

A shell asks at every press of a key, so nothing of the library loads here: the names stand here
once more, and the tests hold them to those of the library.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from click.shell_completion import CompletionItem

__all__ = [
    "COMPARED",
    "CONTROLLERS",
    "METHODS",
    "PROBLEMS",
    "SHELLS",
    "TURBULENCE",
    "Names",
    "completed",
    "script",
    "turbines",
]

Names = Sequence[str] | Callable[[], Sequence[str]]

SHELLS = ("bash", "zsh", "fish")
TURBULENCE = ("A+", "A", "B", "C")
"""Classes of turbulence of IEC 61400-1."""
CONTROLLERS = ("baseline", "tuned", "lqr", "ipc")
PROBLEMS = ("torque-gain", "speed-regulator", "minimum-pitch", "individual-pitch")
METHODS = (
    *("zoo", "bayes", "grid", "random", "lhs", "sobol", "spsa", "nelder-mead", "cobyla"),
    "cma-es",
)

COMPARED = (
    *("collective", "feed-forward", "learned", "ipc-handbook", "ipc-grid", "ipc-zoo"),
    *("ipc-bayes", "feed-forward+ipc"),
)

_CATALOGUE = Path(__file__).parents[1] / "turbines" / "data"


def completed(
    incomplete: str,
    names: Names = (),
    endings: Sequence[str] = (),
    *,
    several: bool = False,
) -> list[CompletionItem]:
    """What may stand where `incomplete` was typed.

    Parameters
    ----------
    incomplete : str
        What was typed so far.
    names : sequence of str, or function
        Names that are known.
    endings : sequence of str
        Endings of files that are taken as well, such as ``.toml``; ``/`` for folders alone.
        Without any match the shell looks for itself, which leads it into folders.
    several : bool
        Whether names may be separated by commas.
    """
    if tuple(endings) == ("/",):
        return [CompletionItem(incomplete, type="dir")]
    known = names() if callable(names) else names
    head, comma, tail = incomplete.rpartition(",") if several else ("", "", incomplete)
    before = head.split(",") if comma else []
    found = [name for name in known if name.startswith(tail) and name not in before]
    if endings:
        found += _files(incomplete, endings)
        if all(name.endswith("/") for name in found):
            return [CompletionItem(incomplete, type="file")]
    return [CompletionItem(head + comma + name) for name in found]


def _files(incomplete: str, endings: Sequence[str]) -> list[str]:
    """Files with one of the endings, and folders, that go on from what was typed."""
    folder, slash, start = incomplete.rpartition("/")
    try:
        entries = sorted(Path(folder + slash or ".").iterdir())
    except OSError:
        return []
    return [
        folder + slash + entry.name + ("/" if entry.is_dir() else "")
        for entry in entries
        if entry.name.startswith(start)
        and (start.startswith(".") or not entry.name.startswith("."))
        and (entry.is_dir() or entry.name.endswith(tuple(endings)))
    ]


def turbines() -> Sequence[str]:
    """Keys of the catalogue, which are the names of the built-in cases as well."""
    return sorted(path.stem for path in _CATALOGUE.glob("*.json"))


def script(shell: str) -> str:
    """Text that teaches a shell to complete the program's command line."""
    from click.shell_completion import get_completion_class

    from pitchopt.cli.main import program

    kind = get_completion_class(shell)
    if kind is None:
        raise KeyError(shell)
    text = kind(program, {}, "pitchopt", "_PITCHOPT_COMPLETE").source()
    # click's script for fish would cut a value at its first comma
    return text.replace('string split "," ', 'string split -m 1 "," ')
