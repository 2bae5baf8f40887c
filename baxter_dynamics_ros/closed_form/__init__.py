"""The closed form on symbols: to derive it, to count it, and to write it in other languages."""
