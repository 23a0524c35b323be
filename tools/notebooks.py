"""Make the paired ``.ipynb`` of every notebook text, run it from top to bottom, keep what it drew.

The texts are ``notebooks/N_*.py`` and ``notebooks/solutions/N_*.py`` in jupytext's percent format;
their header says where the pair goes (``notebooks/build/``).  Nothing is hidden: a cell that
raises, an error inside a slider's function, anything on standard error (warnings), a file left
behind or a run over the time limit fails the build.  The kernel is the Python that runs this
script, in an empty folder, with no start-up files.

    python tools/notebooks.py [FOLDER] [--only 3] [--texts | --solutions] [--jobs 2] [--limit 300]
                              [--pictures OUT]
"""

from __future__ import annotations

import argparse
import base64
import os
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1] / "notebooks"
LIMIT = 300.0  # [s] from the start of the kernel to its end


class NotebookError(Exception):
    """A notebook that must not pass, with what it did."""


def sources(root: Path = ROOT) -> list[Path]:
    """All texts in order: the notebooks, then their solutions."""
    return [*sorted(root.glob("[0-9]*.py")), *sorted((root / "solutions").glob("[0-9]*.py"))]


def pair(text: Path) -> Path:
    """Where the header of a text puts its ``.ipynb``."""
    import jupytext
    from jupytext.formats import long_form_multiple_formats
    from jupytext.paired_paths import paired_paths

    declared = jupytext.read(text).metadata.get("jupytext", {}).get("formats", "")
    formats = long_form_multiple_formats(declared)
    mine = next((f for f in formats if f["extension"] == ".py"), None)
    if mine is None:
        raise NotebookError(
            f"{text.name}: its header pairs it with nothing, got formats {declared!r}"
        )
    found = [Path(path) for path, _ in paired_paths(str(text), mine, formats)]
    notebooks = [path for path in found if path.suffix == ".ipynb"]
    if len(notebooks) != 1:
        raise NotebookError(f"{text.name}: expected one .ipynb in its header, got {declared!r}")
    return notebooks[0]


def run(text: Path, limit: float = LIMIT) -> tuple[Path, float]:
    """Make and execute one notebook and write it; its path and the seconds that it took.

    The notebook is written in any case, up to and with the cell that failed.

    Raises
    ------
    NotebookError
        If a cell or a slider raises, warns, leaves a file behind, or the time is up.
    """
    import jupytext
    import nbformat
    from nbclient.exceptions import CellExecutionError, CellTimeoutError, DeadKernelError

    target = pair(text)
    notebook = jupytext.read(text)
    target.parent.mkdir(parents=True, exist_ok=True)
    problems: list[str] = []
    with (
        tempfile.TemporaryDirectory(prefix="notebook-") as folder,
        tempfile.TemporaryDirectory(prefix="ipython-") as settings,
    ):
        began = time.monotonic()
        client = _client(notebook, folder, lambda _: max(began + limit - time.monotonic(), 0.01))
        try:
            client.execute(env=_environment(settings))
        except CellTimeoutError:
            problems.append(f"not done after {limit:g} s")
        except CellExecutionError as error:
            problems.append(str(error).strip())
        except (DeadKernelError, RuntimeError) as error:  # died, or never answered
            problems.append(f"the kernel died: {error}")
        seconds = time.monotonic() - began
        left = sorted(path.name for path in Path(folder).iterdir())
    nbformat.write(notebook, target)
    if seconds > limit and not problems:
        problems.append(f"took {seconds:.0f} s, allowed are {limit:g} s")
    if left:
        problems.append(f"left files behind: {', '.join(left)}")
    problems += complaints(notebook)
    if problems:
        raise NotebookError(f"{text.name}: " + "\n".join(problems))
    return target, seconds


