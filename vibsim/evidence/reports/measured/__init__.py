"""What is run and measured for the report, into one table of plain numbers."""
