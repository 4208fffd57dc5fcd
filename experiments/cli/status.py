"""Exit statuses of the programs."""

DONE, BAD_INPUT, NO_PLAN, FAILED, INTERRUPTED = 0, 2, 3, 4, 130
