"""The tables of a scene file: names, units, ranges and defaults."""
