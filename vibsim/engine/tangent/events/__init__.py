"""Effect of events on small disturbances: saltation matrices, and events crossed almost tangentially."""
