"""Echoes that own ship throws back to ships near by: they come once more, at two and more times their range."""
