"""Where the files are that come with the package: the scenes and the web page."""

from pathlib import Path

HERE = Path(__file__).parent


def packaged_folder(name: str) -> Path:
    """The folder `name`: inside the package when it is installed, beside it in a checkout."""
    inside = HERE / name
    return inside if inside.is_dir() else HERE.parent / name
