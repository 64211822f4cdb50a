"""Speed charted against accuracy: every method of the engine on one scene, as one point each."""
