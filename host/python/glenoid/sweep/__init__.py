"""Population studies: many persons, tasks and devices, one row a case."""
