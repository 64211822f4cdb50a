"""Many jobs of one kind: side by side, each failing alone, and none done twice."""
