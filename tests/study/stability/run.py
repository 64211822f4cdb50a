"""Runs a study once and keeps its finding for all tests."""

from functools import cache

from radar_service.study import stability
from radar_service.study.stability.finding import Finding

WAVELENGTH = 299_792_458.0 / 9.41e9
EARTH = 4.0 / 3.0 * 6_371_000.0


@cache
def finding_of(name: str) -> Finding:
    """Returns the finding of the study of that name at refinement 1."""
    return {study.__name__: study for study in stability.STUDIES}[name](1)
