"""What is handed over: spokes, truth, reports of sensors, labels and powers of cells, fidelity."""
