"""Co-safe LTL, the DFA of a formula's good prefixes (Definition 6), and satisfaction by finite traces.

From the text of a task or rule to a row of the product's tables, a formula has four forms:

| form                                               | made by            | what it adds                             |
| -------------------------------------------------- | ------------------ | ---------------------------------------- |
| `syntax.Part`, the syntax tree                     | `syntax.read`      | operators as written, with their columns |
| `formula.Formula`, the negation normal form        | `normal_form`      | co-safe or safety, or else refused       |
| `dfa.Automaton`, a minimal DFA, guards as MTBDDs   | `dfa.automaton`    | its good prefixes, or a rule's bad ones  |
| `weighted_dfa.WeightedAutomaton`                   | `problem.Problem`  | prices of relaxing, skipping, breaking   |

The product reads every label of the model by the last form, and stores the results in its tables. `good_prefix` decides
satisfaction by the second form alone, so that it can check the others.
"""
