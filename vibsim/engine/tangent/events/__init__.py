"""What events do to small disturbances: saltation matrices, and events crossed almost tangentially."""
