"""Believed: figures that others have published, computed by the simulator through scenes, and held against their tolerances."""
