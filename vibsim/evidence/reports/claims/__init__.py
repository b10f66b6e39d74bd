"""Claims of the paper, and the findings on them: pure functions of the table of measured numbers."""
