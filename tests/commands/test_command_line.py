"""The parser of the command line: every command has its module, and defaults are those that the documents name."""

import re
from pathlib import Path
from typing import Any

import pytest

from radar_service import plug_ins
from radar_service.__main__ import main
from radar_service.commands import command_line
from radar_service.commands.command_line import module_of, parser
from radar_service.commands.shared_options import DEFAULT_SCENE
from radar_service.plug_ins import PlugInError
from tests.bench.ladder.test_series import LADDER, ladder
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


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("scan -o a.npz", {"scene": DEFAULT_SCENE, "fidelity": "auto", "seed": 0, "scans": 1, "threads": 1, "radar": None}),
        ("serve", {"host": "127.0.0.1", "port": 8000, "pace": 1.0, "truth": False, "scenes": [], "record": None}),
        ("plots", {"scene": "harbour", "scans": 10, "threshold": None, "pfa": None, "nearest_m": 0.0, "out": None, "png": None}),
        ("bench-detection -o out", {"scenario": "msc192-table2", "scans": 100, "ranges": 16, "out": Path("out")}),
        ("bench-ladder clutter -o out --tracker a --tracker b", {"ladders": ["clutter"], "seeds": 20, "trackers": ["a", "b"]}),
        ("bench-tracker a b -o out", {"scenarios": ["a", "b"], "tracker": "gnn", "list": False, "compare": None}),
    ],
)  # fmt: skip
def test_defaults(line: str, expected: dict[str, Any]) -> None:
    assert expected.items() <= vars(parser().parse_args(line.split())).items()


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
    ("line", "word"),
    [
        ("", "COMMAND"), ("fly", "invalid choice: 'fly'"), ("scan", "--out"), ("scan -o x", "npz"),
        ("scan -o x.txt", '"x.txt" does not end in .npz'), ("scan -o x.npz --png x.jpg", '"x.jpg" does not end in .png'),
        ("scan -o x.npz --truth x.json", ".jsonl"), ("scan -o x.npz --truth x", ".jsonl"), ("scan -o x.npz --scans 0", "scans"),
        ("scan -o x.npz --threads many", "threads"), ("scan -o x.npz --error-db nan", "error-db"),
        ("plan --seed -1", "seed"), ("plan --fidelity best", "fidelity"), ("plan --error-db 0", "0.01 to 10 dB"),
        ("plan --realtime-factor inf", "realtime-factor"), ("plan --realtime-factor 0", "above 0"),
        ("serve --pace 0", "pace"), ("serve --pace nan", "pace"), ("serve --pace quick", "pace"), ("serve --port 70000", "port"),
        ("serve --threads 0", "threads"), ("serve --error-db 1 --fidelity fast", "not allowed with"),
        ("serve --record a", "mcap"), ("record x", "--out"), ("record x -o a.npz", "mcap"),
        ("bench-detection -o x --scans 39", "scans"),
        ("bench-detection -o x --ranges 1", "ranges"), ("bench-detection", "--out"), ("bench-ladder --seeds 1", "seeds"),
        ("bench-ladder --jobs 0", "jobs"), ("bench-tracker --seeds 0", "seeds"), ("bench-tracker --jobs 0", "jobs"),
        ("bench-tracker --compare one.json", "compare"),
    ],
)  # fmt: skip
def test_bad_arguments_are_refused_by_name(line: str, word: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as refused:
        main(line.split())
    told = capsys.readouterr().err
    assert refused.value.code == 2 and word in told and "usage:" in told


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


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("bench-tracker", "name at least one scenario and a folder"),
        ("bench-tracker crossing-cpa-500 --jobs 1", "name at least one scenario and a folder"),
        ("bench-tracker fly -o x --jobs 1", "there is no such scenario"),
        ("bench-tracker crossing-cpa-500 -o x --jobs 1 --tracker no-such-program", "could not be started"),
        ("bench-tracker crossing-cpa-500 -o x --answers plots", "they are of the video; give --input video too"),
        ("bench-tracker crossing-cpa-500 -o x --input video --answers ttm", "a program that writes TTM"),
        ("bench-tracker real/autoferry-2 -o x --input video", "its plots are recorded; leave --input video out"),
        ("bench-tracker --compare a.json b.json", "a.json: No such file"),
        ("bench-detection fly -o x", "there is no such scenario"),
        ("bench-detection crossing-freighters -o x", 'body "eastbound": detection is judged for points'),
        ("bench-ladder --seeds 2", "name a folder for the report, or give --list"),
        ("bench-ladder stairs -o x --seeds 2", "stairs: there is no such ladder"),
        (
            "bench-ladder noisy.toml -o x --seeds 2 --jobs 1 --tracker no-such-program",
            "'no-such-program' could not be started",
        ),
        ("bench-ladder noisy.toml noisy.toml -o x --seeds 2", "two have the same name"),
    ],
)
def test_what_a_bench_cannot_do_is_one_sentence(
    words: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("stonesoup", reason="the extra `tracking` is absent")
    monkeypatch.chdir(tmp_path)
    ladder(tmp_path, LADDER.replace("6", "2"))
    assert main(words.split()) == 2
    assert message in capsys.readouterr().err
