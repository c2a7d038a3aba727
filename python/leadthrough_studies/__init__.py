"""Studies on record: one folder a study, run by `leadthrough experiment`."""
