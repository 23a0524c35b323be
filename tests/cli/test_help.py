"""Help that is worth reading: sections, examples that parse, nearest names, completion."""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import subprocess
import sys

import click
import pytest

from pitchopt.cli import completing
from pitchopt.cli.help import Command
from pitchopt.cli.main import _COMMANDS, _SECTIONS, program

CONTEXT = click.Context(program, info_name="pitchopt")
NAMES = list(_COMMANDS)
HEAVY = {"clarabel", "cvxpy", "matplotlib", "numba", "numpy", "scipy", "yaml"}


def command_of(name: str) -> click.Command:
    found = program.get_command(CONTEXT, name)
    assert found is not None
    return found


def help_of(name: str) -> str:
    return command_of(name).get_help(
        click.Context(command_of(name), info_name=name, max_content_width=100)
    )


def examples_of(name: str) -> list[str]:
    """Command lines of the examples, continued lines joined."""
    epilog = command_of(name).epilog or ""
    return re.findall(r"^  (pitchopt [a-z].*(?:\n {6,}.*)*)", epilog, re.MULTILINE)


@pytest.mark.parametrize("name", NAMES)
def test_every_command_has_a_help_with_sections_and_examples(name):
    command = command_of(name)
    assert isinstance(command, Command)
    text = help_of(name)
    assert text.index("\n  ") < text.index("Options:" if "Options:" in text else "Output:")
    assert "Examples:" in text
    for parameter in command.params:
        if isinstance(parameter, click.Option):
            assert parameter.help, parameter.opts
    assert len(command.help.splitlines()) >= 3, "a line of what it is, then what it does"


@pytest.mark.parametrize("name", NAMES)
def test_examples_of_a_help_are_understood(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lines = examples_of(name)
    assert len(lines) >= (2 if name != "completion" else 1)
    for line in lines:
        words = shlex.split(line.split(" > ")[0])
        called = command_of(words[1])
        called.make_context(words[1], words[2:])  # raises on anything that is not understood


def test_examples_of_the_program_are_understood():
    lines = re.findall(r"^  (pitchopt .*)", program.epilog, re.MULTILINE)
    assert len(lines) > 8
    for line in lines:
        words = shlex.split(re.split(r" > | {3,}", line)[0])
        command_of(words[1]).make_context(words[1], words[2:])


@pytest.mark.parametrize("page", ["README.md", "docs/recipes.md"])
def test_commands_of_a_page_are_understood(project_root, page):
    text = (project_root / page).read_text(encoding="utf-8")
    lines = re.findall(r"^pitchopt .*", text, re.MULTILINE)
    assert len(lines) >= 5
    for line in lines:
        words = shlex.split(re.split(r" > |  +#", line)[0])
        command_of(words[1]).make_context(words[1], words[2:])


def test_the_front_page_lists_every_command_and_links_to_what_is_there(project_root):
    text = (project_root / "README.md").read_text(encoding="utf-8")
    listed = re.findall(r"^\| `pitchopt ([a-z]+)`", text, re.MULTILINE)
    assert listed == [name for names in _SECTIONS.values() for name in names]
    links = re.findall(r"\]\(([^)#]+)\)", text)
    assert len(links) > 15
    for link in links:
        assert "://" in link or (project_root / link).exists(), link


@pytest.mark.slow
def test_the_script_of_the_front_page_runs(project_root, capsys):
    text = (project_root / "README.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    exec(compile(script, "README.md", "exec"), {})  # noqa: S102  our own page
    assert capsys.readouterr().out.startswith("converged {'torque': ")


def test_every_command_stands_in_one_section_of_the_program(run):
    placed = [name for names in _SECTIONS.values() for name in names]
    assert sorted(placed) == sorted(NAMES)
    text = run().out
    for title in _SECTIONS:
        assert f"{title}:" in text
    assert "Other commands" not in text


def test_options_that_commands_share_stand_under_the_same_title():
    titles: dict[str, set[str]] = {}
    for name in set(NAMES) - {"export"}:
        for parameter in command_of(name).params:
            if isinstance(parameter, click.Option) and parameter.name in (
                "out",
                "as_json",
                "cache",
            ):
                titles.setdefault(parameter.name, set()).add(getattr(parameter, "section", ""))
    assert titles == {"out": {"Output"}, "as_json": {"Output"}, "cache": {"Computation"}}


# ---- names that are nearly right ------------------------------------------------------------


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["tradeof"], "did you mean 'tradeoff'?"),
        (["simulation"], "did you mean 'simulate'?"),
        (["optimise"], "expected one of tradeoff, design"),
        (
            ["tradeoff", "--wind-sped", "9"],
            "no such option --wind-sped; did you mean '--wind-speed'?",
        ),
        (["tune", "--methods", "zoo"], "did you mean '--method'?"),
        (["learn", "--learner", "adptive"], "--learner"),
    ],
)
def test_nearest_names(run, args, message):
    done = run(*args)
    assert done.status == 2
    assert message in done.err
    assert len(done.err.splitlines()) == 1


def test_an_option_like_no_other_has_no_suggestion(run):
    done = run("tower", "--mean-torque", "2e6")
    assert done.err == "pitchopt tower: no such option --mean-torque (see pitchopt tower --help)\n"


def test_the_older_name_of_an_option_is_understood_and_not_shown():
    command = command_of("learn")
    assert "--actuator-time" not in help_of("learn")
    for name in ("--pitch-lag", "--actuator-time"):
        context = command.make_context("learn", ["--plant", "dynamic", name, "0.3"])
        assert context.params["pitch_lag"] == 0.3


