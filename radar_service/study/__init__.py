"""Studies: speed against accuracy (`chart`), where methods fail (`stability`)."""

from radar_service.terminal import extra

with extra("pictures", "studies"):
    import matplotlib  # noqa: F401  # each study draws what it finds
