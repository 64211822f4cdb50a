"""The ground truth: at an instant, at beam crossings, and its files."""
