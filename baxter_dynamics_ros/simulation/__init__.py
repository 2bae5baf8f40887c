"""Simulated Baxter: MuJoCo with the manufacturer's description and a model of the sensors."""
