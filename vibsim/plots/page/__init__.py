"""The page that is drawn on: its sheet, words, numbers and labels; nothing of runs or sweeps."""
