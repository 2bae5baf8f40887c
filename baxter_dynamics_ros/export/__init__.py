"""The closed form in other languages: files that stand alone."""