def test_an_error_names_the_option_as_the_help_does(run):
    for name in ("--pitch-lag", "--actuator-time"):
        done = run("learn", "--plant", "dynamic", name, "99")
        assert done.status == 2
        assert done.err.startswith(
            "pitchopt: --pitch-lag: got '99', expected a number from 0 to 10"
        )


# ---- completion -----------------------------------------------------------------------------


def completions(capsys, monkeypatch, line: str) -> list[str]:
    """What a shell would be told for a line whose last word is being typed."""
    words = line.split(" ")
    monkeypatch.setenv("_PITCHOPT_COMPLETE", "bash_complete")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
    capsys.readouterr()
    with pytest.raises(SystemExit) as end:
        program.main(prog_name="pitchopt")
    assert end.value.code == 0
    return capsys.readouterr().out.split()


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("pitchopt tra", ["plain,tradeoff"]),
        ("pitchopt tradeoff --wind", ["plain,--wind-speed"]),
        ("pitchopt tradeoff --case nr", ["plain,nrel-5mw"]),
        ("pitchopt tradeoff --case my", ["plain,my-case.toml"]),
        ("pitchopt tradeoff --case fol", ["file,fol"]),
        ("pitchopt tradeoff --case folder/", ["plain,folder/other.toml"]),
        ("pitchopt tradeoff --case none/", ["file,none/"]),
        ("pitchopt tradeoff --induction fr", ["plain,frozen"]),
        ("pitchopt tradeoff --weights tow", ["plain,tower-base"]),
        ("pitchopt simulate --controller i", ["plain,ipc"]),
        ("pitchopt simulate --turbulence A", ["plain,A+", "plain,A"]),
        ("pitchopt simulate --turbulence w", ["plain,wind.bts"]),
        ("pitchopt simulate --format csv,o", ["plain,csv,outb"]),
        ("pitchopt simulate --inflow q", ["plain,quasi-steady"]),
        ("pitchopt tune --method zoo,b", ["plain,zoo,bayes"]),
        ("pitchopt tune --problem m", ["plain,minimum-pitch"]),
        ("pitchopt tune --problem minimum-pitch,m", []),
        ("pitchopt learn --learner p", ["plain,paper"]),
        ("pitchopt design --mean-torque r", ["plain,rated"]),
        ("pitchopt design --out ", ["dir,"]),
        ("pitchopt turbines iea-1", ["plain,iea-10-198", "plain,iea-15-240"]),
        ("pitchopt turbines t", ["plain,t.yaml"]),
        ("pitchopt completion z", ["plain,zsh"]),
        ("pitchopt export --format ha", ["plain,harmonics"]),
        ("pitchopt export ip", ["plain,ipc"]),
    ],
)
def test_completion(capsys, monkeypatch, tmp_path, line, found):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder").mkdir()
    for name in ("my-case.toml", "wind.bts", "t.yaml", "notes.txt", "folder/other.toml", ".x.toml"):
        (tmp_path / name).touch()
    assert completions(capsys, monkeypatch, line) == found


def test_names_to_complete_are_those_of_the_library():
    from pitchopt.studies.comparison import METHODS as COMPARED
    from pitchopt.studies.simulation import CONTROLLERS
    from pitchopt.studies.tuning import PROBLEMS
    from pitchopt.tuning.methods import METHODS
    from pitchopt.turbines import names

    assert completing.CONTROLLERS == CONTROLLERS
    assert completing.PROBLEMS == PROBLEMS
    assert completing.METHODS == METHODS
    assert completing.COMPARED == COMPARED
    assert sorted(completing.turbines()) == sorted(names())


@pytest.mark.parametrize(
    "line", ["pitchopt tradeoff --case n", "pitchopt tune --method b", "pitchopt "]
)
def test_completion_loads_nothing_heavy(line):
    code = (
        "import json, sys\n"
        "from pitchopt.cli import main\n"
        "try:\n    main([])\n"
        "except SystemExit:\n    print(json.dumps(sorted(sys.modules)))\n"
    )
    words = {
        "_PITCHOPT_COMPLETE": "zsh_complete",
        "COMP_WORDS": line,
        "COMP_CWORD": str(line.count(" ")),
    }
    done = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | words,
        check=True,
        capture_output=True,
        text=True,
    )
    assert len(done.stdout.splitlines()) > 1
    assert not HEAVY.intersection(json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.parametrize("shell", completing.SHELLS)
def test_scripts_of_the_shells(run, shell):
    done = run("completion", shell)
    assert done.status == 0
    assert f"_PITCHOPT_COMPLETE={shell}_complete" in done.out
    if shutil.which(shell):
        subprocess.run([shell, "-n"], input=done.out, check=True, text=True)


def test_bash_completes_a_line(run, tmp_path):
    bash = shutil.which("bash")
    if bash is None:
        pytest.skip("no bash here")
    script = run("completion", "bash").out
    program_file = tmp_path / "pitchopt"
    program_file.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m pitchopt "$@"\n')
    program_file.chmod(0o755)
    script += (
        "\nCOMP_WORDS=(pitchopt tune --method zoo,ba)\nCOMP_CWORD=3\n"
        '_pitchopt_completion pitchopt zoo,ba --method\necho "${COMPREPLY[@]}"\n'
    )
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(
        [bash, "-c", script],
        env=os.environ | {"PATH": path},
        check=True,
        capture_output=True,
        text=True,
    )
    assert done.stdout == "zoo,bayes\n"


def test_a_shell_that_is_not_known(run):
    done = run("completion", "tcsh")
    assert done.status == 2
    assert "'tcsh'" in done.err and "bash" in done.err
