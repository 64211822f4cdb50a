"""Where every method and model fails: each study drives one parameter until the method fails.

A study is a function in a file of `studies`, listed in its tuple `STUDIES`: it takes the refinement (1, or `--fine`) and returns
a `Finding`, which the tests compare with its `Expected`.
"""

from importlib import import_module
from pkgutil import iter_modules

from radar_service.study.stability import studies
from radar_service.study.stability.finding import Study


def discover() -> tuple[Study, ...]:
    """Returns the studies of all modules in the folder `studies`. Raises AttributeError for a module without STUDIES."""
    names = sorted(module.name for module in iter_modules(studies.__path__))
    modules = [import_module(f"{studies.__name__}.{name}") for name in names]
    return tuple(study for module in modules for study in module.STUDIES)


STUDIES = discover()
