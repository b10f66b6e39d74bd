"""Modes: what holds, sticks and touches, as rows of numbers made once when a mode is met."""
