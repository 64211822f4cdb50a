"""Ladders: series of scenarios of growing difficulty, and trackers ranked by them."""
