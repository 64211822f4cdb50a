"""Packages that a plain installation lacks."""

from collections.abc import Iterator
from contextlib import contextmanager


def install_command(extra: str) -> str:
    """Returns the command that installs an extra from the folder of the checkout. extra: names of pyproject.toml, by commas."""
    return f".venv/bin/pip install '.[{extra}]'"


class MissingExtra(ModuleNotFoundError):
    """A package of an extra is not installed. The text says how to install it."""

    def __init__(self, purpose: str, extra: str, error: ModuleNotFoundError) -> None:
        """purpose: a plural noun, what needs it; extra: its name in pyproject.toml; error: of the import."""
        package = (error.name or "").partition(".")[0]
        text = (
            f"{purpose} need the package {package}, of the extra {extra}; in the folder of the checkout run: "
            f"`{install_command(extra)}`"
        )
        super().__init__(text, name=package)


@contextmanager
def extra(name: str, purpose: str) -> Iterator[None]:
    """Raises MissingExtra for a package that the `with` block imports and that is absent. purpose: as MissingExtra has it."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise MissingExtra(purpose, name, error) from None
