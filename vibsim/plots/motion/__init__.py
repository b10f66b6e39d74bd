"""What is drawn of a motion: samples, events and turns of a span, frequencies, and marks of them."""