def _client(notebook: Any, folder: str, timeout: Any) -> Any:
    from jupyter_client.kernelspec import KernelSpec, KernelSpecManager
    from jupyter_client.manager import AsyncKernelManager
    from nbclient import NotebookClient
    from nbclient.output_widget import OutputWidget

    class Recorded(OutputWidget):
        """What a slider drew, kept here.

        nbclient would send it to the kernel too, on the channel where it waits for the answer of
        the cell; now and then the next cell is then never sent.  It is a known fault of nbclient.
        """

        def send(self, *args: Any, **kwargs: Any) -> None:
            """Tell the kernel nothing."""

    class OwnPython(KernelSpecManager):
        """The interpreter that runs the script, whatever kernels are registered on the machine."""

        def get_kernel_spec(self, kernel_name: str) -> KernelSpec:
            command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
            command.append("--log-level=ERROR")  # of the kernel itself, not of the cells
            return KernelSpec(argv=command, display_name=kernel_name, language="python")

    client = NotebookClient(
        notebook,
        km=AsyncKernelManager(
            kernel_name="python3",
            kernel_spec_manager=OwnPython(),
            cache_ports=True,  # kernels that start at the same time must not share a port
        ),
        resources={"metadata": {"path": folder}},
        timeout_func=timeout,
        allow_errors=False,
        force_raise_errors=True,  # no tag of a cell may excuse an error
        store_widget_state=True,
    )
    client.widget_registry = {"@jupyter-widgets/output": {"OutputModel": Recorded}}
    return client


def _environment(settings: str) -> dict[str, str]:
    """The environment with figures inline, warnings shown and nobody's IPython profile."""
    out = {k: v for k, v in os.environ.items() if k not in {"MPLBACKEND", "PYTHONWARNINGS"}}
    return {**out, "IPYTHONDIR": settings}


def outputs(notebook: Any) -> list[Any]:
    """Outputs of all cells, and those that the sliders drew."""
    found = [out for cell in notebook.cells for out in cell.get("outputs", [])]
    widgets = notebook.metadata.get("widgets", {})
    state = widgets.get("application/vnd.jupyter.widget-state+json", {}).get("state", {})
    for widget in state.values():
        found += widget.get("state", {}).get("outputs", [])
    return found


def complaints(notebook: Any) -> list[str]:
    """Errors and anything on standard error, in cells and behind sliders."""
    found = []
    for out in outputs(notebook):
        if out["output_type"] == "error":
            found.append(f"{out['ename']}: {out['evalue']}")
        elif out["output_type"] == "stream" and out["name"] == "stderr":
            found.append(f"on standard error: {out['text'].strip()}")
    return list(dict.fromkeys(found))


def save_pictures(target: Path, folder: Path) -> list[Path]:
    """The PNG pictures of an executed notebook as files, in order."""
    import nbformat

    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for out in outputs(nbformat.read(target, as_version=4)):
        data = out.get("data", {}).get("image/png")
        if data is not None:
            paths.append(folder / f"{target.parent.name}-{target.stem}-{len(paths) + 1:02d}.png")
            paths[-1].write_bytes(base64.b64decode(data))
    return paths


def _attempt(text: Path, limit: float) -> tuple[Path | None, float, str]:
    began = time.monotonic()
    try:
        return *run(text, limit), ""
    except NotebookError as failure:
        return None, time.monotonic() - began, str(failure)


def main(argv: list[str] | None = None) -> int:
    """Build what is asked for; 0 if all of it passed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT, help="where the texts are")
    parser.add_argument("--only", help="numbers of notebooks, such as 1,3")
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument("--texts", action="store_true", help="the notebooks without their solutions")
    kind.add_argument("--solutions", action="store_true", help="the solutions alone")
    parser.add_argument("--jobs", type=int, default=1, help="notebooks run at a time")
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds allowed for each")
    parser.add_argument("--pictures", type=Path, help="folder for the pictures as PNG files")
    args = parser.parse_args(argv)

    texts = sources(args.folder)
    if args.only:
        wanted = args.only.split(",")
        texts = [text for text in texts if text.name.partition("_")[0] in wanted]
    if args.texts or args.solutions:
        texts = [text for text in texts if (text.parent.name == "solutions") == args.solutions]
    if not texts:
        print("no notebooks were found", file=sys.stderr)
        return 1
    failed = 0
    with ThreadPoolExecutor(max_workers=args.jobs) as pool:
        for text, (target, seconds, message) in zip(
            texts, pool.map(_attempt, texts, [args.limit] * len(texts)), strict=True
        ):
            name = text.relative_to(args.folder)
            print(f"{seconds:7.1f} s  {'ok    ' if target else 'FAILED'}  {name}", flush=True)
            if target is None:
                failed += 1
                print(message, file=sys.stderr, flush=True)
            elif args.pictures:
                save_pictures(target, args.pictures)
    print(f"{len(texts) - failed} of {len(texts)} notebooks ran from top to bottom")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
