"""Motion inside a mode: closed form by modal coordinates, Taylor series elsewhere."""
