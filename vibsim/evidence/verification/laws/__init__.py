"""Laws of motion: mirror symmetry, Liouville's formula, balances; a motor alone (V8 to V11, V21)."""
