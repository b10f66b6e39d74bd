"""Until when a run is right: a companion beside it, and the error that their distance shows; see `trust`."""
