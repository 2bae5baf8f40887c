"""How the engines are compared: agreement, times, memory, targets, and the table."""
