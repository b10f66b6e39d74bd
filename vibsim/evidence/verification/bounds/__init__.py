"""What rounding may do to a motion: bounds that follow from its conditioning, and runs that are kicked."""
