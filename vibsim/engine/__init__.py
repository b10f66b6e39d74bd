"""The engine: motion from event to event on mode rows. It knows no part by name, only modes made of rows."""
