"""The figures of the documents, a module a page or a kind."""
