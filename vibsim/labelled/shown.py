"""What is shown of an object that is looked at: a heading and a few telling lines, in notebooks too."""

LABEL_WIDTH = 16


class Shown:
    """An object that says two things of itself, `heading()` and `lines()`; what is shown of it follows."""

    def heading(self) -> str:
        """What it is, in a line."""
        raise NotImplementedError

    def lines(self) -> list[tuple[str, str]]:
        """The few things that tell most about it: label and text."""
        raise NotImplementedError

    def __repr__(self) -> str:
        lines = [f"  {label:{LABEL_WIDTH}}{text}" for label, text in self.lines()]
        return "\n".join([f"<{type(self).__name__} {self.heading()}>", *lines])

    def _repr_html_(self) -> str:
        from vibsim.labelled.html import html_of

        return html_of(f"{type(self).__name__} {self.heading()}", self.lines())
