"""Rigid stops: impacts, several at one instant, the ends of infinite sequences of them, and rest."""
