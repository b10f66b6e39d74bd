"""Branches of periodic orbits: continued in a parameter, through folds, with what happens on the way."""
