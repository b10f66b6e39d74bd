"""Pictures of cases: what a law of force or a motor is, before anything moves."""
