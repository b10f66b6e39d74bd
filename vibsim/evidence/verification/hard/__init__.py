"""Hard cases, and the paper's: held against stored truths and closed forms."""
