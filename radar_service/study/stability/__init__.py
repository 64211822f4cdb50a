"""Where every method and model fails: each study drives one parameter until the method fails.

To add a study, write one file in the folder `studies`, or one function in a file there:

- the function takes the refinement (1, or the `--fine` of the command line) and returns a `Finding`;
- the file lists its functions in a tuple `STUDIES`.

The tests compare every finding with its `Expected`, so a new study needs no change elsewhere.
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
