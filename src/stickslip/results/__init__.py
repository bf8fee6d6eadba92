"""What every result can do: table, text, picture, file."""
