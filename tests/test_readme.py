"""What the README shows is true: its Python runs, its scene loads, its commands exist."""

import ast
import math
import re
import tomllib
from pathlib import Path

import pytest

import radar_service as rs
from radar_service.__main__ import main

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    """The fenced blocks of exactly that language tag."""
    return re.findall(rf"^```{re.escape(language)}\n(.*?)^```$", README, flags=re.M | re.S)


def test_the_python_example_prints_what_the_text_says(capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = blocks("python")
    exec(compile(example, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    assert "It prints `45.0 degrees, 199.7 m`" in README and printed.startswith("45.0 degrees, 199.7 m\n")


def test_the_scene_example_loads_without_a_word() -> None:
    (example,) = blocks("toml")
    scene = rs.load_scene(tomllib.loads(example))
    assert [body.name for body in scene.bodies] == ["reflector", "buoy", "ferry"] and not scene.warnings


def test_ci_calls_exactly_the_test_command() -> None:
    (command,) = (block.strip() for block in blocks("") if block.endswith("pytest\n"))
    assert command in (Path(__file__).parents[1] / ".ci" / "run").read_text(encoding="utf-8")


@pytest.mark.parametrize("command", ["serve", "scan", "record", "replay", "check", "plan", "plots", "chart", "schema"])
def test_the_commands_named_exist(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert f"`{command}" in README or f"radar-service {command}" in README
    with pytest.raises(SystemExit) as ended:
        main([command, "--help"])
    assert ended.value.code == 0 and capsys.readouterr().out


def test_verbs_of_contributing_are_the_sessions_of_nox() -> None:
    """Each with the command that the table gives, and .ci/run and pre-commit with the same checks."""
    root = Path(__file__).parents[1]
    table = re.findall(r"^\| `(\w+)`.*\| `(.+)` \|$", (root / "CONTRIBUTING.md").read_text(encoding="utf-8"), flags=re.M)
    calls: dict[str, set[str]] = {}
    for session in ast.parse((root / "noxfile.py").read_text(encoding="utf-8")).body:
        if isinstance(session, ast.FunctionDef):
            (run,) = [c for c in ast.walk(session) if isinstance(c, ast.Call) and ast.unparse(c.func) == "session.run"]
            calls[session.name] = {c.value for c in ast.walk(run) if isinstance(c, ast.Constant)}
    assert {verb: set(command.split()) for verb, command in table} == calls
    ci, hooks = ((root / name).read_text(encoding="utf-8") for name in (".ci/run", ".pre-commit-config.yaml"))
    for verb in ("format", "lint", "types"):
        assert f".venv/bin/{dict(table)[verb]}\n" in ci
        assert (
            f"id: {verb}" in hooks
            and f".venv/bin/{dict(table)[verb].removesuffix(' --check .').removesuffix(' .')}\n" in hooks
        )


@pytest.mark.parametrize("name", ["README.md", "CONTRIBUTING.md", "tests/cpu_budget.toml"])
def test_the_time_of_the_suite_is_the_sum_of_its_budgets(name: str) -> None:
    """Two cores are busy four fifths of the time (tests also wait), in whole minutes."""
    root = Path(__file__).parents[1]
    total = sum(tomllib.loads((root / "tests" / "cpu_budget.toml").read_text())["seconds"].values())
    text = (root / name).read_text(encoding="utf-8")
    told = re.findall(r"(\d+) s(?: of processor time|\. A change)", text)
    assert set(map(int, told)) == {total}
    minutes = re.findall(r"some (\w+) minutes on two quiet cores", text)
    assert name.endswith(".toml") or minutes == [{5: "five", 6: "six", 7: "seven"}[math.ceil(total / 1.6 / 60)]]
