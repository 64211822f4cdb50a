"""Packages that a plain installation lacks."""


def install_command(extra: str) -> str:
    """Returns the command that installs an extra from the folder of the checkout. extra: names of pyproject.toml, by commas."""
    return f".venv/bin/pip install '.[{extra}]'"


class MissingExtra(ModuleNotFoundError):
    """A package of an extra is not installed. The text says how to install it."""

    def __init__(self, purpose: str, extra: str, error: ModuleNotFoundError) -> None:
        """purpose: a plural noun, what needs it; extra: its name in pyproject.toml; error: of the import."""
        text = (
            f"{purpose} need the package {error.name}, of the extra {extra}; in the folder of the checkout run: "
            f"`{install_command(extra)}`"
        )
        super().__init__(text, name=error.name)
