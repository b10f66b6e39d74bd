"""The modes of a scene around a solver that finds events: which follows, and what a blow does."""
