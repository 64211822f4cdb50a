"""Sea and rain clutter: the texture of the sea on the map, shadows on it, azimuth rows."""
