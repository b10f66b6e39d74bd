"""Laws by which a friction force falls with the speed of slip, one module each.

The force is constant + drop f(s), s = rate |v_rel|, with f(0) = 1 and f falling to 0. A module has

    NUMBER                            of the law, the same in friction_laws.h
    start(kit, s)                     f(s)
    argument(n, s)                    from coefficient n > 0 of s, what the products of the recurrence take
    following(total, f, inverse)      coefficient n > 0 of f from the sum over i = 1 ... n of argument i times
                                      f_(n-i); inverse = 1/n
    slopes(f)                         series of df/ds, for small disturbances
    slope(f)                          the same of one value
"""

from types import ModuleType

from vibsim.physics.friction_laws import exponential, hyperbolic

HYPERBOLIC, EXPONENTIAL = "stribeck hyperbolic", "stribeck exponential"
LAWS: dict[str, ModuleType] = {HYPERBOLIC: hyperbolic, EXPONENTIAL: exponential}
