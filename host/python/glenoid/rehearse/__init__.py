"""Rehearsals: a scenario run through FMU, bridge and simulated drives, judged, and left as one folder; docs/rehearsal.md."""
