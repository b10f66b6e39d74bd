"""What happens between two neighbouring points of a branch: detected, parted, located."""
