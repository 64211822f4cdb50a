"""Believed: published figures, computed through scenes, and held against their tolerances."""
