"""Known impacts: oscillators that strike a stop, balls, several bodies at once (V13 to V15, V19, V20)."""
