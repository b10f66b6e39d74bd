"""Rigid stops: blows, several at one instant, the ends of infinite sequences of them, and rest."""
