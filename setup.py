"""Packages of the distribution: `clients/` and `scenes/` are installed inside `radar_service`. See pyproject.toml."""

from setuptools import find_packages, setup

INSIDE = {"radar_service.clients": "clients", "radar_service.scenes": "scenes"}

setup(
    packages=[
        *find_packages(include=["radar_service", "radar_service.*"]),
        *(f"radar_service.{name}" for name in find_packages(include=["clients", "clients.*", "scenes"])),
    ],
    package_dir=INSIDE,
)
