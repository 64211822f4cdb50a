"""Studies of the simulator: speed against accuracy on a scene (`chart`), and where every method fails (`stability`)."""

from radar_service.terminal.extras import extra

with extra("pictures", "studies"):
    import matplotlib  # noqa: F401  # each study draws what it finds
