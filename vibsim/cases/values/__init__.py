"""Values: decimal text with a unit, read exactly; ranges of them; products with pi rounded once."""
