"""The report in words: a document without a shape, and the HTML and text made of it."""
