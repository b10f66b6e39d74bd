"""Derivatives of the return map by the numbers of a scene."""
