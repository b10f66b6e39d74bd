"""The regime of a motion from its stroboscopic section: recurrence, the 0-1 test, and how points follow."""
