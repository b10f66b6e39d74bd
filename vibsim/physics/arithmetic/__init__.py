"""Number types that scenes are computed in; elementary functions and sums that both engines round alike."""
