"""Array types of the engine. Shapes stand in the docstrings of what takes and returns them."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Complexes = NDArray[np.complex128]
Profiles = NDArray[np.complex64]  # compressed range profiles, or the grid rows that become them
Indices = NDArray[np.int64]
Flags = NDArray[np.bool_]
Gain = Callable[[Floats], Floats]  # angle [rad] to one-way power gain relative to boresight
