"""Where an event function is zero, whether none was missed, and which mode follows."""
