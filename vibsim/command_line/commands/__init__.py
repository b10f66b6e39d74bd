"""The commands of click, one in each module: what can be asked for, and whom to ask."""
