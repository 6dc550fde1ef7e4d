"""Who touches whom: faces, the contact table, stiffness, forces."""
