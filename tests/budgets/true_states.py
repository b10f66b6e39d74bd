"""States that count as true, to the last digit of a double; computed by `truth.py` in 40 digits.

II-B meets the 50-digit checkpoints known from elsewhere: at 20 s x2 = 0.003511, phidot = 2 pi 4.00240 Hz; at
50 s x2 = 0.014103, phidot = 2 pi 5.27362 Hz. I-C was found the same with mpmath in place of python-flint.
"""

# (case, time [s]): x1 [m], v1 [m/s], x2, v2; with a motor phi [rad], phidot [rad/s]
TRUE_STATES: dict[tuple[str, int], tuple[float, ...]] = {
    ("I-C", 20): (-0.0008240636211179578, 0.11677585627172603, -0.004838737860205491, -0.013193685974725311),
    ("II-A", 20): (
        0.010119443293307526, 0.02196161278631838, -0.002019106751056316, 0.016585385464651294,
        308.82131338846875, 20.880149854396,
    ),
    ("II-A", 40): (
        0.002903125947456674, 0.29146383849206775, 0.000950304892883907, -0.007447970611965969,
        736.9139920177431, 22.835683629719732,
    ),
    ("II-B", 20): (
        0.03753139110211013, 1.050584495018728, 0.003511043769310523, -0.10250643415421078,
        360.7851065312718, 25.14781164404655,
    ),
    ("II-B", 50): (
        0.06636377014869456, 0.003615681285931803, 0.014102938675179599, -0.035352180325340876,
        1274.2394127441846, 33.135137111840194,
    ),
    ("II-C", 20): (
        0.0475703163107652, 0.24543597023140273, 0.009553782159212305, -0.0012460422247999273,
        385.65888479118934, 32.172604653521944,
    ),
    ("II-C", 40): (
        0.03315914298253119, 0.8684101660985458, 0.018099197124249122, -0.13300989779992542,
        1092.2068702293664, 37.3872081508356,
    ),
}  # fmt: skip


def error_of(name, t, state):
    """Largest error of `state`, ordered as above, at t [s]: absolute, or relative where |true| > 1."""
    true = TRUE_STATES[name, t]
    return max(abs(float(got) - value) / max(1.0, abs(value)) for got, value in zip(state, true, strict=True))
