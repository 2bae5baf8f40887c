"""What the documents measure: tables, and the data of figures."""
