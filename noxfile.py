"""The commands of CONTRIBUTING.md, each in an environment of its own: `nox` runs the checks, `nox -s bench` one of them.

`.ci/run` does not need nox: it runs the README's test command and the same checks in one environment.
"""

import nox

nox.options.sessions = ["tests", "format", "lint", "types", "dependencies", "imports"]
nox.options.error_on_missing_interpreters = False  # a Python that is not installed is skipped
nox.options.reuse_existing_virtualenvs = True


@nox.session(python=["3.11", "3.12", "3.13", "3.14"])
def tests(session: nox.Session) -> None:
    """The tests."""
    session.install("-e", ".[dev]")
    session.run("pytest", *session.posargs)


@nox.session
def format(session: nox.Session) -> None:
    """The format of the code."""
    session.install("ruff>=0.15")
    session.run("ruff", "format", "--check", ".")


@nox.session
def lint(session: nox.Session) -> None:
    """The findings of ruff."""
    session.install("ruff>=0.15")
    session.run("ruff", "check", ".")


@nox.session
def types(session: nox.Session) -> None:
    """The types, in strict mode."""
    session.install("-e", ".[dev]")
    session.run("mypy")


@nox.session
def dependencies(session: nox.Session) -> None:
    """Whether what is imported is declared, and the other way round."""
    session.install("-e", ".[dev]")
    session.run("deptry", "radar_service", "clients")


@nox.session
def imports(session: nox.Session) -> None:
    """The rules of imports."""
    session.install("-e", ".[dev]")
    session.run("lint-imports")


@nox.session
def bench(session: nox.Session) -> None:
    """Measurements of speed and memory."""
    session.install("-e", ".[dev]")
    session.run("pytest", "-m", "bench", "-s", *(session.posargs or ["tests/measurements"]))


@nox.session
def study(session: nox.Session) -> None:
    """Slow studies."""
    session.install("-e", ".[dev]")
    session.run("pytest", "-m", "study", *session.posargs)
