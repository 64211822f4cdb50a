"""The world in SI units: bodies, platforms, motion, steering, presence, materials, environment, and scenes of these."""
