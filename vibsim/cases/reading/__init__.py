"""From text to a validated case file: sources, `extends`, overrides, and all that is wrong, at its place."""
