"""A Baxter to try things on: MuJoCo, the manufacturer's numbers, the real sensors' ways."""
