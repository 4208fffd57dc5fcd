"""Co-safe LTL, the DFA of a formula's good prefixes (Definition 6), and satisfaction by finite traces."""
