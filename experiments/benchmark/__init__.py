"""The paper's Table I, timed."""
