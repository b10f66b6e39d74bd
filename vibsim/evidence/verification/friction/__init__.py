"""Known cases of friction: Coulomb's alone, and sticking and slipping on a belt (V6, V7, V16 to V18)."""
