"""A plan carried out once: the run, its outcome and its evidence."""
