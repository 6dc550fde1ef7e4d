"""The pictures of the pages: what each shows, and how it is drawn."""
