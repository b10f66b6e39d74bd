"""How small disturbances move within a mode: by its closed form, along the steps of its Taylor series."""
