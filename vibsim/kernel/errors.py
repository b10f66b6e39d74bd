"""What can go wrong inside an engine, and the sentence that tells it."""

from vibsim.engine.errors import EngineError

REASONS = {
    "accumulation": (
        "more than 64 events at one instant: the motion cannot be continued at double precision",
        "lower k2 or mu, or change the start values slightly",
    ),
    "diverged": (
        "the state is no longer finite",
        "check the parameters for values far outside each other's scale",
    ),
    "precision": (
        "more than 1000 digits would be needed to know the end of the run",
        "end it earlier: digits are lost in proportion to its length",
    ),
}


class KernelError(EngineError):
    """A run that failed inside an engine: cause, time, state and remedy in one line."""

    def __init__(self, reason, state):
        cause, remedy = REASONS[reason]
        self.reason, self.state = reason, state
        values = f"x1 = {state.x1!s} m, v1 = {state.v1!s} m/s, x2 = {state.x2!s} m, v2 = {state.v2!s} m/s"
        Exception.__init__(self, f"t = {state.t!s} s: {cause} ({values}); {remedy}")
