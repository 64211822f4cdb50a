"""The test bench of trackers: scenarios, trackers, scores, verdicts, report; detection against the radar equation."""
