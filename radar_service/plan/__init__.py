"""No more than a scene needs: errors and costs predicted, and from an error budget the cheapest fidelity that keeps it."""
