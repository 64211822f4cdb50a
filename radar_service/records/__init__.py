"""Records that rooms hand to each other: spokes, truth, reports of sensors, labels and powers of cells, fidelity."""
