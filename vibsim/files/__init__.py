"""Files that vibsim writes: whole or not at all, their columns declared once, written and checked by that."""
