"""The closed form of a mode whose damping and stiffness commute: responses of its modes of vibration."""
