"""Small disturbances of the motion: exponents, the monodromy matrix, growth of errors."""
