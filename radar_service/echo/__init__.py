"""Echoes, resting and moving: visibility, range histories, passages of the beam, second time around."""
