"""A Floquet multiplier in words."""

from vibsim.cases.number import number


def multiplier_text(mu: complex) -> str:
    """0.98837, or 0.88998 +- 0.42152i (magnitude 0.98475) for a pair."""
    real, imaginary, magnitude = (number(x, 8) for x in (mu.real, abs(mu.imag), abs(mu)))
    if mu.imag == 0:
        return real
    return f"{real} +- {imaginary}i (magnitude {magnitude})"
