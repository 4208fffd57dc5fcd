"""The paper's figures, tables and examples once more, beside what it printed."""
