"""A Floquet multiplier in words."""


def multiplier_text(mu: complex) -> str:
    """0.98837, or 0.88998 +- 0.42152i (magnitude 0.98475) for a pair."""
    if mu.imag == 0:
        return f"{mu.real:.8g}"
    return f"{mu.real:.8g} +- {abs(mu.imag):.8g}i (magnitude {abs(mu):.8g})"
