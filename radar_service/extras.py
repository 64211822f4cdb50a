"""Packages that a plain installation lacks."""


class MissingExtra(ModuleNotFoundError):
    """A package of an extra is not installed. The text says how to install it."""

    def __init__(self, purpose: str, extra: str, error: ModuleNotFoundError) -> None:
        """purpose: a plural noun, what needs it; extra: its name in pyproject.toml; error: of the import."""
        text = f'{purpose} need the package {error.name}; install it: pip install "radar-service[{extra}]"'
        super().__init__(text, name=error.name)
