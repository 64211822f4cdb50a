"""Physical constants, SI (CODATA 2018 where exact by definition), and the extent of maps."""

SPEED_OF_LIGHT = 299_792_458.0  # m/s, exact
BOLTZMANN = 1.380649e-23  # J/K, exact
REFERENCE_TEMPERATURE = 290.0  # K, T0 of the noise figure (IEEE Std 686)
EARTH_RADIUS = 6_371_000.0  # m, mean radius
GRAVITY = 9.80665  # m/s^2, standard, exact
KNOT = 1852.0 / 3600.0  # m/s, exact
NAUTICAL_MILE = 1852.0  # m, exact
MAX_COORDINATE = 2e6  # m from the origin of the map, which is flat; farther out it is meaningless
DISPLAY_RANGES = (
    231, 463, 926, 1389, 1852, 2778, 3704, 5556, 7408, 11112, 14816, 22224, 29632, 44448, 66672, 88896,
)  # fmt: skip  # m: those of sets, 1/8 to 48 nautical miles
