"""Moving pictures: the machine itself beside its phase portrait and time history, as a film or a page."""
