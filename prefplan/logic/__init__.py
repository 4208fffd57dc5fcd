"""Co-safe LTL, the DFA of a formula's good prefixes (Definition 6), and what a finite trace satisfies."""
