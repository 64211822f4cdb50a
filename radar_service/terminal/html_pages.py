"""Pages of HTML from templates beside the modules that fill them; whatever fills them is escaped."""

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from radar_service.terminal.extras import install_command

ENVIRONMENT = Environment(
    loader=PackageLoader("radar_service", "."),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)
ENVIRONMENT.globals["install_command"] = install_command


def html_page(template: str, **values: Any) -> str:
    """Returns a page. template: its path in the package; values: what it shows, and functions that it calls."""
    return ENVIRONMENT.get_template(template).render(values)
