"""The plan of a scene: predicted errors and costs, and the cheapest fidelity that keeps an error budget."""
