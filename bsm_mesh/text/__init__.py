"""Numbers, tables, headings and notes in words, and what leaves by the terminal."""
