"""Contact detection: initial contact table, search in a moving frame, contact properties and strength."""
