/* The elementary functions of one argument that formulas have, in one list for all that deal with them: F(CODE, name, of, sign, text).
 *
 * CODE, name: of the operation, and in Python; of: its value, in elementary.h of doubles, in limbs.cpp of numbers of words; text: what
 * Python says of it. sign: where its derivative is 1 or -1 over a divisor, which is an operation of its own before it (`divisor` in
 * vibsim/physics/formulas.py), that number. The others, with 0, have recurrences of their own in tape_series.h.
 */
#ifndef VIBSIM_FUNCTIONS_H
#define VIBSIM_FUNCTIONS_H

#define ELEMENTARY_FUNCTIONS(F)                                                                   \
    F(SIN, sin, sine_of, 0, "Sine of an angle [rad].")                                            \
    F(COS, cos, cosine_of, 0, "Cosine of an angle [rad].")                                        \
    F(SINH, sinh, hyperbolic_sine, 0, "Hyperbolic sine.")                                         \
    F(COSH, cosh, hyperbolic_cosine, 0, "Hyperbolic cosine.")                                     \
    F(EXP, exp, exponential, 0, "exp(x); 0 or infinite where that is what is nearest.")           \
    F(LOG, log, logarithm, 0, "Natural logarithm; nan of what is below 0.")                       \
    F(TANH, tanh, hyperbolic_tangent, 0, "Hyperbolic tangent.")                                   \
    F(ATAN, atan, arctangent, 1, "Angle [rad] from -pi/2 to pi/2 of a tangent.")                  \
    F(ASIN, asin, arcsine, 1, "Angle [rad] from -pi/2 to pi/2 of a sine; nan beyond 1.")          \
    F(ACOS, acos, arccosine, -1, "Angle [rad] from 0 to pi of a cosine; nan beyond 1.")

#endif
