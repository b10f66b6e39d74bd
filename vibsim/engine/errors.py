"""How a run on mode rows can fail."""


class EngineError(RuntimeError):
    """A run failed: `reason` ("accumulation", "diverged") and the `state` reached."""

    def __init__(self, reason, state):
        sentence = {
            "accumulation": "more than 64 events at one instant",
            "diverged": "the state is no longer finite",
        }[reason]
        super().__init__(f"{sentence}, at t = {state.t!s} s: x = {state.x}, v = {state.v}")
        self.reason, self.state = reason, state
