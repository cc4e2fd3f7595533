"""Scripts of the program: its manual in other forms, the readers of results, pictures."""
