"""The parser of the command line: every command has its module, and defaults are those that the documents name."""

import re
from pathlib import Path

import pytest

from radar_service import plug_ins
from radar_service.commands import command_line
from radar_service.commands.command_line import module_of, parser
from radar_service.commands.shared_options import DEFAULT_SCENE
from radar_service.plug_ins import PlugInError
from tests.plug_ins import join

COMMANDS = plug_ins.names("commands")


def test_every_command_is_a_module(capsys: pytest.CaptureFixture[str]) -> None:
    """argparse lists the commands where it refuses one."""
    with pytest.raises(SystemExit):
        parser().parse_args(["fly"])
    listed = capsys.readouterr().err.rsplit("(choose from ", 1)[1]
    assert {name.strip(" ')\n") for name in listed.split(",")} == set(COMMANDS)
    assert all(callable(module_of(name).run) for name in COMMANDS)


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_every_command_has_help(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        parser().parse_args([name, "--help"])
    assert ended.value.code == 0 and f"radar-service {name}" in capsys.readouterr().out


def test_defaults() -> None:
    scan = parser().parse_args(["scan", "-o", "a.npz"])
    assert (scan.scene, scan.fidelity, scan.seed, scan.scans, scan.threads, scan.radar) == (
        DEFAULT_SCENE,
        "auto",
        0,
        1,
        1,
        None,
    )
    serve = parser().parse_args(["serve"])
    assert (serve.host, serve.port, serve.pace, serve.truth, serve.scenes, serve.record) == (
        "127.0.0.1",
        8000,
        1.0,
        False,
        [],
        None,
    )


def test_the_options_of_serve_are_in_groups_with_two_examples(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        parser().parse_args(["serve", "--help"])
    text = capsys.readouterr().out
    titles = re.findall(r"^([a-z ]+):$", text, re.M)
    assert titles == ["options", "what", "where", "how exact", "how fast", "who may", "records", "examples"]
    options = dict(zip(titles, re.split(r"^[a-z ]+:$", text, flags=re.M)[1:], strict=True))
    assert re.findall(r"^  (\S+)", options["options"], re.M) == ["-h,"]
    for title, option in (
        ("what", "SCENE"), ("where", "--port"), ("how exact", "--error-db"), ("how fast", "--threads"),
        ("who may", "--token-file"), ("records", "--record"),
    ):  # fmt: skip
        assert re.search(rf"^  {option} ", options[title], re.M), title
    for line in options["examples"].strip().splitlines():
        assert parser().parse_args(line.split()[1:]).command == "serve"


@pytest.mark.parametrize(
    "arguments", [[], ["fly"], ["scan"], ["scan", "-o", "a.txt"], ["serve", "--pace", "0"], ["record", "a"]]
)
def test_wrong_input_ends_with_status_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        parser().parse_args(arguments)
    assert ended.value.code == 2 and "usage:" in capsys.readouterr().err


def test_the_arguments_of_one_command_are_those_that_it_has_among_all() -> None:
    words = ["scan", "harbour", "-o", "a.npz", "--labels", "--scans", "3"]
    assert parser("scan").parse_args(words) == parser().parse_args(words)


def test_each_module_beside_the_shared_ones_is_a_command() -> None:
    """A new command is a file and a line."""
    files = {file.stem for file in Path(command_line.__file__).parent.glob("*.py")}
    shared = {"__init__", "command_line", "shared_options", "simulator_options"}
    assert files - shared == {name.replace("-", "_") for name in COMMANDS}


def test_a_command_whose_arguments_fail_is_told_by_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    join(monkeypatch, "commands", "odd", object())
    with pytest.raises(
        PlugInError, match="odd of radar_service.commands: the package tests.plug_ins is broken .AttributeError"
    ):
        parser("odd")
    assert parser("check").parse_args(["check", "harbour"]).command == "check"
