"""How good tracks are: truth, assignment, scores, verdicts."""
