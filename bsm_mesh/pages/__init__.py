"""Pages: the report, the page to explore, the script for ParaView, summaries in a notebook."""
